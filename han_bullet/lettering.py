"""Anti-aliased text on pictures: OpenCV has only stroke fonts, so glyphs come from FreeType and are blended by mask."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Literal

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from han_bullet.geometry import Array

Picture = NDArray[np.uint8]
Colour = tuple[int, int, int]
Anchor = Literal["left", "centre", "right"]

HALO_WIDTH = 2  # [px] of the rim that keeps text readable on any ground
CACHED_TEXTS = 1024  # a frame has about 40, of which the numbers change


class Lettering:
    """Write text in DejaVu Sans, which comes with matplotlib and has digits of equal width."""

    def __init__(self) -> None:
        folder = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
        self._files = {False: folder / "DejaVuSans.ttf", True: folder / "DejaVuSans-Bold.ttf"}
        self._font = lru_cache(maxsize=None)(self._load)
        self._masks = lru_cache(maxsize=CACHED_TEXTS)(self._render)

    def width(self, text: str, size: int, bold: bool = False) -> int:
        """Return how wide a text is [px]."""
        return round(self._font(size, bold).getlength(text))

    def shorten(self, text: str, size: int, room: float) -> str:
        """Return a text cut to the words that fit into a width [px], with an ellipsis where some are missing."""
        words = text.split()
        for count in range(len(words), 0, -1):
            cut = " ".join(words[:count]) + ("" if count == len(words) else " …")
            if self.width(cut, size) <= room:
                return cut
        return ""

    def write(
        self,
        picture: Picture,
        text: str,
        place: Sequence[float] | Array,
        size: int,
        colour: Colour,
        *,
        bold: bool = False,
        anchor: Anchor = "left",
        halo: Colour | None = None,
    ) -> None:
        """Write one line of text; what lies outside the picture is cut off.

        Args:
            picture: RGB, shape (height, width, 3); changed.
            text: The line.
            place: Column of the anchor and row of the middle of capital letters [px].
            size: Of the font [px].
            colour: RGB.
            bold: Heavy letters.
            anchor: Which end of the text stands at `place`.
            halo: Colour of a soft rim, or None for none.
        """
        fill, rim, middle = self._masks(text, size, bold)
        shift = {"left": 0.0, "centre": 0.5, "right": 1.0}[anchor] * (fill.shape[1] - 2 * HALO_WIDTH)
        left, top = round(place[0] - shift) - HALO_WIDTH, round(place[1]) - middle
        if halo is not None:
            _blend(picture, rim, left, top, halo)
        _blend(picture, fill, left, top, colour)

    def _load(self, size: int, bold: bool) -> ImageFont.FreeTypeFont:
        return ImageFont.truetype(str(self._files[bold]), size)

    def _render(self, text: str, size: int, bold: bool) -> tuple[Picture, Picture, int]:
        """Return the masks of letters and rim, same shape, and the row in them of the middle of capital letters."""
        font = self._font(size, bold)
        ascent, descent = font.getmetrics()
        shape = (self.width(text, size, bold) + 2 * HALO_WIDTH, ascent + descent + 2 * HALO_WIDTH)
        masks = []
        for stroke in (0, HALO_WIDTH):
            mask = Image.new("L", shape)
            start = (HALO_WIDTH, HALO_WIDTH + ascent)
            ImageDraw.Draw(mask).text(start, text, fill=255, font=font, anchor="ls", stroke_width=stroke)
            masks.append(np.asarray(mask))
        capital_height = -font.getbbox("H", anchor="ls")[1]
        return masks[0], masks[1], round(HALO_WIDTH + ascent - 0.5 * capital_height)


def _blend(picture: Picture, mask: Picture, left: int, top: int, colour: Colour) -> None:
    """Paint a colour where the mask, placed with its upper left corner at (left, top), is bright."""
    rows = slice(max(top, 0), min(top + mask.shape[0], picture.shape[0]))
    columns = slice(max(left, 0), min(left + mask.shape[1], picture.shape[1]))
    if rows.start >= rows.stop or columns.start >= columns.stop:
        return
    ground = picture[rows, columns]
    visible = mask[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left, None]
    opacity = visible / np.float32(255)
    ground[:] = np.rint(ground + opacity * (np.array(colour, np.float32) - ground)).astype(np.uint8)
