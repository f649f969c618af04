"""A picture of many small pictures: what a detector missed, or took for a person, at one glance."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array
from han_bullet.messages import Detections
from han_bullet.rendered_sequences import RenderedFrame

SIDE, COLUMNS, ROWS = 240, 8, 6  # [px], cells
CONTEXT = 1.5  # side of a cell, of the box's height
KEPT = 16 * COLUMNS * ROWS  # cells in memory; beyond it every second one goes
MARK, FOUND, TEXT = (220, 30, 30), (30, 200, 60), (255, 255, 255)


class ContactSheet:
    """Collects cells; saves at most COLUMNS x ROWS of them, spread evenly over all."""

    def __init__(self) -> None:
        self._cells: list[NDArray[np.uint8]] = []
        self._step, self._seen = 1, 0

    def add(self, frame: RenderedFrame, box: Array, found: Detections, caption: str) -> None:
        """Add a frame's part around a box, marked, with all that was found there."""
        self._seen += 1
        if self._seen % self._step:
            return
        x, y, width, height = box
        scale = SIDE / (CONTEXT * height)
        shift = 0.5 * SIDE - scale * np.array([x + 0.5 * width, y + 0.5 * height])
        placed = np.array([[scale, 0.0, shift[0]], [0.0, scale, shift[1]]])
        cell = cv2.warpAffine(frame.image, placed, (SIDE, SIDE))
        for each, score in zip(found.boxes, found.scores, strict=True):
            corner = _frame_box(cell, each, scale, shift, FOUND)
            cv2.putText(cell, f"{score:.0f}", corner, cv2.FONT_HERSHEY_SIMPLEX, 0.4, FOUND, 1, cv2.LINE_AA)
        _frame_box(cell, box, scale, shift, MARK)
        cv2.rectangle(cell, (0, 0), (SIDE, 28), (0, 0, 0), cv2.FILLED)
        for line, text in enumerate((f"take {frame.take}, {frame.frame.time:.1f} s", caption)):
            place = (3, 12 + 13 * line)
            cv2.putText(cell, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.38, TEXT, 1, cv2.LINE_AA)
        self._cells.append(cell)
        if len(self._cells) > KEPT:
            self._cells, self._step = self._cells[1::2], 2 * self._step

    def save(self, path: Path) -> None:
        """Write the sheet; nothing where there is nothing to show."""
        if not self._cells:
            return
        places = np.linspace(0, len(self._cells) - 1, min(len(self._cells), COLUMNS * ROWS)).astype(int)
        cells = [self._cells[place] for place in places]
        cells += [np.zeros_like(cells[0])] * (-len(cells) % COLUMNS)
        lines = [np.hstack(cells[first : first + COLUMNS]) for first in range(0, len(cells), COLUMNS)]
        cv2.imwrite(str(path), np.vstack(lines)[:, :, ::-1])


def _frame_box(
    cell: NDArray[np.uint8], box: Array, scale: float, shift: Array, colour: tuple[int, int, int]
) -> tuple[int, int]:
    """Draw a box of the frame into a cell; return its upper left corner there."""
    left, top = np.round(scale * box[:2] + shift).astype(int).tolist()
    right, bottom = np.round(scale * (box[:2] + box[2:]) + shift).astype(int).tolist()
    cv2.rectangle(cell, (left, top), (right, bottom), colour, 1, cv2.LINE_AA)
    return left, top
