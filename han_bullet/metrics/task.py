"""How the robot's task ended, and what it took."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from han_bullet.episode import Tick
from han_bullet.geometry import Array, wrap_angle
from han_bullet.messages import Status
from han_bullet.metrics.contacts import ContactTally
from han_bullet.metrics.tally import STILL_SPEED, Definition, Definitions, Tally, Value
from han_bullet.planning.geodesic import Geodesic
from han_bullet.static_map import static_costmap
from han_bullet.world_schema import CONTROL_PERIOD, GoToTask, World

WINDOW = 5.0  # [s] [Francis2023]
LEAST_PROGRESS = 0.1  # [m] in a window [Francis2023]
AT_GOAL = 0.3  # [m]: who believes to have arrived and is farther away has not; twice the usual tolerance
OF_WORLDS_TASK = (
    "success",
    "goal_distance",
    "goal_yaw_error",
    "time_to_goal",
    "shortest_path_length",
    "spl",
    "stalled_time",
    "failure_to_progress",
)

_GOAL = "the task's goal, of a hand-over the place where its person is expected"
_GEODESIC = (
    "the shortest way at any angle of the robot's disc through the static map (walls and furniture, no people; exact "
    "to the map's cells, where the octile length of an 8-connected search is up to 8.2 % longer)"
)


class TaskTally(Tally):
    """How the task ended, and what it took.

    Args:
        world: For the static map and the goal.
        contacts: Of the same run.
    """

    group = "task"
    definitions: ClassVar[Definitions] = {
        "outcome": Definition(
            "",
            "how the task ended: arrived, blocked (the way or the goal not free for too long), lost (the robot did not "
            "find out where it is), timeout (nothing of these in time); of a robot that was given orders, how the last "
            f"ended: {', '.join(OF_WORLDS_TASK)} and hand_over_... then have no value",
            elsewhere="SocNavBench: termination_cause",
            headline=True,
        ),
        "success": Definition(
            "1",
            "whether the outcome is arrived, within the task's tolerance of the believed pose, the robot touched "
            "nothing, so contacts_person, contacts_wall and contacts_object are 0 (contacts_by_person may be any), and "
            f"goal_distance, where it has a value, is at most {AT_GOAL:g} m",
            "higher",
            "Francis2023: S, whoever hit; SEAN: Completed, within 1.2 m and whatever was hit",
            headline=True,
        ),
        "goal_distance": Definition(
            "m",
            "true distance of the robot's centre from the pose where the task leads, when it first arrived; none where "
            "it did not, and of hand-overs, which have hand_over_distance",
            "lower",
            "SEAN: target distance, at the end",
            headline=True,
        ),
        "goal_yaw_error": Definition(
            "rad",
            "absolute difference of the robot's true yaw and that of the pose, at the same moment, wrapped to [0, pi]",
            "lower",
        ),
        "time_to_goal": Definition(
            "s",
            "from the first tick to the first that has arrived; none where the robot did not arrive",
            "lower",
            "HuNav: time_to_reach_goal; Francis2023: T; SocNavBench: total_sim_time",
            headline=True,
        ),
        "path_length": Definition(
            "m",
            "sum of the true distances between the robot's centres of consecutive ticks, yaw not counted",
            "lower",
            "HuNav: path_length; Francis2023: PL; SEAN: total path length, at 1 Hz",
            headline=True,
        ),
        "shortest_path_length": Definition(
            "m",
            f"length of {_GEODESIC} from where the robot starts to {_GOAL} less the distance of the stop; none where "
            "the static map has no way, as for spl and failure_to_progress",
            elsewhere="Anderson2018: l; SocNavGym: the length of an ORCA run",
        ),
        "spl": Definition(
            "1",
            "success weighted by path length: success * L* / max(L, L*), L path_length and L* shortest_path_length; 0 "
            "without success, 1 at best; in an episode that has no length, L = L* = 0, success itself [Anderson2018]",
            "higher",
            "Francis2023: SPL; SEAN: path efficiency, its inverse",
            headline=True,
        ),
        "stalled_time": Definition(
            "s",
            f"time with a true translational speed below {STILL_SPEED:g} m/s, after the robot first exceeded that and "
            "before arrival; turning on the spot counts",
            "lower",
            "HuNav: time_not_moving, below 0.01 m/s; SEAN: time not moving; Francis2023: ST",
            headline=True,
        ),
        "failure_to_progress": Definition(
            "1",
            f"number of windows of {WINDOW:g} s in which the robot's true distance to the goal fell by less than "
            f"{LEAST_PROGRESS:g} m: consecutive windows from the first tick on that do not overlap, whole ones before "
            f"arrival or the end; the distance is the length of {_GEODESIC} to {_GOAL} [Francis2023]",
            "lower",
            "Francis2023: FP",
        ),
    }

    def __init__(self, world: World, contacts: ContactTally) -> None:
        self._world = world
        self._contacts = contacts
        self._statuses: list[Status] = []
        self._gave_up = self._ordered = False
        self._rows: list[tuple[float, float, float, float, float]] = []  # time, x, y, yaw, speed

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        pose = tick.truth.pose_robot_in_world
        self._statuses.append(tick.decision.status)
        self._gave_up = tick.decision.gave_up is not None
        self._ordered |= bool(tick.decision.orders)
        self._rows.append((tick.truth.time, pose.x, pose.y, pose.yaw, tick.truth.twist_robot_in_body.speed))

    def values(self) -> dict[str, Value]:
        """Return outcome, durations and lengths."""
        if not self._rows:
            return dict.fromkeys(self.definitions)
        return self._values() | (dict.fromkeys(OF_WORLDS_TASK) if self._ordered else {})

    def _values(self) -> dict[str, Value]:
        rows = np.array(self._rows)
        time, places, speed = rows[:, 0], rows[:, 1:3], rows[:, 4]
        arrival = self._statuses.index(Status.ARRIVED) if Status.ARRIVED in self._statuses else None
        length = float(np.hypot(*np.diff(places, axis=0).T).sum())
        task = self._world.task
        stop_before = 0.0 if isinstance(task, GoToTask) else task.distance
        geodesic = Geodesic(static_costmap(self._world), np.array(task.place))
        shortest = max(0.0, geodesic.length_from(places[0]) - stop_before)
        distance, yaw_error = (None, None) if arrival is None else _miss(self._world, rows[arrival, 1:4])
        there = arrival is not None and (distance is None or distance <= AT_GOAL)
        success = there and self._touched_nothing()
        return {
            "outcome": self._outcome(),
            "success": success,
            "goal_distance": distance,
            "goal_yaw_error": yaw_error,
            "time_to_goal": None if arrival is None else float(time[arrival] - time[0]),
            "path_length": length,
            "shortest_path_length": shortest,
            "spl": success * (shortest / max(length, shortest) if max(length, shortest) > 0.0 else 1.0),
            "stalled_time": _stalled_ticks(speed[:arrival]) * CONTROL_PERIOD,
            "failure_to_progress": _failures(geodesic, places[: None if arrival is None else arrival + 1]),
        }

    def _touched_nothing(self) -> bool:
        counts = self._contacts.values()
        return not any(counts[name] for name in ("contacts_person", "contacts_wall", "contacts_object"))

    def _outcome(self) -> str:
        if Status.ARRIVED in (self._statuses[-1:] if self._ordered else self._statuses):
            return "arrived"
        if self._statuses[-1] is Status.BLOCKED:
            return "blocked"
        return "lost" if self._gave_up else "timeout"


def _miss(world: World, pose: Array) -> tuple[float, float] | tuple[None, None]:
    """Return how far a pose, (3,) [m, m, rad], is from that of the world's task [m], [rad]; hand-overs have none."""
    if not isinstance(world.task, GoToTask):
        return None, None
    x, y, yaw = (pose - np.array(world.task.pose)).tolist()
    return math.hypot(x, y), abs(wrap_angle(yaw))


def _stalled_ticks(speed: Array) -> int:
    """Count the slow ticks after the first quick one; `speed` has shape (n,) [m/s]."""
    slow = speed < STILL_SPEED
    return int(slow[int(np.argmin(slow)) :].sum()) if not slow.all() else 0


def _failures(geodesic: Geodesic, places: Array) -> int | None:
    """Count the windows without progress of a way, shape (ticks, 2) [m]; None where no way leads to the goal."""
    remaining = [geodesic.length_from(place) for place in places[:: round(WINDOW / CONTROL_PERIOD)]]
    if not all(map(math.isfinite, remaining)):
        return None
    return int((-np.diff(remaining) < LEAST_PROGRESS).sum())
