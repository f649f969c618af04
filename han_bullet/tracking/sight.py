"""Why a camera does not show somebody: the questions of the field of view, asked one by one, with names."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from han_bullet.geometry import Array, Pose2D, project
from han_bullet.messages import Frame
from han_bullet.tracking.field_of_view import (
    BODY_HEIGHT,
    BODY_MIDDLE,
    IMAGE_MARGIN,
    PERSON_HEIGHT,
    PERSON_RADIUS,
    ROBOT_HEIGHT,
    SMALLEST,
    FieldOfView,
    hidden_by_cylinder,
    lower_margin,
)

# Of an upright person's box: width over height, as detectors of pedestrians have it.
ASPECT = 0.41


def why_unseen(
    view: FieldOfView, frame: Frame, position: Array, robot: Pose2D | None, others: Mapping[str, Array]
) -> str | None:
    """Return why a frame does not show a standing person whole and large enough, or None where it does.

    Args:
        view: What hides people.
        frame: The camera; its pixels are not looked at.
        position: Of the person, shape (2,) [m].
        robot: Whose body hides what is behind it.
        others: Name -> place of the other people, shape (2,) [m].
    """
    return _not_in_image(frame, position) or _behind_what(view, frame, position, robot, others)


def expected_box(frame: Frame, position: Array, height: float = BODY_HEIGHT) -> Array | None:
    """Return the box, (x, y, width, height) [px], of an upright person at (x, y) [m]; None behind the camera.

    It may reach out of the image.
    """
    (foot, head), depths = _ends(frame, position, height)
    tall = float(foot[1] - head[1])
    if depths.min() <= 0.0 or tall <= 0.0:
        return None
    middle = 0.5 * (foot[0] + head[0])
    return np.array([middle - 0.5 * ASPECT * tall, head[1], ASPECT * tall, tall])


def _ends(frame: Frame, position: Array, height: float) -> tuple[Array, Array]:
    """Return the pixels (2, 2) of foot and head [px], and their depths (2,) [m]."""
    ends = np.array([[*position, 0.0], [*position, height]])
    return project(ends, frame.intrinsics, frame.camera_in_world)


def _not_in_image(frame: Frame, position: Array) -> str | None:
    (foot, head), depths = _ends(frame, position, BODY_HEIGHT)
    if depths.min() <= 0.0:
        return "behind the camera"
    width, height = frame.intrinsics.width, frame.intrinsics.height
    if max(foot[0], head[0]) < 0.0 or min(foot[0], head[0]) > width or foot[1] < 0.0 or head[1] > height:
        return "outside the image"
    borders = {
        "left": min(foot[0], head[0]) < IMAGE_MARGIN,
        "right": max(foot[0], head[0]) > width - IMAGE_MARGIN,
        "upper": min(foot[1], head[1]) < IMAGE_MARGIN,
        "lower": max(foot[1] + lower_margin(frame, foot[1] - head[1]), head[1] + IMAGE_MARGIN) > height,
    }
    cut = [name for name, is_cut in borders.items() if is_cut]
    if cut:
        return f"cut by the image's {' and '.join(cut)} border"
    tall = foot[1] - head[1]
    if tall < SMALLEST:
        return f"too far: the box would be {tall:.0f} px tall, and a miss counts from {SMALLEST:.0f} px on"
    return None


def _behind_what(
    view: FieldOfView, frame: Frame, position: Array, robot: Pose2D | None, others: Mapping[str, Array]
) -> str | None:
    here, eye = position[None], frame.camera_in_world[:3, 3]
    middle = np.array([[*position, BODY_MIDDLE]])
    for box in view.obstacles:
        if not box.contains(eye[:2]) and box.blocks(eye, middle)[0]:
            return f"hidden by {box.name}"
    cylinders = [(name, place, PERSON_RADIUS, PERSON_HEIGHT) for name, place in others.items()]
    if frame.fixed and robot is not None:
        cylinders.insert(0, ("the robot", robot.position, view.robot_radius, ROBOT_HEIGHT))
    for name, place, radius, height in cylinders:
        if hidden_by_cylinder(frame, here, place, radius, height)[0]:
            return f"hidden by {name}"
    return None
