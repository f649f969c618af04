"""People in the frames of several cameras: any image detector, joined with what is known of each camera.

That is where people of plausible heights may stand before it, and what a fixed camera sees without people.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace

from han_bullet.detection.detector import Detector
from han_bullet.detection.empty_seats import SeatInView
from han_bullet.detection.image_health import image_health
from han_bullet.detection.search_area import Both, SearchArea
from han_bullet.detection.still_scene import Changes, StillScene
from han_bullet.errors import BadInputError
from han_bullet.messages import Detections, Frame, FrameDetections


class FrameDetector(ABC):
    """Something that finds people in frames, which tell their camera and time."""

    @abstractmethod
    def detect(self, frames: Sequence[Frame]) -> list[FrameDetections]:
        """Return the people in each frame, in the order of the frames."""


class CameraDetector(FrameDetector):
    """Applies an image detector to frames; of calibrated fixed cameras, only where something differs from their scene.

    Args:
        detector: Looks at one image at a time.
        areas: Where people may be in the images of a camera, by its name, such as `limits_on_floor` tells; nothing else
            is looked at. Images of other cameras may show people anywhere.
        seats: Which seats a fixed camera has in view, by its name, to tell which of them are empty.
    """

    def __init__(
        self,
        detector: Detector,
        areas: Mapping[str, SearchArea] | None = None,
        seats: Mapping[str, Sequence[SeatInView]] | None = None,
    ) -> None:
        self.detector = detector
        self._areas = dict(areas or {})
        self._seats = dict(seats or {})
        self._scenes: dict[str, StillScene] = {}

    def calibrate(self, frames: Sequence[Frame]) -> None:
        """Learn the empty scene of fixed cameras.

        Args:
            frames: One person-free frame per camera; a second one of the same camera replaces the first.

        Raises:
            BadInputError: A frame is of a camera that moves.
        """
        for frame in frames:
            if not frame.fixed:
                raise BadInputError(f"camera {frame.camera!r} moves and has no empty scene; calibrate fixed ones")
            mistakes = self.detector.propose(frame.image, self._areas.get(frame.camera))
            self._scenes[frame.camera] = StillScene(frame.image, mistakes.boxes)

    def rehearse(self, frames: Sequence[Frame]) -> None:
        """Look at the negatives of empty scenes, where all has changed, to load compiled code before time counts."""
        self.detect([replace(frame, image=255 - frame.image) for frame in frames])

    def detect(self, frames: Sequence[Frame]) -> list[FrameDetections]:
        """Return the people in each frame, in the order of the frames, as the image detector orders them."""
        return [self._look(frame) for frame in frames]

    def _look(self, frame: Frame) -> FrameDetections:
        scene = self._scenes.get(frame.camera) if frame.fixed else None
        area = self._areas.get(frame.camera)
        if scene is None:
            found = self.detector.decide(frame.image, self.detector.propose(frame.image, area))
            return found.at(frame.camera, frame.time, image_health(frame.image))
        changes = scene.changes(frame.image)
        found = self._find(frame, scene, changes)
        return found.at(frame.camera, frame.time, image_health(frame.image, scene.shift(frame.image, changes)))

    def _find(self, frame: Frame, scene: StillScene, changes: Changes) -> Detections:
        area = self._areas.get(frame.camera)
        empty = tuple(seat.name for seat in self._seats.get(frame.camera, ()) if seat.is_empty(changes))
        if not changes.may_hold(self.detector.smallest_area):
            return replace(Detections.none(), empty_seats=empty)
        proposals = self.detector.propose(frame.image, changes if area is None else Both(area, changes))
        found = self.detector.decide(frame.image, proposals.select(scene.keep(changes, proposals.boxes)))
        return replace(found, feet=scene.feet(frame.image, found.boxes), empty_seats=empty)
