"""The figures of a run: every metric's one definition, and the hook that counts them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from han_bullet.assembly import field_of_view
from han_bullet.episode import Hook, Tick
from han_bullet.perception_tally import MATCH_WITHIN, STEADY_AFTER, PerceptionTally
from han_bullet.social_tallies import (
    BEHIND_DEVIATION,
    BESIDE_DEVIATION,
    EARLY,
    HandOverTally,
    PassingTally,
    SeatedTally,
    TransitTally,
)
from han_bullet.tallies import (
    LEVEL_WITHIN,
    NEW_CONTACT_AFTER,
    PERSON_RADIUS,
    PERSONAL_SPACE,
    STILL_SPEED,
    ContactTally,
    EncounterTally,
    MotionTally,
    Tally,
    Value,
)
from han_bullet.tracking.field_of_view import SMALLEST
from han_bullet.world_schema import HandOverTask, Sit, World

_CONTACT = (
    f"number of separate contacts of the robot with {{}}: signed distance <= 0 m; a touch of the same body counts "
    f"again after {NEW_CONTACT_AFTER:g} s without; lower is better"
)
_MATCHED = (
    f"matched: paired in the assignment of confirmed tracks to true people that has most pairs within "
    f"{MATCH_WITHIN:g} m and then the least sum of distances"
)
_POSSIBLE = (
    f"from the first frame in which a standing person there could be found (whole in the image, {SMALLEST:g} px tall, "
    "no wall or furniture before them), or the first match where that is sooner"
)

# Metrics of one person carry that person's name behind a dot: minimum_distance.walker.
DEFINITIONS: dict[str, tuple[str, str]] = {
    "outcome": (
        "",
        "how the task ended: arrived, blocked (the way or the goal not free for too long), timeout (neither in time)",
    ),
    "time_to_goal": ("s", "from the first tick to the first that has arrived; none where the robot did not arrive"),
    "path_length": ("m", "sum of the true distances between the robot's centres of consecutive ticks"),
    "mean_speed": ("m/s", "mean over all ticks of the robot's true translational speed, standing included"),
    "max_speed": ("m/s", "largest true translational speed of the robot at a tick"),
    "max_acceleration": ("m/s^2", "largest change of the robot's true velocity in the world between ticks, by time"),
    "stalled_time": (
        "s",
        f"time with a true speed below {STILL_SPEED:g} m/s, after the robot first exceeded that and before arrival; "
        "lower is better",
    ),
    "cumulative_heading_change": ("rad", "sum of the absolute turns of the robot's true yaw between ticks"),
    "contacts_person": ("1", _CONTACT.format("people")),
    "contacts_wall": ("1", _CONTACT.format("walls")),
    "contacts_object": ("1", _CONTACT.format("furniture and devices")),
    "personal_space_share": (
        "1",
        f"share of ticks in which the robot's centre has g > {PERSONAL_SPACE:g} for somebody, g being the personal "
        "space cost (g1 walking, g2 otherwise, peak 1) of the true person; lower is better",
    ),
    "minimum_distance": ("m", "smallest true distance between the centres of robot and person"),
    "minimum_gap": (
        "m",
        f"smallest true distance between the surfaces: centres less the robot's radius and {PERSON_RADIUS:g} m of "
        "person; negative where the discs overlap",
    ),
    "overtaking_side": (
        "",
        "left or right: the person's side on which the robot was when it last drew level from behind, i.e. its forward "
        f"coordinate in the person's frame turned from negative to positive while the person walked faster than "
        f"{STILL_SPEED:g} m/s within {LEVEL_WITHIN:g} m; none where it never did",
    ),
    "distance_when_level": ("m", "true distance between the centres at that moment; none where it never came"),
    "passing_side": (
        "",
        f"left or right: the side of the robot's direction of motion (faster than {STILL_SPEED:g} m/s) on which the "
        "person was when their centres were nearest; none where the robot never moved",
    ),
    "behind_seated": (
        "1",
        f"largest g3 at the robot's centre, of the true person while seated: exp(-u^2 / (2 {BEHIND_DEVIATION:g}^2) - "
        f"v^2 / (2 {BESIDE_DEVIATION:g}^2)), u backward and v sideways, 0 before them; lower is better",
    ),
    "transit_time_on": (
        "s",
        "time of the robot's centre in the disc whose diameter joins somebody seated to the device that their seat "
        "watches, while that is truly on; lower is better",
    ),
    "transit_time_off": ("s", "time of the robot's centre in the same disc while the device is truly off"),
    "replan_delay": (
        "s",
        "from the first tick in which the device is truly on to the first whose way was searched anew knowing that; "
        "none where either never came; lower is better",
    ),
    "hand_over_distance": ("m", "true distance between the centres of robot and person when the hand-over arrived"),
    "hand_over_bearing": (
        "rad",
        "absolute direction of the robot from the person, against the person's true yaw, at that moment; 0 is straight "
        "before them; lower is better",
    ),
    "hand_over_facing": (
        "rad",
        "absolute direction of the person from the robot, against its true yaw, at that moment; lower is better",
    ),
    "hand_over_early_bearing": (
        "rad",
        f"the same as hand_over_bearing when their centres first came within {EARLY:g} m; lower is better",
    ),
    "person_position_rmse": (
        "m",
        "root mean square distance of matched tracks from their true person, over all ticks in which the track has "
        f"been confirmed for more than {STEADY_AFTER:g} s; {_MATCHED}; lower is better",
    ),
    "heading_error_rmse": (
        "rad",
        f"root mean square difference of a matched track's heading from the person's true yaw while the person walks "
        f"faster than {STILL_SPEED:g} m/s and the track has a heading; lower is better",
    ),
    "tracked_share": ("1", f"share of ticks in which the person is matched, {_POSSIBLE}; {_MATCHED}; higher is better"),
    "time_to_first_track": ("s", f"time until the person is first matched, {_POSSIBLE}; lower is better"),
    "time_to_notice_walking": (
        "s",
        f"from the first tick in which the true person moves faster than {STILL_SPEED:g} m/s to the first one since in "
        "which a matched track is walking; none where either never came; lower is better",
    ),
    "id_switches": ("1", "how often a person is matched to another id than at their previous match; lower is better"),
    "phantom_tracks": (
        "1",
        f"number of track ids that ever had no true person within {MATCH_WITHIN:g} m; lower is better",
    ),
    "phantom_time_total": (
        "s",
        f"time, summed over tracks, that a confirmed track had no true person within {MATCH_WITHIN:g} m; "
        "lower is better",
    ),
    "phantom_time_longest": (
        "s",
        f"longest unbroken time that one confirmed track had no true person within {MATCH_WITHIN:g} m; lower is better",
    ),
    "duplicate_time_total": (
        "s",
        f"time, summed over tracks, that a confirmed track had a true person within {MATCH_WITHIN:g} m but was not the "
        "one matched; lower is better",
    ),
    "detections_per_frame": ("1", "mean number of boxes that the detector kept in a camera frame"),
    "false_detections_per_frame": (
        "1",
        f"mean number per camera frame of foot points farther than {MATCH_WITHIN:g} m from every true person; "
        "lower is better",
    ),
}


@dataclass(frozen=True)
class Metric:
    """One figure of a run.

    Attributes:
        name: One of `DEFINITIONS`, for a metric of one person followed by a dot and the name.
        value: None where the run gives no such figure.
        unit: SI, "1" for counts and shares, empty for words.
        definition: What is measured: threshold, from where to where, which way is better.
    """

    name: str
    value: Value
    unit: str
    definition: str


class Metrics(Hook):
    """Count the figures of a run.

    Args:
        world: For the names of the people, the robot's radius and what hides people from cameras.
    """

    def __init__(self, world: World) -> None:
        people = [person.name for person in world.people]
        on_seats = {p.name: p.behaviour.on for p in world.people if isinstance(p.behaviour, Sit)}
        self._tallies: tuple[Tally, ...] = (
            MotionTally(),
            ContactTally(),
            EncounterTally(people, world.robot.radius),
            PassingTally(people),
            SeatedTally(list(on_seats)),
            TransitTally(world.seats(), {tv.name: np.array(tv.position) for tv in world.devices}, on_seats),
            *([HandOverTally(world.task)] if isinstance(world.task, HandOverTask) else []),
            PerceptionTally(people, field_of_view(world)),
        )

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        for tally in self._tallies:
            tally.record(tick)

    def results(self) -> list[Metric]:
        """Return all metrics so far, in a fixed order; values that are no finite number are None."""
        return [_metric(name, value) for tally in self._tallies for name, value in tally.values().items()]


def _metric(name: str, value: Value) -> Metric:
    finite = None if isinstance(value, float) and not math.isfinite(value) else value
    return Metric(name, finite, *DEFINITIONS[name.split(".")[0]])
