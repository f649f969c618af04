"""The paper's figures, drawn anew from our own layers, planner and detector."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from matplotlib.figure import Figure

from han_bullet.atomic_file import write_at_once
from han_bullet.report.charts import png, styled, svg
from han_bullet.report.cost_figure import draw_costs
from han_bullet.report.pipeline_figure import draw_pipeline
from han_bullet.report.simulation_figure import draw_simulation

FIGURES: dict[str, Callable[[], Figure]] = {
    "costs": draw_costs,
    "sim1": lambda: draw_simulation("sim1"),
    "sim2": lambda: draw_simulation("sim2"),
    "pipeline": draw_pipeline,
}


def write_figures(folder: Path) -> Iterator[Path]:
    """Write every figure as PNG and SVG into a folder that exists, and yield each file as soon as it is there."""
    for name, draw in FIGURES.items():
        with styled():
            figure = draw()
            files = {"png": png(figure), "svg": svg(figure, outlines=True)}
        for ending, content in files.items():
            path = folder / f"{name}.{ending}"
            write_at_once(path, content)
            yield path
