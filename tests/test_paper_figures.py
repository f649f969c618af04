"""The paper's figures: costs that are the formulas', moments that are those meant, files that are whole."""

import math
import xml.etree.ElementTree
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from han_bullet.episode import Tick
from han_bullet.geometry import Array
from han_bullet.report import paper_figures
from han_bullet.report.charts import styled, svg
from han_bullet.report.cost_figure import Case, cases, costs_around, draw_costs
from han_bullet.report.paper_figures import write_figures
from han_bullet.report.pipeline_figure import channels_of, first_frame
from han_bullet.report.simulation_figure import draw_simulation

CASES = {case.title.split(" ($")[0]: case for case in cases()}


def cost_at(case: Case, x: float, y: float) -> float:
    """Cost of the cell whose lower left corner is at a place, to within the half per mille of a costmap's step."""
    columns, rows, g = costs_around(case)
    cell: Array = np.argwhere(np.isclose(columns, x + 0.025) & np.isclose(rows, y + 0.025))
    assert cell.shape == (1, 2)
    return float(g[tuple(cell[0])])


def gauss(*terms: tuple[float, float]) -> float:
    """exp of minus half the sum of squared distances over deviations, at the centre of the cell of `cost_at`."""
    return math.exp(-0.5 * sum((distance / deviation) ** 2 for distance, deviation in terms))


@pytest.mark.parametrize(
    ("name", "x", "y", "expected"),
    [
        ("standing", 0.5, 0.0, gauss((0.525, 0.56), (0.025, 0.56))),
        ("hand-over", 0.0, 0.7, 0.0),  # in the opening
        ("hand-over", 0.0, 0.5, gauss((0.525, 0.56), (0.025, 0.56))),  # nearer than the opening begins
        ("hand-over", 0.0, -0.7, gauss((0.675, 0.56), (0.025, 0.56))),
        ("seated", 0.0, -1.0, gauss((0.975, 1.2), (0.025, 0.8))),  # behind: g3 above g2
        ("seated", 0.0, 1.0, gauss((1.025, 0.56), (0.025, 0.56))),
        ("walking", 0.0, 1.0, gauss((1.025, 1.0), (0.025, 2 / 3))),  # at 1 m/s B is 1 m
        ("walking", 0.0, -1.0, gauss((0.975, 0.5), (0.025, 2 / 3))),
        ("walking, overtaken", 1.5, 0.0, gauss((1.525, 1.5), (0.025, 0.3))),  # the closed right
        ("walking, overtaken", -1.5, 0.0, gauss((1.475, 2 / 3), (0.025, 1.0))),  # the open left
    ],
)
def test_the_drawn_costs_are_the_formulas(name: str, x: float, y: float, expected: float) -> None:
    assert cost_at(CASES[name], x, y) == pytest.approx(expected, abs=0.5 / 252)


def test_every_case_has_a_surface_and_a_map_with_units() -> None:
    with styled():
        figure = draw_costs()
    axes = figure.axes[: 2 * len(CASES)]
    assert all("[m]" in ax.get_xlabel() for ax in axes)
    assert figure.axes[-1].get_ylabel() == "cost g"


def test_a_simulation_is_shown_at_start_change_passing_and_end(monkeypatch: pytest.MonkeyPatch) -> None:
    from han_bullet.report import simulation_figure

    filmed: list[list[Tick]] = []
    chosen: list[list[int]] = []

    def watched(ticks: list[Tick]) -> list[int]:
        filmed.append(list(ticks))
        chosen.append(original(ticks))
        return chosen[-1]

    original = simulation_figure.moments
    monkeypatch.setattr(simulation_figure, "moments", watched)
    with styled():
        figure = draw_simulation("sim1")
    ticks = filmed[0]
    start, change, passing, end = (ticks[index] for index in chosen[0])
    assert start.truth.people[0].posture.value == "standing" and change.truth.people[0].posture.value == "walking"
    walker, robot = passing.truth.people[0].pose_in_world, passing.truth.pose_robot_in_world
    forward, left = walker.to_body(robot.position)
    assert 0.0 <= forward < 0.1 and left > 0.75  # level, on the walker's left
    assert end is ticks[-1] and end.decision.status.value == "arrived"
    titles = [ax.get_title(loc="left") for ax in figure.axes[:4]]
    assert titles == [
        f"({letter}) {tick.truth.time:.1f} s"
        for letter, tick in zip("abcd", (start, change, passing, end), strict=True)
    ]


def test_the_disc_before_a_device_that_is_on_is_explained() -> None:
    with styled():
        (legend,) = draw_simulation("sim2").legends
    assert "disc: between viewer and tv while it is on" in [text.get_text() for text in legend.get_texts()]


def test_the_pipeline_starts_from_a_cameras_image_and_its_ten_channels() -> None:
    frame = first_frame()
    assert frame.image.shape == (480, 640, 3) and channels_of(frame).shape == (120, 160, 10)
    assert np.array_equal(frame.image, first_frame().image)


def _little_figure() -> Figure:
    figure = Figure(figsize=(2.0, 1.0), layout="constrained")
    axes = figure.add_subplot()
    axes.pcolormesh(np.arange(12.0).reshape(3, 4), rasterized=True)
    axes.set(title="a title", xlabel="x [m]")
    return figure


def test_every_figure_becomes_a_png_and_an_svg_that_never_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert list(paper_figures.FIGURES) == ["costs", "sim1", "sim2", "pipeline"]
    monkeypatch.setattr(paper_figures, "FIGURES", {"little": _little_figure})
    contents = []
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        paths = list(write_figures(tmp_path / name))
        assert [path.name for path in paths] == ["little.png", "little.svg"]
        contents.append([path.read_bytes() for path in paths])
    assert contents[0] == contents[1]
    assert contents[0][0].startswith(b"\x89PNG")
    assert xml.etree.ElementTree.fromstring(contents[0][1]).tag.endswith("svg")


def test_charts_carry_no_date() -> None:
    with styled():
        assert b"<dc:date>" not in svg(Figure())
