"""People whose ways cross: how often each association lets two of them swap their ids, over fixed seeds."""

from collections.abc import Callable

import numpy as np

from benchmarks.crowd import SCAN_PERIOD, Recording, measure, record
from benchmarks.track_quality import TrackQuality
from benchmarks.tracker import ours
from han_bullet.assembly import ASSOCIATIONS
from han_bullet.geometry import Array
from han_bullet.tracking.kalman import ConstantVelocity

SEEDS, SECONDS, SIDE = 12, 10.0, 12.0


def recordings(positions: Callable[[float], list[tuple[float, float]]]) -> list[Recording]:
    """Measure people, whose positions [m] are given by the time from the middle on [s], once with each seed."""
    scans = np.arange(round(SECONDS / SCAN_PERIOD))
    walked: Array = np.array([positions(k * SCAN_PERIOD - 0.5 * SECONDS) for k in scans])
    seen = []
    for seed in range(SEEDS):
        generator = np.random.default_rng(seed)
        seen.append(Recording(walked, tuple(measure(people, SIDE, generator) for people in walked)))
    return seen


def switches(seen: list[Recording], motion: ConstantVelocity) -> dict[str, int]:
    """Return the ID switches in all recordings, by the name of the association."""
    counts = dict.fromkeys(ASSOCIATIONS, 0)
    for name in counts:
        for recording in seen:
            step, quality = ours(name, motion)(recording), TrackQuality()
            for k, people in enumerate(recording.positions):
                quality.record(step(k), people)
            counts[name] += quality.id_switches
    return counts


def narrow_cross(time: float) -> list[tuple[float, float]]:
    """Two people walk abreast, on ways 10 degrees off the middle's, and are in one place at time 0."""
    along = 0.6 * time
    return [(6.0 + along, 6.0 + 0.088 * along), (6.0 + along, 6.0 - 0.088 * along)]


def head_on(time: float) -> list[tuple[float, float]]:
    """Two pairs in single file meet and pass at 0.4 m."""
    return [
        *((3.0 + 0.6 * (time + 5.0) - behind, 5.0) for behind in (0.0, 0.7)),
        *((9.0 - 0.6 * (time + 5.0) + behind, 5.4) for behind in (0.0, 0.7)),
    ]


def test_where_two_ways_cross_at_a_small_angle_the_joint_rules_swap_a_third_less_often() -> None:
    """For six seconds they are less than 0.3 m apart: no rule keeps all ids."""
    counts = switches(recordings(narrow_cross), ConstantVelocity())
    assert 0 < counts["nnjpda"] == counts["gnn"] <= 0.7 * counts["nn"]


def test_people_who_pass_each_other_at_arms_length_keep_their_ids_by_the_joint_rules_alone() -> None:
    counts = switches(recordings(head_on), ConstantVelocity(acceleration_deviation=1.5))
    assert counts["nnjpda"] == counts["gnn"] == 0
    assert counts["nn"] >= 4


def test_in_a_full_room_the_joint_rules_swap_ids_a_quarter_less_often() -> None:
    counts = switches([record(12, 5.0, 20.0, seed) for seed in range(4)], ConstantVelocity())
    assert 0 < counts["nnjpda"] <= 0.75 * counts["nn"]
    assert 0 < counts["gnn"] <= 0.75 * counts["nn"]
