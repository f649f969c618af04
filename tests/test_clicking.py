"""Marking points with the mouse: matplotlib's own events in a figure without a window."""

from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.backend_bases import CloseEvent, KeyEvent, MouseEvent, NavigationToolbar2
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from han_bullet.calibration.clicking import ClickedImage, click_points, open_clicking
from han_bullet.calibration.points import MarkedPoints
from han_bullet.errors import BadInputError

Act = Callable[["Played"], None]


class Played(FigureCanvasAgg):
    """A canvas whose event loop plays one act after another, each until it stops the loop."""

    def __init__(self, figure: Figure, acts: list[Act]) -> None:
        super().__init__(figure)
        self.acts, self.running = acts, False
        NavigationToolbar2(self)

    def start_event_loop(self, timeout: float = 0) -> None:
        self.running = True
        while self.running:
            self.acts.pop(0)(self)

    def stop_event_loop(self) -> None:
        self.running = False


def click(u: float, v: float, button: int = 1) -> Act:
    def act(canvas: Played) -> None:
        x, y = canvas.figure.axes[0].transData.transform((u, v))
        MouseEvent("button_press_event", canvas, x, y, button)._process()

    return act


def press(key: str) -> Act:
    return lambda canvas: KeyEvent("key_press_event", canvas, key)._process()


def zoom(canvas: Played) -> None:
    """Press the toolbar's button that begins and ends zooming."""
    canvas.toolbar.zoom()


def close(canvas: Played) -> None:
    CloseEvent("close_event", canvas)._process()


def played(
    acts: list[Act], answers: list[str], before: list[list[float]] | None = None
) -> tuple[MarkedPoints, list, list]:
    """What comes of acts in the window and answers in the terminal: points, questions, how many were kept when."""
    figure = Figure()
    canvas = Played(figure, acts)
    window = ClickedImage(figure, np.zeros((480, 640, 3), np.uint8))
    questions: list[str] = []
    kept: list[int] = []

    def ask(question: str) -> str:
        questions.append(question)
        return answers.pop(0)

    points = click_points(window, MarkedPoints.of_rows(before or []), ask, lambda points: kept.append(len(points)))
    assert not canvas.acts and not answers
    return points, questions, kept


def test_each_click_with_its_place_is_a_point_kept_at_once_until_enter() -> None:
    points, questions, kept = played(
        [click(310.5, 402.25), click(100.0, 300.0), press("enter")], ["3 0", "6.0, 1.5, 0.2"]
    )
    assert points.pixels == pytest.approx(np.array([[310.5, 402.25], [100.0, 300.0]]), abs=1e-6)
    assert points.points_in_world.tolist() == [[3.0, 0.0, 0.0], [6.0, 1.5, 0.2]]
    assert questions[0] == "point 1 at u 310.5, v 402.2: x, y [m]: "
    assert kept == [1, 2]


def test_points_go_on_where_the_file_ended() -> None:
    before = [[310.5, 402.25, 3.0, 0.0, 0.0]]
    points, questions, kept = played([click(100.0, 300.0), press("escape")], ["6 1"], before)
    assert points.rows()[0] == before[0] and len(points) == 2
    assert questions[0].startswith("point 2 at") and kept == [2]


def test_an_empty_answer_forgets_the_click_and_nonsense_is_asked_again() -> None:
    points, questions, _ = played(
        [click(10.0, 20.0), click(30.0, 40.0), press("enter")], ["", "1", "1 x", "1 nan", "1 2 3 4", "1 2"]
    )
    assert len(points) == 1 and points.points_in_world.tolist() == [[1.0, 2.0, 0.0]]
    assert points.pixels[0] == pytest.approx([30.0, 40.0])
    assert sum(question.startswith("two numbers") for question in questions) == 4


def test_zooming_other_buttons_and_other_keys_are_no_points() -> None:
    acts = [zoom, click(10.0, 20.0), zoom, click(10.0, 20.0, button=3), press("z"), press("enter")]
    points, questions, _ = played(acts, [])
    assert len(points) == 0 and questions == []


def test_closing_the_window_ends_it_also_while_a_place_is_asked() -> None:
    assert len(played([close], [])[0]) == 0
    figure = Figure()
    canvas = Played(figure, [click(10.0, 20.0)])
    window = ClickedImage(figure, np.zeros((480, 640, 3), np.uint8))

    def ask(question: str) -> str:
        close(canvas)
        return "1 2"

    assert len(click_points(window, MarkedPoints.of_rows([]), ask, lambda points: None)) == 1


def test_without_a_display_it_says_what_else_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    with pytest.raises(BadInputError, match="--click needs a display, and there is none; list the points in a file"):
        open_clicking(np.zeros((48, 64, 3), np.uint8))
