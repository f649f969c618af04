"""How the robot is, as diagnostics."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import pytest
from ticks import CAMERA, frame, make_world, tick

from han_bullet.episode import Tick
from han_bullet.geometry import Pose2D
from han_bullet.messages import Fault, GoTo, Path, Status
from han_bullet.ros.diagnostics import ERROR, OK, WARN, Diagnostics
from han_bullet.ros.message_types import serialize
from han_bullet.ros.stage_times import StageTimes

TV = {"name": "tv", "position": [4.0, 1.0], "facing": 0.0}
WORLD = make_world(cameras=[CAMERA.model_dump(mode="json")], devices=[TV])
TASK = GoTo(Pose2D(5.0, 0.0, 0.0))
STANDING_WAY = Path(tick().decision.estimate.pose_robot_in_world.position[None], 0.0)


def statuses(ticks: Sequence[Tick], **of_decision: Any) -> dict[str, Any]:
    diagnostics = Diagnostics(WORLD, StageTimes())
    for each in ticks:
        diagnostics.note(each.observation)
    decision = dataclasses.replace(ticks[-1].decision, path=STANDING_WAY)
    message = diagnostics.message(dataclasses.replace(decision, **of_decision))
    assert len(serialize(message))
    return {status.name.removeprefix("han_bullet: "): status for status in message.status}


def values(status: Any) -> dict[str, str]:
    return {pair.key: pair.value for pair in status.values}


@pytest.mark.parametrize(
    ("kinds", "level"),
    [
        ((), OK),
        (("dropped",), WARN),
        (("late",), WARN),
        (("silent",), ERROR),
        (("black",), ERROR),
        (("frozen",), ERROR),
        (("knocked",), ERROR),
        (("late", "black"), ERROR),
    ],
)
def test_the_level_of_a_sensor_is_that_of_its_worst_fault(kinds: Sequence[str], level: int) -> None:
    faults = tuple(Fault("ceiling", kind, 1.25) for kind in kinds)
    found = statuses([tick()], faults=faults)
    assert found["sensor ceiling"].level == level
    assert found["sensor laser"].level == found["sensor wheels"].level == found["sensor tv"].level == OK
    assert all(f"{kind} since 1.25 s" in found["sensor ceiling"].message for kind in kinds)


def test_a_silent_device_is_an_error() -> None:
    assert statuses([tick()], faults=(Fault("tv", "silent", 3.0),))["sensor tv"].level == ERROR


def test_rates_count_what_came_within_two_seconds_and_latency_is_the_last_images_age() -> None:
    ticks = [tick(k, frames=[frame(time=0.05 * k - 0.1)] if k % 4 == 0 else []) for k in range(101)]
    found = statuses(ticks)
    assert values(found["sensor ceiling"]) == {"rate [Hz]": "5.0", "latency [ms]": "100"}
    assert values(found["sensor wheels"])["rate [Hz]"] == "20.0"
    assert values(found["sensor laser"]) == {"rate [Hz]": "0.0"}


def test_a_camera_that_went_silent_has_a_rate_of_zero() -> None:
    ticks = [tick(k, frames=[frame(time=0.05 * k)] if k < 10 else []) for k in range(60)]
    assert values(statuses(ticks)["sensor ceiling"]) == {"rate [Hz]": "0.0"}


def test_a_lost_robot_is_an_error_of_localization() -> None:
    assert statuses([tick(lost=True)])["localization"].level == ERROR
    assert statuses([tick()])["localization"].level == OK


def test_no_way_to_the_goal_of_a_task_is_a_warning() -> None:
    scene = dataclasses.replace(tick().decision.scene, task=TASK)
    assert statuses([tick()], scene=scene, path=None)["planner"].level == WARN
    assert statuses([tick()], scene=scene)["planner"].level == OK


@pytest.mark.parametrize("over", [{"status": Status.ARRIVED}, {"gave_up": "a crate is in the door"}])
def test_a_robot_whose_task_is_over_lacks_no_way(over: dict[str, Any]) -> None:
    scene = dataclasses.replace(tick().decision.scene, task=TASK)
    planner = statuses([tick()], scene=scene, path=None, **over)["planner"]
    assert (planner.level, planner.message) == (OK, "has nothing to plan")


def test_a_robot_without_a_task_lacks_no_way() -> None:
    assert tick().decision.scene.task is None
    assert statuses([tick()], path=None, status=Status.IDLE)["planner"].level == OK


@pytest.mark.parametrize("status", Status)
def test_every_status_has_a_level_and_says_what_it_is(status: Status) -> None:
    found = statuses([tick()], status=status)["control"]
    bad, waits = {"LOST", "BLIND", "BLOCKED"}, {"WAITING", "YIELDING", "PROTECTIVE_STOP"}
    assert found.level == (ERROR if status.name in bad else WARN if status.name in waits else OK)
    assert found.message == status.value


def test_a_robot_that_gave_up_says_why() -> None:
    found = statuses([tick()], gave_up="a crate is in the door")["control"]
    assert found.level == ERROR and "a crate is in the door" in found.message


def test_stage_times_are_told_in_milliseconds() -> None:
    class Times(StageTimes):
        @property
        def mean(self) -> dict[str, float]:
            return {"tracker": 0.002}

        @property
        def rate(self) -> float:
            return 20.0

    message = Diagnostics(WORLD, Times()).message(tick().decision)
    loop = next(status for status in message.status if status.name == "han_bullet: loop")
    assert values(loop) == {"rate [Hz]": "20.0", "tracker latency [ms]": "2.000"}
