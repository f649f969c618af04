"""How long each stage takes."""

from collections.abc import Iterator
from typing import Any, cast

import pytest

from han_bullet.ros.stage_times import STAGES, StageTimes
from han_bullet.stack import NavigationStack


class Clock:
    """One that goes on when it is told to."""

    def __init__(self) -> None:
        self.time = 0.0

    def __call__(self) -> float:
        return self.time


class Stage:
    def __init__(self, clock: Clock, takes: float) -> None:
        self.clock, self.takes = clock, takes

    def update(self, *arguments: Any) -> Any:
        self.clock.time += self.takes
        return arguments

    detect = project = find = follow = limit = apply = update
    name = "static"


class Stack:
    """Like the real one in what is watched of it: it has stages, and a step."""

    def __init__(self, clock: Clock) -> None:
        for number, name in enumerate(STAGES):
            setattr(self, name, Stage(clock, 0.001 * (number + 1)))
        self.layers = [Stage(clock, 0.5)]

    def step(self, observation: object) -> object:
        for name, method in STAGES.items():
            assert getattr(getattr(self, name), method)(1, 2) == (1, 2)
        for layer in self.layers:
            layer.apply(1, 2)
        return observation


@pytest.fixture
def watched() -> Iterator[tuple[Clock, Stack, StageTimes]]:
    clock = Clock()
    stack, times = Stack(clock), StageTimes(clock)
    times.watch(cast(NavigationStack, stack))
    yield clock, stack, times


def test_each_stage_and_the_whole_tick_are_measured(watched: tuple[Clock, Stack, StageTimes]) -> None:
    _, stack, times = watched
    assert stack.step("seen") == "seen"
    expected = {name: 0.001 * (number + 1) for number, name in enumerate(STAGES)} | {"layer static": 0.5}
    assert times.mean == pytest.approx(expected | {"step": sum(expected.values())})


def test_the_rate_is_that_of_the_ticks_by_the_clock(watched: tuple[Clock, Stack, StageTimes]) -> None:
    clock, stack, times = watched
    stack.step(None)
    assert times.rate is None
    for tick in range(1, 100):
        clock.time = 0.1 * tick
        stack.step(None)
    assert times.rate == pytest.approx(10.0)


def test_every_stage_that_is_watched_is_one_of_the_stack() -> None:
    import inspect

    parameters = inspect.signature(NavigationStack.__init__).parameters
    assert set(STAGES) <= set(parameters)
