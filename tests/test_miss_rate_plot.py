"""The curves of the miss rate: told apart, and none of them outside the picture."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes

from han_bullet.detection.evaluation import Evaluation
from han_bullet.miss_rate_plot import Curve, draw_miss_rates


def evaluation(found: int) -> Evaluation:
    """Return one of 100 images and 100 people, some found before 100 false positives."""
    hits = np.arange(found + 100) < found
    return Evaluation(np.arange(float(len(hits)))[::-1], hits, images=100, people=100)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """Return a list that gets every line drawn."""
    lines: list[object] = []
    plot = Axes.plot

    def kept(axes: Axes, *arguments: object, **options: object) -> object:
        new = plot(axes, *arguments, **options)
        lines.extend(new)
        return new

    monkeypatch.setattr(Axes, "plot", kept)
    return lines


@pytest.mark.parametrize("dashed", [False, True])
def test_thirteen_curves_differ_in_colour_or_line_style(tmp_path: Path, drawn: list, dashed: bool) -> None:
    curves = [Curve(f"model {number}", evaluation(30 + 5 * number), dashed) for number in range(13)]
    draw_miss_rates(tmp_path / "curves.png", curves)
    lines = [line for line in drawn if line.get_marker() == "None"]
    assert len(lines) == 13
    assert len({(line.get_color(), str(line._dash_pattern)) for line in lines}) == 13


def test_a_curve_without_misses_lies_within_the_picture_at_its_bottom(tmp_path: Path, drawn: list) -> None:
    draw_miss_rates(tmp_path / "curves.png", [Curve("perfect", evaluation(100)), Curve("half", evaluation(50))])
    line, dots = drawn[:2]
    lowest, highest = line.axes.get_ylim()
    assert (lowest, highest) == (0.001, 1.0)
    assert line.get_ydata().min() == dots.get_ydata().min() == pytest.approx(1.1 * lowest)
