"""What a run's tables tell over time: whom the stack knew how well."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from han_bullet.geometry import Array
from han_bullet.metrics.perceived import match
from han_bullet.report.run_files import Run


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
