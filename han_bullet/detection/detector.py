"""The contract of every detector: one image in, the people in it out."""

from __future__ import annotations

from abc import ABC, abstractmethod

from han_bullet.detection.pictures import Image
from han_bullet.detection.search_area import SearchArea
from han_bullet.messages import Detections


class Detector(ABC):
    """Finds people in an image; a detector of one's own is a subclass with the one method `detect`.

    A detector of two stages also has `propose` and `decide`, whose succession is its `detect`: what rules out proposals
    in between, such as the empty scene of a fixed camera, then spares it the second stage.

    Attributes:
        smallest_area: Of the boxes that it can find [px^2]; 0 where it has no lower limit.
    """

    smallest_area: float = 0.0

    @abstractmethod
    def detect(self, image: Image) -> Detections:
        """Return the people in an image, RGB, shape (h, w, 3), uint8."""

    def propose(self, image: Image, area: SearchArea | None = None) -> Detections:
        """Return what the first stage gives; of a detector with one stage, all.

        Args:
            image: RGB, shape (h, w, 3), uint8.
            area: Where people may be: no other boxes are returned, and a detector that can need not look for them. None
                looks everywhere.
        """
        found = self.detect(image)
        return found if area is None else found.select(area.allow_boxes(found.boxes))

    def decide(self, image: Image, proposals: Detections) -> Detections:
        """Return those proposals of an image that the second stage keeps; of a detector with one stage, all."""
        return proposals
