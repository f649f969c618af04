"""A fixed camera of one's own: its place and its floor homography, from points of the floor marked in its image."""
