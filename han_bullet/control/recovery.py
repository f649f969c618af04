"""What a robot does that cannot go on: wait, forget obstacles, ask people to make way, give up and say why.

The order is that of move_base's recovery behaviours [MarderEppstein2010], which clear, turn and clear more; between
people it is kinder to wait first, and more use to ask them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Protocol, runtime_checkable

from han_bullet.control.step_ladder import Rung, StepLadder
from han_bullet.geometry import Array
from han_bullet.messages import PoseEstimate, RecoveryStep, Status

PROGRESS = 0.5  # from where it stood: so far on, the robot goes on again [m]
SOME_PROGRESS = 0.02  # each gives the present step its time anew [m], or a robot that sets off would be stopped
LOST_FOR = 1.0  # before it looks for itself [s]: until it stands
# No step helps who waits for its sensors, for an order or for who drives it.
NOT_STUCK = (Status.ARRIVED, Status.LOOKING, Status.BLIND, Status.IDLE, Status.TELEOPERATED)
DONE = {
    RecoveryStep.WAIT: "waited",
    RecoveryStep.CLEAR: "cleared the obstacle layer",
    RecoveryStep.ASK: "asked people to make way",
    RecoveryStep.RELOCALIZE: "looked for itself on the whole map",
}

Recovering = tuple[Status, RecoveryStep | None, str | None]


@runtime_checkable
class Clearable(Protocol):
    """What remembers obstacles, such as a costmap layer."""

    def clear(self) -> None:
        """Forget them."""


class Recovery:
    """Watch whether the robot goes on; where it does not, take one step after the other.

    It goes on while it gets `PROGRESS` away from where it was, as for nav2's progress checker [Macenski2020]; so it may
    yield to people and follow them, however slowly. It is not stuck where it has arrived, nor while it waits for
    sensors that fail.
    """

    def __init__(
        self,
        *,
        relocalize: Callable[[], None],
        obstacles: Sequence[Clearable] = (),
        wait: float = 10.0,
        clear: float = 5.0,
        ask: float = 10.0,
        search: float = 10.0,
    ) -> None:
        """Configure the steps; one of 0 s is left out.

        Args:
            relocalize: Begins to look for the robot on the whole map.
            obstacles: What is told to forget; without any, that step is left out.
            wait: For the way to become free by itself [s].
            clear: For a way after that [s].
            ask: People to make way [s].
            search: For the robot on the map [s].

        Raises:
            BadInputError: A time is negative or not finite.
        """
        self._obstacles = tuple(obstacles)
        self._stuck = StepLadder(
            Rung(RecoveryStep.WAIT, wait),
            Rung(RecoveryStep.CLEAR, clear if obstacles else 0.0, self.clear),
            Rung(RecoveryStep.ASK, ask),
        )
        self._lost = StepLadder(Rung(RecoveryStep.WAIT, LOST_FOR), Rung(RecoveryStep.RELOCALIZE, search, relocalize))
        self._from: Array | None = None
        self._farthest = 0.0

    def update(self, estimate: PoseEstimate, status: Status) -> Recovering:
        """Return the status, the step that is being taken, if one is, and the reason once the robot has given up.

        Args:
            estimate: Where the robot is at this tick.
            status: What it is up to, by the follower.
        """
        if status is Status.LOST:
            self._from = None
            step = self._lost.climb(estimate.time)
            why = f"lost for {self._lost.elapsed(estimate.time):.0f} s"
            return status, step, self._reason(why, self._lost) if step is RecoveryStep.GIVE_UP else None
        self._end_search()
        if status in NOT_STUCK:
            self.go_on()
            return status, None, None
        self._note_progress(estimate)
        step = self._stuck.climb(estimate.time)
        if step is RecoveryStep.GIVE_UP:
            why = "no free way to the goal" if status is Status.WAITING else "no progress"
            why += f" for {self._stuck.elapsed(estimate.time):.0f} s"
            return Status.BLOCKED, step, self._reason(why, self._stuck)
        on_its_way = step is RecoveryStep.WAIT and status is not Status.WAITING
        return status, None if on_its_way else step, None

    def begin_anew(self) -> None:
        """Begin with the first step when it is next stuck or lost: it has another task."""
        self.go_on()
        self._end_search()

    def go_on(self) -> None:
        """Take it that the robot is not stuck: it need not get on, or somebody drives it."""
        self._from = None

    def _end_search(self) -> None:
        if self._lost.taken:  # what the laser met was marked about a wrong pose
            self.clear()
        self._lost.leave()

    def _note_progress(self, estimate: PoseEstimate) -> None:
        position = estimate.pose_robot_in_world.position
        if self._from is None:
            self._go_on_from(position)
            return
        away = math.dist(position, self._from)
        if away >= PROGRESS:
            self._go_on_from(position)
        elif away >= self._farthest + SOME_PROGRESS:
            self._farthest = away
            self._stuck.stay(estimate.time)

    def _go_on_from(self, position_in_world: Array) -> None:
        self._stuck.leave()
        self._from, self._farthest = position_in_world, 0.0

    def clear(self) -> None:
        """Let all that remembers obstacles forget them."""
        for memory in self._obstacles:
            memory.clear()

    def _reason(self, why: str, ladder: StepLadder) -> str:
        return f"{why}; {', '.join(DONE[step] for step in ladder.taken)}"
