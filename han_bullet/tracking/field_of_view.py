"""What a camera can see: whether a person at some place would be found in its image."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from han_bullet.errors import check_positive
from han_bullet.geometry import Array, Pose2D, SolidBox, project
from han_bullet.messages import Frame
from han_bullet.tracking.solids import Solids

# Of the person whose sight is asked for [m].
BODY_HEIGHT = 1.75
# Height that walls and furniture must not hide [m]: with less than half a person the detector finds nobody.
BODY_MIDDLE = 0.9
# Height that robot and other people must not hide [m]: whoever stands behind somebody is found badly or too near.
KNEES = 0.5
# Least height in the image [px]: of whoever is smaller the detector may give its smallest box, of 96 px, which is a
# measurement only where the feet are known (`projection.SMALLEST_BOX`).
SMALLEST = 114.0
# Between a whole person and the image's borders [px].
IMAGE_MARGIN = 6.0
# Between the feet and the lower border of a moving camera's image, in heights of the person: nearer, their box is no
# measurement (`projection.BORDER`, and boxes end 1.4 % below the feet). Fixed cameras know feet to the pixel.
LOWER_MARGIN = 0.065
# Of the cylinder around the robot's body [m]; the default of its radius is 0.3 and 0.05 for what sticks out.
ROBOT_RADIUS, ROBOT_HEIGHT = 0.35, 1.1
# Of the cylinder around another person [m].
PERSON_RADIUS, PERSON_HEIGHT = 0.25, 1.7


class FieldOfView:
    """Tell where a missing detection means that nobody is there.

    Args:
        obstacles: Walls and furniture of the map.
        robot_radius: Of the upright cylinder that hides what is behind the robot [m].

    Raises:
        BadInputError: `robot_radius` is not positive.
    """

    def __init__(self, obstacles: Sequence[SolidBox] = (), *, robot_radius: float = ROBOT_RADIUS) -> None:
        check_positive("field of view", robot_radius=robot_radius)
        self.obstacles = tuple(obstacles)
        self._solids = Solids(obstacles)
        self.robot_radius = robot_radius

    def sees(self, frame: Frame, positions: Array, *, robot: Pose2D | None = None) -> NDArray[np.bool_]:
        """Tell at which floor points, shape (n, 2) [m], a standing person would be found in the frame.

        Args:
            frame: The camera; its pixels are not looked at.
            positions: Where somebody may stand.
            robot: Whose body hides what is behind it; None, or a moving camera (it rides on the robot): nothing.
        """
        if not len(positions):
            return np.zeros(0, bool)
        visible = self._fits_in_image(frame, positions)
        if not visible.any():
            return visible
        if frame.fixed and robot is not None:
            visible &= ~hidden_by_cylinder(frame, positions, robot.position, self.robot_radius, ROBOT_HEIGHT)
        hidden = self._solids.hide(frame.camera_in_world[:3, 3], _at_height(positions, BODY_MIDDLE))
        return np.asarray(visible & ~hidden)

    def hidden_by_people(self, frame: Frame, positions: Array, people: Array) -> NDArray[np.bool_]:
        """Tell at which floor points, shape (n, 2) [m], people at other floor points, (k, 2) [m], hide somebody."""
        hidden = np.zeros(len(positions), bool)
        for person in people:
            hidden |= hidden_by_cylinder(frame, positions, person, PERSON_RADIUS, PERSON_HEIGHT)
        return hidden

    def _fits_in_image(self, frame: Frame, positions: Array) -> NDArray[np.bool_]:
        bodies = np.stack([_at_height(positions, 0.0), _at_height(positions, BODY_HEIGHT)])
        ends, depths = project(bodies, frame.intrinsics, frame.camera_in_world)
        size = np.array([frame.intrinsics.width, frame.intrinsics.height])
        inside = ((ends >= IMAGE_MARGIN) & (ends <= size - IMAGE_MARGIN)).all(axis=(0, 2))
        tall = ends[0, :, 1] - ends[1, :, 1]
        above = ends[0, :, 1] <= size[1] - lower_margin(frame, tall)
        fits: NDArray[np.bool_] = inside & above & (tall >= SMALLEST) & (depths > 0.0).all(axis=0)
        return fits


def lower_margin(frame: Frame, tall: Array | float) -> Array | float:
    """Return how far above the lower border the feet must be [px] of people who are so tall in the image [px]."""
    return IMAGE_MARGIN if frame.fixed else np.maximum(IMAGE_MARGIN, LOWER_MARGIN * tall)


def hidden_by_cylinder(
    frame: Frame, positions: Array, centre: Array, radius: float, height: float
) -> NDArray[np.bool_]:
    """Tell at which floor points, shape (n, 2) [m], an upright cylinder on the floor hides a person's knees.

    The line of sight sinks from the camera to the knees, so it is hidden where it is lower than the cylinder when it
    passes the cylinder's axis most closely. Only somebody farther from the camera than the whole cylinder is hidden, so
    nobody hides themselves.

    Args:
        frame: The camera.
        positions: Where somebody may stand.
        centre: Of the cylinder, shape (2,) [m].
        radius: Of the cylinder [m].
        height: Of the cylinder [m].
    """
    eye = frame.camera_in_world[:3, 3]
    along = positions - eye[:2]
    length = np.maximum(np.linalg.norm(along, axis=1), 1e-9)
    share = (along @ (centre - eye[:2])) / length**2
    gap = np.linalg.norm(eye[:2] + share[:, None] * along - centre, axis=1)
    level = eye[2] + share * (KNEES - eye[2])
    hidden: NDArray[np.bool_] = (share > 0.0) & (length * (1.0 - share) > radius) & (gap < radius) & (level < height)
    return hidden


def _at_height(positions: Array, height: float) -> Array:
    """Return points (n, 3) [m] above floor points (n, 2)."""
    return np.column_stack([positions, np.full(len(positions), height)])
