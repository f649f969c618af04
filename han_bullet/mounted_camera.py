"""A camera as the stack knows it, from a world file or a calibration, and the detector that knows its cameras."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from han_bullet.detection.camera_detector import CameraDetector
from han_bullet.detection.detector import Detector
from han_bullet.detection.empty_seats import seats_in_view
from han_bullet.detection.pictures import Image
from han_bullet.detection.scan_limits import SHORTEST_SEATED, limits_on_floor
from han_bullet.geometry import Array, Intrinsics, SolidBox
from han_bullet.messages import Frame, Seat
from han_bullet.world_schema import Camera


@dataclass(frozen=True)
class MountedCamera:
    """A camera's lens and place.

    Attributes:
        name: Of the camera.
        intrinsics: Of its images.
        mount: Its pose, shape (4, 4): in the world if it is fixed there, else in the robot's body.
        fixed: Whether it never moves.
    """

    name: str
    intrinsics: Intrinsics
    mount: Array
    fixed: bool

    @classmethod
    def of_world(cls, camera: Camera) -> MountedCamera:
        """Return a camera of a world file."""
        return cls(camera.name, camera.intrinsics, camera.mount, camera.fixed)


def camera_detector(
    detector: Detector,
    cameras: Sequence[MountedCamera],
    empty_scenes: Mapping[str, Image],
    seats: Sequence[Seat],
    obstacles: Sequence[SolidBox],
) -> CameraDetector:
    """Return the detector for cameras, each of which tells how high people appear to it and which seats it shows.

    Args:
        detector: Of single images.
        cameras: In use; the robot's have the same place over the floor wherever it drives.
        empty_scenes: What fixed cameras see without people, by name.
        seats: Sitting areas of the map.
        obstacles: Walls and furniture.
    """
    areas = {c.name: limits_on_floor(c.intrinsics, c.mount, shortest=SHORTEST_SEATED) for c in cameras}
    in_view = {c.name: seats_in_view(seats, obstacles, c.intrinsics, c.mount) for c in cameras if c.fixed}
    found = CameraDetector(detector, areas, in_view)
    known = [camera for camera in cameras if camera.name in empty_scenes]
    empty = [Frame(c.name, 0.0, empty_scenes[c.name], c.intrinsics, c.mount, fixed=True) for c in known]
    found.calibrate(empty)
    found.rehearse(empty[:1])
    return found
