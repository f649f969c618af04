"""A robot that cannot go on: which steps it takes in which order, what ends them, and why it gives up."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import groupby

import pytest

from han_bullet.control.recovery import Clearable, Recovery
from han_bullet.errors import BadInputError
from han_bullet.geometry import Pose2D
from han_bullet.messages import PoseEstimate, RecoveryStep, Status

PERIOD = 0.05
WAIT, CLEAR, ASK, RELOCALIZE, GIVE_UP = RecoveryStep


@dataclass
class Memory:
    """Something that remembers obstacles, and is told to forget them."""

    cleared: int = 0

    def clear(self) -> None:
        self.cleared += 1


@dataclass
class Robot:
    """A recovery under test, with its clock."""

    memories: Sequence[Memory] = ()
    searches: int = 0
    time: float = 0.0
    x: float = 0.0
    gave_up: str | None = None
    said: list[tuple[Status, RecoveryStep | None]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.recovery = Recovery(relocalize=self._search, obstacles=self.memories)

    def go_on(self, seconds: float, status: Status, speed: float = 0.0) -> list[RecoveryStep | None]:
        """Let it be up to something; return its steps, tick by tick, up to where it gives up."""
        steps: list[RecoveryStep | None] = []
        for _ in range(round(seconds / PERIOD)):
            estimate = PoseEstimate(self.time, Pose2D(self.x, 0.0, 0.0), lost=status is Status.LOST)
            found, step, self.gave_up = self.recovery.update(estimate, status)
            self.said.append((found, step))
            steps.append(step)
            if self.gave_up is not None:
                break
            self.time += PERIOD
            self.x += speed * PERIOD
        return steps

    def _search(self) -> None:
        self.searches += 1


def durations(steps: Sequence[RecoveryStep | None]) -> list[tuple[RecoveryStep | None, float]]:
    return [(step, round(PERIOD * len(list(run)), 6)) for step, run in groupby(steps)]


def test_without_a_way_it_waits_clears_asks_and_gives_up_and_says_so() -> None:
    robot = Robot([Memory(), Memory()])
    steps = robot.go_on(30.0, Status.WAITING)
    assert durations(steps) == [(WAIT, 10.0), (CLEAR, 5.0), (ASK, 10.0), (GIVE_UP, PERIOD)]
    assert [memory.cleared for memory in robot.memories] == [1, 1]
    assert {status for status, _ in robot.said[:-1]} == {Status.WAITING}
    assert robot.said[-1] == (Status.BLOCKED, GIVE_UP)
    why = "no free way to the goal for 25 s; waited, cleared the obstacle layer, asked people to make way"
    assert robot.gave_up == why
    assert robot.searches == 0


def test_without_anything_to_clear_that_step_is_left_out() -> None:
    robot = Robot()
    assert durations(robot.go_on(30.0, Status.WAITING)) == [(WAIT, 10.0), (ASK, 10.0), (GIVE_UP, PERIOD)]
    assert robot.gave_up == "no free way to the goal for 20 s; waited, asked people to make way"


def test_steps_of_no_time_are_left_out() -> None:
    recovery = Recovery(relocalize=lambda: None, obstacles=[Memory()], wait=10.0, clear=0.0, ask=0.0)
    answers = [recovery.update(PoseEstimate(t, Pose2D(0.0, 0.0, 0.0)), Status.WAITING) for t in (0.0, 9.95, 10.0)]
    assert answers[:2] == [(Status.WAITING, WAIT, None)] * 2
    assert answers[2] == (Status.BLOCKED, GIVE_UP, "no free way to the goal for 10 s; waited")


@pytest.mark.parametrize(("name", "step"), [("wait", "wait"), ("ask", "ask"), ("search", "relocalize")])
@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
def test_a_step_of_a_time_that_cannot_be_is_refused(name: str, step: str, value: float) -> None:
    with pytest.raises(BadInputError, match=f"recovery step {step}: limit is {value}; it must be 0 or a positive"):
        Recovery(relocalize=lambda: None, **{name: value})


@pytest.mark.parametrize("status", [Status.MOVING, Status.YIELDING])
def test_a_robot_that_wants_to_go_on_and_does_not_get_on_recovers_too(status: Status) -> None:
    robot = Robot([Memory()])
    steps = robot.go_on(30.0, status)
    assert durations(steps) == [(None, 10.0), (CLEAR, 5.0), (ASK, 10.0), (GIVE_UP, PERIOD)]
    assert robot.gave_up is not None and robot.gave_up.startswith("no progress for 25 s; waited, ")


@pytest.mark.parametrize(("speed", "status"), [(1.0, Status.MOVING), (0.1, Status.YIELDING), (0.06, Status.MOVING)])
def test_a_robot_that_gets_on_however_slowly_does_not_recover(speed: float, status: Status) -> None:
    robot = Robot([Memory()])
    assert set(robot.go_on(60.0, status, speed)) == {None}
    assert robot.memories[0].cleared == 0


def test_a_robot_that_stands_politely_now_and_then_for_less_than_the_wait_does_not_recover() -> None:
    robot = Robot([Memory()])
    for _ in range(5):
        assert set(robot.go_on(9.0, Status.YIELDING)) == {None}
        assert set(robot.go_on(1.0, Status.MOVING, speed=0.6)) == {None}


def test_after_half_a_metre_the_steps_begin_anew() -> None:
    robot = Robot([Memory()])
    assert robot.go_on(16.0, Status.WAITING)[-1] is ASK
    steps = robot.go_on(2.0, Status.MOVING, speed=0.5)
    assert durations(steps) == [(ASK, pytest.approx(1.0, abs=0.06)), (None, pytest.approx(1.0, abs=0.06))]
    assert durations(robot.go_on(30.0, Status.WAITING))[0] == (WAIT, pytest.approx(10.0, abs=0.3))


def test_a_robot_that_begins_to_get_on_has_its_step_anew_and_is_not_stopped_in_it() -> None:
    robot = Robot()
    assert robot.go_on(19.5, Status.WAITING)[-1] is ASK
    steps = robot.go_on(6.0, Status.MOVING, speed=0.05)  # half a second before the end of the last step it creeps on
    assert set(steps) == {ASK} and robot.gave_up is None


def test_creeping_to_and_fro_gives_no_time_without_end() -> None:
    robot = Robot()
    for _ in range(30):
        robot.go_on(2.0, Status.MOVING, speed=0.15)
        robot.go_on(2.0, Status.MOVING, speed=-0.15)
        if robot.gave_up is not None:
            break
    assert robot.gave_up is not None and robot.time < 35.0


@pytest.mark.parametrize("status", [Status.ARRIVED, Status.LOOKING, Status.BLIND])
def test_a_robot_that_is_where_it_should_be_or_waits_for_its_sensors_is_not_stuck(status: Status) -> None:
    robot = Robot()
    assert set(robot.go_on(60.0, status)) == {None}
    assert robot.go_on(9.0, Status.WAITING)[-1] is WAIT  # that time is not counted


def test_a_lost_robot_looks_for_itself_once_after_a_second_and_gives_up_as_lost() -> None:
    robot = Robot([Memory()])
    steps = robot.go_on(1.0, Status.LOST)
    assert robot.searches == 0
    steps += robot.go_on(30.0, Status.LOST)
    assert durations(steps) == [(WAIT, 1.0), (RELOCALIZE, 10.0), (GIVE_UP, PERIOD)]
    assert (robot.searches, robot.memories[0].cleared) == (1, 0)
    assert robot.gave_up == "lost for 11 s; waited, looked for itself on the whole map"
    assert {status for status, _ in robot.said} == {Status.LOST}


def test_a_robot_that_found_itself_goes_on_and_may_be_lost_again() -> None:
    robot = Robot()
    robot.go_on(9.0, Status.WAITING)
    assert robot.go_on(3.0, Status.LOST)[-1] is RELOCALIZE
    assert durations(robot.go_on(9.5, Status.WAITING)) == [(WAIT, 9.5)]  # the wait begins anew
    robot.go_on(3.0, Status.LOST)
    assert robot.searches == 2 and robot.gave_up is None


def test_what_can_be_cleared_is_known_by_that() -> None:
    nothing: Callable[[], None] = lambda: None  # noqa: E731
    assert isinstance(Memory(), Clearable) and not isinstance(nothing, Clearable)


def test_a_robot_that_found_itself_forgets_what_it_marked_about_a_wrong_pose() -> None:
    memory = Memory()
    robot = Robot([memory])
    robot.go_on(1.0, Status.MOVING, speed=1.0)
    robot.go_on(2.0, Status.LOST)
    assert memory.cleared == 0
    robot.go_on(1.0, Status.MOVING, speed=1.0)
    assert memory.cleared == 1


@pytest.mark.parametrize(("status", "steps"), [(Status.WAITING, [WAIT, ASK, GIVE_UP]), (Status.LOST, [WAIT])])
def test_with_another_task_the_steps_begin_anew(status: Status, steps: list[RecoveryStep]) -> None:
    robot = Robot()
    robot.go_on(40.0, status)
    assert robot.gave_up is not None
    robot.recovery.begin_anew()
    robot.time += PERIOD
    assert [step for step, _ in groupby(robot.go_on(30.0, status))][: len(steps)] == steps
    assert robot.searches == (2 if status is Status.LOST else 0)


@pytest.mark.parametrize("status", [Status.IDLE, Status.TELEOPERATED])
def test_a_robot_without_a_task_or_that_is_driven_does_not_recover(status: Status) -> None:
    assert set(Robot().go_on(60.0, status)) == {None}
