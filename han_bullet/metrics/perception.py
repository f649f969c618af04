"""The numbers of a run that compare what the robot believed of people with the truth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from han_bullet.episode import Tick
from han_bullet.metrics.detections import FrameTally, Visibility
from han_bullet.metrics.known_people import KnownPeople
from han_bullet.metrics.perceived import Perceived, distances_between, match_distances
from han_bullet.metrics.perception_part import PerceptionPart
from han_bullet.metrics.tally import Definitions, Tally, Value
from han_bullet.metrics.tracks import StrayTracks, TrackErrors, TrackingScores
from han_bullet.tracking.field_of_view import FieldOfView


class PerceptionTally(Tally):
    """How well people were seen inside the loop: pairs tracks and people once per tick, for all its parts.

    Args:
        people: Names, for metrics that exist also where nothing was recorded.
        view: Tells which floor points a frame sees a whole person at.
    """

    group = "perception"
    definitions: ClassVar[Definitions] = {
        name: definition
        for part in (TrackErrors, TrackingScores, KnownPeople, StrayTracks, FrameTally)
        for name, definition in part.definitions.items()
    }

    def __init__(self, people: Sequence[str], view: FieldOfView) -> None:
        self._visibility = Visibility(view)
        self._frames = FrameTally(people)
        self._parts: tuple[PerceptionPart, ...] = (
            TrackErrors(),
            TrackingScores(),
            KnownPeople(people),
            StrayTracks(),
        )

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        people, tracks = tick.truth.people, tick.decision.people
        true_positions = np.array([p.pose_in_world.position for p in people]).reshape(-1, 2)
        positions = np.array([t.position_in_world for t in tracks]).reshape(-1, 2)
        self._frames.record(tick, true_positions, self._visibility.look(tick, true_positions))
        distances = distances_between(positions, true_positions)
        perceived = Perceived(
            time=tick.truth.time,
            people=people,
            tracks=tracks,
            pairs=tuple(match_distances(distances)),
            distances=distances,
            shown=self._visibility.newest(len(people)),
            with_cameras=self._visibility.with_cameras,
        )
        for part in self._parts:
            part.update(perceived)

    def values(self) -> dict[str, Value]:
        """Return errors, scores, shares and counts."""
        values: dict[str, Value] = {}
        for part in self._parts:
            values |= part.values()
        return values | self._frames.values()
