import io

import pytest
from rich.console import Console
from ticks import tick

from han_bullet.progress import GETTING_READY, ProgressBar


@pytest.fixture
def drawn() -> io.StringIO:
    return io.StringIO()


def bar(drawn: io.StringIO) -> ProgressBar:
    return ProgressBar("hall", 10.0, Console(file=drawn, force_terminal=True, width=160))


def test_before_the_first_tick_it_says_that_the_run_gets_ready(drawn: io.StringIO) -> None:
    bar(drawn).close()
    assert GETTING_READY in drawn.getvalue()


def test_then_it_tells_the_simulated_time_and_the_status(drawn: io.StringIO) -> None:
    shown = bar(drawn)
    shown.record(tick(30))
    shown.close()
    shown.close()  # once by the episode, once by who drew it
    assert "1.5 s simulated" in drawn.getvalue()
    assert "moving" in drawn.getvalue()
