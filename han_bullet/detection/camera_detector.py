"""People in the frames of several cameras: any image detector, joined with the empty scenes of fixed cameras."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from han_bullet.detection.detector import Detector
from han_bullet.detection.still_scene import StillScene, may_hold
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
    """

    def __init__(self, detector: Detector) -> None:
        self.detector = detector
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
            self._scenes[frame.camera] = StillScene(frame.image, self.detector.propose(frame.image).boxes)

    def detect(self, frames: Sequence[Frame]) -> list[FrameDetections]:
        """Return the people in each frame, in the order of the frames, as the image detector orders them."""
        return [self._find(frame).at(frame.camera, frame.time) for frame in frames]

    def _find(self, frame: Frame) -> Detections:
        scene = self._scenes.get(frame.camera) if frame.fixed else None
        if scene is None:
            return self.detector.detect(frame.image)
        changes = scene.changes(frame.image)
        if not may_hold(changes, self.detector.smallest_area):
            return Detections.none()
        proposals = self.detector.propose(frame.image)
        return self.detector.decide(frame.image, proposals.select(scene.keep(changes, proposals.boxes)))
