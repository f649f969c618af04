"""Names of the coordinate frames on ROS: map -> odom -> base_link -> what the robot carries."""

MAP, ODOM, BASE, LASER = "map", "odom", "base_link", "laser"


def optical_frame(camera: str) -> str:
    """Return the frame of a camera's images: x right, y down, z along the view, as this program has it too."""
    return f"{camera}_optical_frame"
