"""From an image to boxes around people: ACF proposals and a CNN that decides."""
