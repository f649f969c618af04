"""How long the robot takes to react, by the wall clock: what no result depends on."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from han_bullet.episode import Hook, Tick
from han_bullet.messages import Observation
from han_bullet.sim.renderer import FrameSource, Image
from han_bullet.sim.scene_state import SceneState


class Latency(Hook):
    """From each observation to its command; with frames, from the moment at which the pictures are asked for.

    Only so are runs alike whose pictures are looked at by worker processes, which detect as soon as they have rendered,
    before there is an observation. The time that a picture takes to be rendered therefore counts as part of its
    latency, as that of reading out a real camera would.

    Args:
        clock: Returns the time [s].
    """

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._exposed_at = self._began_at = 0.0  # [s]
        self._taken: dict[bool, list[float]] = {False: [], True: []}  # [s], by whether there were frames

    def watched(self, frames: FrameSource) -> FrameSource:
        """Return a source of the same frames that tells when they are asked for."""
        return _WatchedFrames(frames, self)

    def expose(self) -> None:
        """Take note that pictures are asked for."""
        self._exposed_at = self._clock()

    def observe(self, observation: Observation) -> None:
        """Take note that an observation is there."""
        self._began_at = self._exposed_at if observation.images else self._clock()

    def record(self, tick: Tick) -> None:
        """Take note that its command is there."""
        self._taken[bool(tick.observation.images)].append(self._clock() - self._began_at)

    def timings(self) -> dict[str, float | None]:
        """Return median, 95th percentile and largest [ms] over all ticks and over those with frames; None over none."""
        seeing = self._taken[True]
        of = {"latency": [*seeing, *self._taken[False]], "latency_with_frames": seeing}
        return {
            f"{name}_{what}_ms": round(1e3 * float(np.percentile(taken, share)), 3) if taken else None
            for name, taken in of.items()
            for what, share in (("median", 50.0), ("p95", 95.0), ("max", 100.0))
        }


class _WatchedFrames(FrameSource):
    """A source of frames, and who wants to know when it is asked."""

    def __init__(self, frames: FrameSource, latency: Latency) -> None:
        self._frames = frames
        self._latency = latency

    def render(self, cameras: Sequence[str], state: SceneState) -> list[Image]:
        """Return what the source does."""
        self._latency.expose()
        return self._frames.render(cameras, state)
