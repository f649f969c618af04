"""What a run's tables tell over time: whom the stack knew how well."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from han_bullet.geometry import Array
from han_bullet.metrics.perceived import match
from han_bullet.report.run_files import Run
from han_bullet.world_schema import CONTROL_PERIOD


def position_errors(run: Run) -> Mapping[str, Array]:
    """Return per person how far the matched track is from them at each tick, shape (n,) [m]; NaN where none is.

    Tracks and people are paired as for the metric tracked_share.
    """
    trace = run.trace
    errors = np.full((len(trace.people), len(trace.time)), math.nan)
    places = np.array([person.places for person in trace.people]).reshape(-1, len(trace.time), 2)
    for row, tick in enumerate(np.rint(trace.time / CONTROL_PERIOD).astype(int).tolist()):
        if tick in run.tracks and len(trace.people):
            tracked = np.array([track.state[:2] for track in run.tracks[tick]])
            for track, person in match(tracked, places[:, row]):
                errors[person, row] = math.dist(tracked[track], places[person, row])
    return {person.name: errors[index] for index, person in enumerate(trace.people)}
