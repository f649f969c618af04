"""What a run's tables tell over time: when devices went on, and whom the stack knew how well."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from han_bullet.geometry import Array, Pose2D
from han_bullet.metrics.perceived import match
from han_bullet.report.run_files import Run, Trace
from han_bullet.sim.devices import Television
from han_bullet.sim.trigger import RobotNow
from han_bullet.world_schema import World


def device_moments(world: World, trace: Trace) -> dict[str, float]:
    """Return when each device went on [s], those that never did left out; what triggers it is asked at every tick."""
    moments: dict[str, float] = {}
    for tv in world.devices:
        device = Television(tv)
        for time, pose, speed in zip(trace.time.tolist(), trace.poses.tolist(), trace.speed.tolist(), strict=True):
            device.advance(RobotNow(time, Pose2D(*pose), speed))
            if device.on:
                moments[tv.name] = time
                break
    return moments


def position_errors(run: Run) -> Mapping[str, Array]:
    """Return per person how far the matched track is from them at each tick, shape (n,) [m]; NaN where none is.

    Tracks and people are paired as for the metric tracked_share.
    """
    trace = run.trace
    errors = np.full((len(trace.people), len(trace.time)), math.nan)
    places = np.array([person.places for person in trace.people]).reshape(-1, len(trace.time), 2)
    for tick, time in enumerate(trace.time.tolist()):
        if time in run.tracks and len(trace.people):
            _, tracked = run.tracks[time]
            for track, person in match(tracked, places[:, tick]):
                errors[person, tick] = math.dist(tracked[track], places[person, tick])
    return {person.name: errors[index] for index, person in enumerate(trace.people)}
