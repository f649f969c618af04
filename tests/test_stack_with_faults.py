"""What the robot does about a person whom no camera that works would show."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from ticks import make_world

from han_bullet.ablation import TrueLocalization
from han_bullet.assembly import build_stack, build_tracker
from han_bullet.coverage import empty_frame, empty_image
from han_bullet.detection.camera_detector import FrameDetector
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.messages import (
    Detections,
    Frame,
    FrameDetections,
    ImageHealth,
    LaserScan,
    Observation,
    Odometry,
    PoseEstimate,
    Status,
    Truth,
)
from han_bullet.stack import Decision
from han_bullet.tracking.sight import expected_box
from han_bullet.world_schema import CONTROL_PERIOD

HERE = {"kind": "ceiling", "position": [0.2, 0.0, 2.6], "look_at": [6.2, 0.0, 0.9]}
WEST = HERE | {"name": "west"}
BESIDE = HERE | {"name": "beside", "position": [0.2, 0.6, 2.6]}
ELSEWHERE = HERE | {"name": "elsewhere", "position": [19.0, 0.0, 2.6], "look_at": [25.0, 0.0, 0.9]}
ANNA = np.array([6.0, 0.3])
FROZEN_FROM = 2.0  # [s]
SCANNER_IN_BODY = Pose2D(0.2, 0.0, 0.0)


class Painted(FrameDetector):
    """Finds a person where one stands, in pictures that are alive, or frozen from a time on."""

    def __init__(self, stands: Callable[[str, float], bool]) -> None:
        self._stands = stands

    def detect(self, frames: Sequence[Frame]) -> list[FrameDetections]:
        return [self._look(frame) for frame in frames]

    def _look(self, frame: Frame) -> FrameDetections:
        frozen = frame.camera == "west" and frame.time >= FROZEN_FROM
        number = round(FROZEN_FROM / 0.1) - 1 if frozen else round(frame.time / 0.1)
        boxes = np.array([expected_box(frame, ANNA)]) if self._stands(frame.camera, frame.time) else np.zeros((0, 4))
        found = Detections(boxes, np.full(len(boxes), 50.0), np.ones(len(boxes)))
        return found.at(frame.camera, frame.time, ImageHealth(number, 120.0, 25.0))


class Astray(TrueLocalization):
    """Knows the pose, but for a while in which it is lost and believes itself to be where the person is."""

    def __init__(self, truth: Truth, lost: tuple[float, float]) -> None:
        super().__init__(lambda: truth)
        self._lost = lost

    def update(self, odometry: Odometry, scan: LaserScan | None) -> PoseEstimate:
        if self._lost[0] <= odometry.time < self._lost[1]:
            return PoseEstimate(odometry.time, Pose2D(*ANNA.tolist(), 1.0), lost=True)
        return super().update(odometry, scan)


def decide(
    seconds: float,
    *cameras: dict,
    stands: Callable[[str, float], bool],
    x: float = 3.0,
    lost: tuple[float, float] = (math.inf, math.inf),
) -> list[Decision]:
    """Let a stack look at a person 3 m before a robot that does not move; return its decisions."""
    world = make_world(cameras=list(cameras), robot={"start": [x, 0.0, 0.0]})
    pose, decisions = Pose2D(x, 0.0, 0.0), []
    still = Truth(0.0, pose, Twist2D(), ())
    stack = build_stack(
        world,
        localization=Astray(still, lost),
        detector=Painted(stands),
        tracker=build_tracker(world),
    )
    for tick in range(round(seconds / CONTROL_PERIOD) + 1):
        time = tick * CONTROL_PERIOD
        images = tuple(empty_image(camera, time) for camera in world.cameras) if tick % 2 == 0 else ()
        scan = LaserScan(time, np.full(3, np.inf), 0.0, 0.1, 0.05, 8.0, SCANNER_IN_BODY) if tick % 2 == 0 else None
        decisions.append(stack.step(Observation(time, Odometry(time, pose, Twist2D()), scan, images)))
    return decisions


def spread(decision: Decision) -> float:
    """The standard deviation of the only person's place [m]."""
    (person,) = decision.people
    return float(np.sqrt(np.linalg.eigvalsh(person.covariance[:2, :2])[-1]))


def test_whom_only_a_frozen_camera_shows_is_neither_seen_nor_missed_and_known_ever_less() -> None:
    decisions = decide(7.0, WEST, ELSEWHERE, stands=lambda camera, _: camera == "west")
    before, frozen = decisions[38], decisions[41:]
    assert [f.kind for f in decisions[-1].faults if f.sensor == "west"] == ["frozen"]
    assert len(before.people) == 1 and spread(before) < 0.12
    assert all(scan.camera == "elsewhere" for decision in frozen for scan in decision.scans)
    spreads = [spread(decision) for decision in frozen]
    assert (np.diff(spreads) > 0.0).all() and spreads[-1] > 0.5


def test_who_has_left_where_another_camera_looks_is_forgotten_as_usual() -> None:
    decisions = decide(7.0, WEST, BESIDE, stands=lambda camera, time: camera == "west" or time < 2.5)
    assert len(decisions[48].people) == 1
    assert decisions[-1].people == ()


def test_who_is_in_view_of_a_camera_that_works_stays_known_well() -> None:
    decisions = decide(7.0, WEST, BESIDE, stands=lambda *_: True)
    assert spread(decisions[-1]) < 0.12


def test_nobody_is_remembered_for_ever() -> None:
    assert decide(30.0, WEST, ELSEWHERE, stands=lambda camera, _: camera == "west")[-1].people == ()


def test_the_robot_slows_where_somebody_may_be_whom_no_camera_shows_and_not_far_from_there() -> None:
    def speed(x: float) -> float:
        decisions = decide(6.0, WEST, ELSEWHERE, stands=lambda camera, _: camera == "west", x=x)
        assert len(decisions[-1].people) == 1 and decisions[-1].path is not None
        assert decisions[38].command.speed > 0.7
        return decisions[-1].command.speed

    assert 0.2 < speed(3.5) <= 0.4 + 1e-9
    assert speed(11.0) > 0.8


def test_a_lost_robot_takes_nothing_from_its_cameras_and_forgets_nobody() -> None:
    decisions = decide(4.0, BESIDE, stands=lambda *_: True, lost=(1.0, 3.0))
    lost = decisions[20:60]
    assert all(decision.scans == () and len(decision.people) == 1 for decision in lost)
    assert lost[-1].status is Status.LOST and lost[-1].command.speed == 0.0
    assert lost[-1].people[0].id == decisions[-1].people[0].id == decisions[19].people[0].id
    assert spread(lost[-1]) > 0.15 and spread(decisions[-1]) < 0.12
    assert [fault for decision in decisions for fault in decision.faults if fault.sensor == "wheels"] == []


def test_an_onboard_image_and_a_sweep_that_come_late_are_placed_where_the_robot_was() -> None:
    world = make_world(cameras=[{"kind": "onboard", "name": "onboard"}], robot={"start": [1.0, 0.0, 0.0]})
    poses = [Pose2D(1.0 + 0.05 * k, 0.0, 0.02 * k) for k in range(21)]
    now = iter(poses)
    stack = build_stack(
        world,
        localization=TrueLocalization(lambda: Truth(0.0, next(now), Twist2D(), ())),
        detector=Painted(lambda *_: False),
        tracker=build_tracker(world),
    )
    (camera,) = world.cameras
    for k, pose in enumerate(poses):
        images = (empty_image(camera, (k - 8) * CONTROL_PERIOD),) if k == 20 else ()
        time = k * CONTROL_PERIOD
        late = LaserScan(time - 4 * CONTROL_PERIOD, np.full(3, np.inf), 0.0, 0.1, 0.05, 8.0, SCANNER_IN_BODY)
        sweep = late if k == 20 else None
        decision = stack.step(Observation(time, Odometry(time, pose, Twist2D()), sweep, images))
    assert (decision.scene.pose_robot_in_world, decision.scene.pose_robot_at_scan) == (poses[20], poses[16])
    (scan,) = decision.scans
    assert scan.pose_robot_in_world == poses[12]
    assert scan.frame.camera_in_world == pytest.approx(empty_frame(camera, poses[12]).camera_in_world)
