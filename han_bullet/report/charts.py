"""One style for all charts: colours that colour-blind readers tell apart, quiet axes, the same bytes each time."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator, Sequence
from typing import Literal

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from han_bullet.geometry import Array

# [Okabe2008] without yellow, which is too pale for lines on white.
BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY, BLACK = (
    *("#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#202630"),
)
PEOPLE = (VERMILION, GREEN, PURPLE, ORANGE, SKY)
ROBOT = BLUE
GREY, PALE = "#5b6472", "#d9dee6"
SPEEDS = "viridis"  # even to the eye, also in grey
COSTS = "magma_r"  # the dearer, the darker

_STYLE = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.labelcolor": GREY,
    "axes.edgecolor": GREY,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "text.color": BLACK,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "lines.linewidth": 1.4,
    "lines.solid_capstyle": "round",
    "svg.hashsalt": "han_bullet",
    "svg.fonttype": "none",
    "figure.facecolor": "white",
}


@contextlib.contextmanager
def styled() -> Iterator[None]:
    """Draw within this, and every chart looks alike."""
    with matplotlib.rc_context(_STYLE):
        yield


def svg(figure: Figure, *, outlines: bool = False) -> bytes:
    """Return a figure as an SVG file, the same bytes every time.

    Args:
        figure: Drawn within `styled`.
        outlines: Whether letters become shapes, so that they look the same where our font is missing.
    """
    content = io.BytesIO()
    with matplotlib.rc_context({"svg.fonttype": "path" if outlines else "none"}):
        figure.savefig(content, format="svg", metadata={"Date": None, "Creator": None})
    return content.getvalue()


def png(figure: Figure, dots_per_inch: int = 200) -> bytes:
    """Return a figure as a PNG file, the same bytes every time."""
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=dots_per_inch, metadata={"Software": None})
    return content.getvalue()


def person_colour(index: int) -> str:
    """Return the colour of a person, by their place in the world file."""
    return PEOPLE[index % len(PEOPLE)]


def write_beside(
    axes: Axes,
    words: str,
    place: Sequence[float] | Array,
    offset: tuple[float, float],
    colour: str = BLACK,
    align: Literal["left", "center", "right"] = "center",
) -> None:
    """Write words at an offset (right, up) [1/72 inch] from a place of the chart, (2,)."""
    x, y = float(place[0]), float(place[1])
    axes.annotate(words, (x, y), offset, textcoords="offset points", ha=align, fontsize=7.5, color=colour, zorder=7)


def grid(axes: Axes) -> None:
    """Draw pale lines at the ticks."""
    axes.grid(color=PALE, linewidth=0.5)
    axes.set_axisbelow(True)
