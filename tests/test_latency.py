"""Latency by a clock that the test turns."""

from collections.abc import Sequence

import numpy as np
import pytest
from ticks import frame, tick

from han_bullet.geometry import Pose2D
from han_bullet.latency import Latency
from han_bullet.sim.renderer import FrameSource, Image
from han_bullet.sim.scene_state import RobotPosture, SceneState

STATE = SceneState(0.0, 0, RobotPosture(Pose2D(0.0, 0.0, 0.0)), ())


class Clock:
    """A clock that stands until it is turned [s]."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


class SlowFrames(FrameSource):
    """Frames that take 30 ms."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock

    def render(self, cameras: Sequence[str], state: SceneState) -> list[Image]:
        self.clock.now += 0.030
        return [np.full((2, 2, 3), len(camera), np.uint8) for camera in cameras]


def live(latency: Latency, clock: Clock, thinking: float, frames: FrameSource | None = None) -> None:
    """Let a tick pass whose stack thinks so long [s]; physics before it takes a whole second."""
    clock.now += 1.0
    if frames is not None:
        frames.render(["a"], STATE)
    one = tick(0, frames=[frame(time=0.0)] if frames is not None else [])
    latency.observe(one.observation)
    clock.now += thinking
    latency.record(one)


def test_without_frames_a_command_takes_what_the_stack_takes() -> None:
    clock = Clock()
    latency = Latency(clock)
    for thinking in (0.002, 0.004, 0.009):
        live(latency, clock, thinking)
    timings = latency.timings()
    assert timings["latency_median_ms"] == pytest.approx(4.0)
    assert timings["latency_max_ms"] == pytest.approx(9.0)
    assert timings["latency_p95_ms"] == pytest.approx(8.5)
    assert [timings[f"latency_with_frames_{what}_ms"] for what in ("median", "p95", "max")] == [None] * 3


def test_with_frames_it_begins_when_the_pictures_are_asked_for() -> None:
    clock = Clock()
    latency = Latency(clock)
    frames = latency.watched(SlowFrames(clock))
    for thinking, source in ((0.010, frames), (0.002, None), (0.002, None)):
        live(latency, clock, thinking, source)
    timings = latency.timings()
    assert timings["latency_with_frames_median_ms"] == timings["latency_with_frames_max_ms"] == pytest.approx(40.0)
    assert timings["latency_median_ms"] == pytest.approx(2.0)
    assert timings["latency_max_ms"] == pytest.approx(40.0)


def test_a_watched_source_gives_the_same_pictures() -> None:
    source = SlowFrames(Clock())
    for own, watched in zip(
        source.render(["a", "bc"], STATE), Latency().watched(source).render(["a", "bc"], STATE), strict=True
    ):
        np.testing.assert_array_equal(own, watched)
