"""The miss rate over false positives per image, drawn as the field draws it [Dollar2012]."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from han_bullet.atomic_file import write_at_once
from han_bullet.detection.evaluation import REFERENCE_RATES, Evaluation
from han_bullet.geometry import Array

RATES = (1e-3, 1e1)  # false positives per image
MISS_RATES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.64, 0.8, 1.0)  # ticks
LOWEST = 0.03  # miss rate shown, unless a curve falls below it
COLOURS = 10  # of matplotlib, which then begin anew
Style = str | tuple[int, tuple[int, ...]]
WHOLE: tuple[Style, ...] = ("-", "-.", (0, (8, 1, 1, 1, 1, 1)))
DASHED: tuple[Style, ...] = ("--", ":", (0, (6, 4)))


@dataclass(frozen=True)
class Curve:
    """A line of the picture.

    Attributes:
        name: For the legend.
        evaluation: What is drawn.
        dashed: Whether as dashes.
    """

    name: str
    evaluation: Evaluation
    dashed: bool = False


def draw_miss_rates(path: Path, curves: Sequence[Curve]) -> None:
    """Write a picture of curves; the dots are the nine points whose mean the legend tells.

    Args:
        path: File to write, .png.
        curves: In any order; the best comes first in the legend.
    """
    figure = Figure(figsize=(9.0, 7.5), layout="constrained")
    axes = figure.add_subplot()
    best_first = sorted(curves, key=lambda curve: curve.evaluation.log_average_miss_rate())
    reached = min(float(curve.evaluation.reference_miss_rates().min()) for curve in curves)
    lowest = max(min(LOWEST, 0.7 * reached), 1e-3)
    for number, curve in enumerate(best_first):
        styles = DASHED if curve.dashed else WHOLE
        _draw(axes, curve, f"C{number % COLOURS}", styles[number // COLOURS % len(styles)], lowest)
    axes.set(xscale="log", yscale="log")
    axes.set_yticks(MISS_RATES, [f"{rate:g}" for rate in MISS_RATES])
    axes.minorticks_off()
    axes.set(xlim=RATES, ylim=(lowest, 1.0))
    axes.grid(color="0.85")
    axes.set(xlabel="false positives per image", ylabel="miss rate")
    figure.legend(loc="outside lower left", ncols=2, fontsize="small", title="log-average miss rate", alignment="left")
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=120)
    write_at_once(path, content.getvalue())


def _draw(axes: Axes, curve: Curve, colour: str, style: Style, lowest: float) -> None:
    """Draw a curve as the steps it is, one without misses just above the lowest miss rate shown.

    Before its first detection everybody is missed.
    """
    false_positives, miss_rates = curve.evaluation.curve()
    rates = np.maximum(np.concatenate([[0.0], false_positives]), 1e-9)  # a logarithmic axis has no zero
    label = f"{curve.evaluation.log_average_miss_rate():.2%}  {curve.name}"
    (line,) = axes.plot(rates, _shown(np.concatenate([[1.0], miss_rates]), lowest), color=colour, label=label)
    line.set(drawstyle="steps-post", linestyle=style, linewidth=1.0 if curve.dashed else 2.0)
    axes.plot(
        REFERENCE_RATES, _shown(curve.evaluation.reference_miss_rates(), lowest), "o", color=colour, markersize=4.0
    )


def _shown(miss_rates: Array, lowest: float) -> Array:
    """Lift what a logarithmic axis cannot show, no misses, to just above its lower end."""
    return np.where(miss_rates > 0.0, miss_rates, 1.1 * lowest)
