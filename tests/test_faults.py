"""Faults made to happen: what they do to pictures, scans and messages, and what a run says of them."""

import csv
import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from ticks import make_world

from han_bullet.detection.detector import Detector
from han_bullet.device_payload import read_payload
from han_bullet.episode import Hook, Tick
from han_bullet.errors import BadInputError
from han_bullet.explain.recorded_run import read_run
from han_bullet.explain.replay import replay
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.messages import Detections, Observation, Status
from han_bullet.mirroring import mirrored
from han_bullet.runner import RunOptions, run_world
from han_bullet.sim.faults import Faults
from han_bullet.sim.renderer import InProcessRenderer
from han_bullet.sim.simulator import Simulator
from han_bullet.sim.trigger import RobotNow
from han_bullet.world_file import find_world, save_world
from han_bullet.world_schema import World

WALLS = [{"start": [0.0, y], "end": [20.0, y]} for y in (-2.05, 2.05)] + [{"start": [20.05, -2.1], "end": [20.05, 2.1]}]
SMALL = {"kind": "ceiling", "size": [320, 240]}
CAMERAS: list[dict[str, Any]] = [
    {"name": "left", "position": [0.2, 1.0, 2.6], "look_at": [6.2, 0.0, 0.9]} | SMALL,
    {"name": "right", "position": [0.2, -1.0, 2.6], "look_at": [6.2, 0.0, 0.9]} | SMALL,
]


def corridor(*faults: dict[str, Any], **changes: Any) -> World:
    """A corridor with two small cameras that look along it, a person in the distance and a television."""
    tv = {"name": "tv", "position": [12.0, -1.9], "facing": 1.5708, "turns_on": {"delay": 1.0}}
    return make_world("anna", **{"walls": WALLS, "cameras": CAMERAS, "devices": [tv], "faults": list(faults)} | changes)


def observe(world: World, ticks: int, seed: int = 0, pictures: bool = True) -> list[Observation]:
    """Drive straight on and return what the robot observes at each tick."""
    frames = InProcessRenderer(world, seed) if pictures else None
    with Simulator(world, renderer=frames, seed=seed) as simulator:
        observations = [simulator.reset(), *(simulator.step(Twist2D(0.5, 0.0, 0.0)) for _ in range(ticks))]
    if frames is not None:
        frames.close()
    return observations


def pictures(observations: list[Observation], camera: str) -> dict[int, np.ndarray]:
    """The pictures of a camera by the tick at which they arrived."""
    return {
        tick: frame.image
        for tick, observation in enumerate(observations)
        for frame in observation.images
        if frame.camera == camera
    }


def test_a_frozen_camera_repeats_its_last_picture_under_new_stamps_until_it_recovers() -> None:
    observations = observe(corridor({"kind": "frozen", "target": "left", "starts": 0.5, "until": 1.0}), 22)
    left, right = pictures(observations, "left"), pictures(observations, "right")
    assert all(np.array_equal(left[tick], left[8]) for tick in (10, 12, 14, 16, 18))
    assert not np.array_equal(left[6], left[8]) and not np.array_equal(left[18], left[20])
    assert not np.array_equal(right[10], right[12])
    assert [frame.time for tick in (10, 12) for frame in observations[tick].images] == pytest.approx(
        [0.5, 0.5, 0.6, 0.6]
    )


def test_a_black_camera_shows_its_noise_and_nothing_else() -> None:
    image = pictures(observe(corridor({"kind": "black", "target": "left", "starts": 0.1}), 2), "left")
    assert image[0].mean() > 50.0 and 0.0 < image[2].mean() < 4.0 and image[2].max() < 40


def test_a_knocked_camera_shows_its_scene_aside_and_still_says_that_it_hangs_as_before() -> None:
    knocked = observe(corridor({"kind": "knocked", "target": "left", "degrees": 3.0}, people=[]), 0)
    usual = observe(corridor(people=[]), 0)
    one, other = (pictures(o, "left")[0].astype(float).mean(axis=2) for o in (usual, knocked))
    shift = round(0.5 * 240 / np.tan(np.radians(22.5)) * np.tan(np.radians(3.0)))  # [px]: turned left, all moves right
    rows = slice(100, 140)
    assert np.abs(one[rows, 60:200] - other[rows, 60 + shift : 200 + shift]).mean() < 8.0
    assert np.abs(one[rows, 60:200] - other[rows, 60:200]).mean() > 12.0
    frames = [o[0].images[0].mount for o in (usual, knocked)]
    assert np.array_equal(*frames)


def test_a_share_of_frames_gets_lost_as_the_seed_draws_them() -> None:
    world = corridor({"kind": "dropped", "target": "left", "share": 0.3})

    def lost(seed: int) -> list[bool]:
        faults = Faults(world, seed)
        faults.update(RobotNow(0.0, Pose2D(1.0, 0.0, 0.0), 0.0))
        assert not any(faults.loses("right", tick) for tick in range(100))
        return [faults.loses("left", tick) for tick in range(2000)]

    assert all(np.mean(lost(seed)) == pytest.approx(0.3, abs=0.04) for seed in (0, 1))
    assert lost(0) == lost(0) != lost(1)


def with_blank_images(world: World) -> World:
    """The same with the smallest images that there are."""
    cameras = tuple(camera.model_copy(update={"size": (64, 64)}) for camera in world.cameras)
    return world.model_copy(update={"cameras": cameras})


def test_a_late_frame_is_the_picture_of_its_stamp_half_a_second_later() -> None:
    late = observe(corridor({"kind": "late", "target": "left", "delay": 0.5, "starts": 0.4, "until": 1.4}), 36)
    usual = pictures(observe(corridor(), 36), "left")
    arrived = {tick: frame for tick, o in enumerate(late) for frame in o.images if frame.camera == "left"}
    assert sorted(arrived) == [0, 2, 4, 6, *range(18, 28, 2), *range(28, 37, 2)]
    for tick, frame in arrived.items():
        exposed = tick - 10 if 8 <= tick < 28 else tick
        assert frame.time == pytest.approx(0.05 * exposed)
        assert np.array_equal(frame.image, usual[exposed])


def test_a_fault_of_all_cameras_is_one_of_each() -> None:
    observations = observe(corridor({"kind": "dropped", "starts": 0.2}), 8)
    assert [len(observation.images) for observation in observations] == [2, 0, 2, 0, 0, 0, 0, 0, 0]


def test_a_fault_may_wait_until_the_robot_is_near_the_camera() -> None:
    near = {"when": "robot_near", "distance": 0.9}
    world = corridor(
        {"kind": "dropped", "target": "right", "starts": near},
        robot={"start": [1.0, 0.0, 0.0]},
        cameras=[CAMERAS[0], CAMERAS[1] | {"position": [2.2, 0.0, 2.6], "look_at": [8.0, 0.0, 0.9]}],
    )
    arrived = pictures(observe(with_blank_images(world), 60), "right")
    assert 10 < max(arrived) < 30  # from 1.2 m to 0.9 m at 0.5 m/s, after speeding up


def test_a_fault_of_all_cameras_may_wait_until_the_robot_is_near_each_of_them() -> None:
    near = {"kind": "dropped", "starts": {"when": "robot_near", "distance": 0.9}}
    there = {"position": [2.2, 0.0, 2.6], "look_at": [8.0, 0.0, 0.9]}
    far = {"position": [8.2, 0.0, 2.6], "look_at": [2.0, 0.0, 0.9]}
    world = corridor(near, robot={"start": [1.0, 0.0, 0.0]}, cameras=[CAMERAS[0] | far, CAMERAS[1] | there])
    observations = observe(with_blank_images(world), 60)
    assert 10 < max(pictures(observations, "right")) < 30 and max(pictures(observations, "left")) == 60


def test_a_fault_of_all_cameras_cannot_wait_until_the_robot_is_near_that_has_one_of_them() -> None:
    near = {"kind": "black", "starts": {"when": "robot_near"}}
    onboard = {"name": "eye", "kind": "onboard"}
    with pytest.raises(BadInputError, match="'eye', one of 'all', is on the robot, which is always near"):
        corridor(near, cameras=[*CAMERAS, onboard])
    (asked,) = corridor(near).faults
    with pytest.raises(BadInputError, match="'eye', one of 'all', is on the robot, which is always near"):
        corridor(cameras=[*CAMERAS, onboard]).with_faults([asked])


def test_the_faults_of_cameras_that_are_left_out_go_with_them_and_the_run_can_be_explained(tmp_path: Path) -> None:
    faults: list[dict[str, Any]] = [{"kind": "frozen", "target": name, "starts": 0.1} for name in ("left", "right")]
    faults += [{"kind": "late"}, {"kind": "dropped", "target": "tv"}, {"kind": "slip"}]
    save_world(corridor(*faults, duration=0.2, people=[]), tmp_path / "world.yaml", "a test's")
    options = RunOptions(cameras=("right",), perception="truth", video=False)
    run_world(tmp_path / "world.yaml", options, tmp_path / "run")
    recorded = read_run(tmp_path / "run")
    assert [fault.target for fault in recorded.world.faults] == ["right", "all", "tv", "wheels"]
    assert replay(recorded, 0.1).differs_since is None


def test_a_fault_that_is_asked_for_of_a_camera_that_is_left_out_is_refused(tmp_path: Path) -> None:
    save_world(corridor(), tmp_path / "world.yaml", "a test's")
    asked = corridor({"kind": "frozen", "target": "left"}).faults
    options = RunOptions(cameras=("right",), perception="truth", faults=asked)
    with pytest.raises(BadInputError, match="target of 'frozen' is 'left'; one of all, right would be right"):
        run_world(tmp_path / "world.yaml", options, tmp_path / "run")


def test_the_laser_loses_scans_and_the_television_messages() -> None:
    world = corridor(
        {"kind": "dropped", "target": "laser", "starts": 1.0}, {"kind": "dropped", "target": "tv", "until": 1.5}
    )
    observations = observe(world, 50, pictures=False)
    scans = [tick for tick, observation in enumerate(observations) if observation.laser is not None]
    assert scans == list(range(0, 20, 2))
    told = [(o.time, read_payload(p, {"tv"}).on) for o in observations for p in o.device_messages]
    assert told == [(pytest.approx(2.0), True)]  # the one that said that it went on, at 1 s, is lost


def test_wheels_slip_as_many_times_as_much_from_when_the_fault_starts() -> None:
    def way(observations: list[Observation], first: int, last: int) -> float:
        start, end = (observations[tick].odometry.pose_robot_in_odom.x for tick in (first, last))
        return end - start

    def error(observations: list[Observation], first: int, last: int) -> float:
        return way(observations, first, last) - way(true, first, last)

    robot: dict[str, Any] = {"start": [1.0, 0.0, 0.0], "slip": {"distance": 0.02, "heading": 0.0, "turn": 0.0}}
    true = observe(corridor(robot=robot | {"slip": dict.fromkeys(robot["slip"], 0.0)}), 60, pictures=False)
    usual = observe(corridor(robot=robot), 60, pictures=False)
    slipping = observe(corridor({"kind": "slip", "times": 5.0, "starts": 1.5}, robot=robot), 60, pictures=False)
    assert error(slipping, 0, 30) == error(usual, 0, 30) != 0.0
    assert error(slipping, 31, 60) == pytest.approx(5.0 * error(usual, 31, 60), rel=1e-3)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ({"kind": "frozen", "target": "middle"}, "'middle'; one of all, left, right would be right"),
        ({"kind": "slip", "target": "left"}, "one of wheels would be right"),
        ({"kind": "black", "starts": 5.0, "until": 4.0}, "starts at 5 s and ends at 4 s"),
        ({"kind": "slip", "starts": {"when": "robot_near"}}, "'wheels' is on the robot"),
        ({"kind": "melted"}, "kind is 'melted'"),
        ({"kind": "dropped", "share": 1.5}, "less than or equal to 1"),
    ],
)
def test_a_fault_that_cannot_be_is_refused_with_what_would_be_right(fault: dict[str, Any], message: str) -> None:
    with pytest.raises(BadInputError, match=message):
        corridor(fault)


def test_the_mirror_image_of_a_knock_to_the_left_is_one_to_the_right() -> None:
    (knock,) = mirrored(corridor({"kind": "knocked", "degrees": 3.0})).faults
    assert knock.kind == "knocked" and knock.degrees == -3.0


class Nobody(Detector):
    """Finds nobody, quickly."""

    def detect(self, image: np.ndarray) -> Detections:
        return Detections.none()


class Watcher(Hook):
    """Keeps what was decided."""

    def __init__(self) -> None:
        self.ticks: list[Tick] = []

    def record(self, tick: Tick) -> None:
        self.ticks.append(tick)

    def scans_of(self, camera: str, start: float, end: float) -> int:
        """Count what the tracker was given of a camera from one time to another [s]."""
        return sum(
            scan.camera == camera
            for tick in self.ticks
            if start - 1e-6 <= tick.decision.time < end - 1e-6
            for scan in tick.decision.scans
        )


def run(
    folder: Path, *faults: dict[str, Any], duration: float = 4.0, localization: str = "lidar", **changes: Any
) -> tuple[list[Any], Watcher]:
    """Run the corridor with a detector that finds nobody; return the faults of result.json and what was decided."""
    watcher = Watcher()
    save_world(corridor(*faults, duration=duration, people=[], **changes), folder / "world.yaml", "a test's")
    options = RunOptions(localization=localization, video=False, workers=1)
    run_world(folder / "world.yaml", options, folder / "run", hooks=[watcher], detector=Nobody())
    return json.loads((folder / "run" / "result.json").read_text())["faults"], watcher


# Of each camera fault from 1 s to 2 s: noticed from when to when [s], and whether its frames are left out meanwhile.
NOTICED = {
    "frozen": ((1.0, 1.0), (2.3, 2.5), True),
    "black": ((1.0, 1.0), (2.3, 2.5), True),
    "dropped": ((1.2, 1.3), (3.5, 4.0), False),
    "late": ((1.5, 1.6), (2.3, 2.6), True),
}


@pytest.mark.scenario
@pytest.mark.parametrize("kind", NOTICED)
def test_a_camera_fault_is_noticed_and_named_and_its_frames_are_left_out_while_the_other_goes_on(
    tmp_path: Path, kind: str
) -> None:
    noticed, watcher = run(tmp_path, {"kind": kind, "target": "left", "starts": 1.0, "until": 2.0})
    from_range, until_range, left_out = NOTICED[kind]
    (fault,) = [fault for fault in noticed if fault["kind"] == kind]
    assert fault["sensor"] == "left" and {other["sensor"] for other in noticed} == {"left"}
    assert from_range[0] - 1e-6 <= fault["from"] <= from_range[1] + 1e-6
    assert fault["until"] is None or until_range[0] - 1e-6 <= fault["until"] <= until_range[1] + 1e-6
    assert watcher.scans_of("right", 0.0, 4.0) == 40
    assert watcher.scans_of("left", 0.0, 1.0) == 10
    if left_out:
        assert watcher.scans_of("left", 1.0, 2.0) == 0 < watcher.scans_of("left", 2.6, 4.0) == 14


@pytest.mark.scenario
def test_a_laser_without_scans_wheels_that_slip_and_a_silent_television_are_noticed_and_named(tmp_path: Path) -> None:
    faults = [
        {"kind": "dropped", "target": "laser", "starts": 1.0, "until": 2.0},
        {"kind": "dropped", "target": "tv", "starts": 2.5},
        {"kind": "slip", "times": 20.0, "starts": 2.0},
    ]
    save_world(corridor(*faults, duration=8.0, people=[]), tmp_path / "world.yaml", "a test's")
    watcher = Watcher()
    result = run_world(
        tmp_path / "world.yaml", RunOptions(perception="truth", video=False), tmp_path / "run", hooks=[watcher]
    )
    noticed = {(n.fault.sensor, n.fault.kind): (n.fault.since, n.until) for n in result.faults}
    assert set(noticed) == {("laser", "dropped"), ("wheels", "slip"), ("tv", "silent")}
    since, until = noticed["laser", "dropped"]
    assert since == pytest.approx(1.2) and until is not None and 2.5 < until < 4.3  # over with a tenth of 2 s missing
    assert 2.0 < noticed["wheels", "slip"][0] < 6.0
    since, until = noticed["tv", "silent"]
    assert since == pytest.approx(5.05) and until is None  # last heard at 2 s
    assert [device.on for device in watcher.ticks[-1].decision.scene.devices] == [True]  # as it said then


@pytest.mark.scenario
def test_a_knocked_camera_is_left_out_at_once_and_noticed_after_a_second(tmp_path: Path) -> None:
    noticed, watcher = run(tmp_path, {"kind": "knocked", "target": "left", "starts": 1.0, "until": 3.0})
    assert noticed == [{"sensor": "left", "kind": "knocked", "from": 2.0, "until": 3.4}]
    assert watcher.scans_of("left", 1.0, 3.4) == 0 and watcher.scans_of("right", 0.0, 4.0) == 40
    (injected,) = json.loads((tmp_path / "run" / "result.json").read_text())["injected_faults"]
    assert injected["kind"] == "knocked" and injected["degrees"] == 3.0


@pytest.mark.scenario
def test_without_a_fault_none_is_noticed(tmp_path: Path) -> None:
    noticed, watcher = run(tmp_path)
    assert noticed == [] and watcher.scans_of("left", 0.0, 4.0) == 40


@pytest.mark.scenario
@pytest.mark.parametrize("world", ["real2", "sim2"])
def test_a_run_of_the_paper_with_all_its_cameras_raises_no_false_alarm(tmp_path: Path, world: str) -> None:
    assert run_world(world, RunOptions(seed=0, video=False), tmp_path).faults == ()


@pytest.mark.scenario
def test_with_no_camera_it_goes_slowly_and_without_laser_it_stops_and_says_why_and_goes_on_afterwards(
    tmp_path: Path,
) -> None:
    black = {"kind": "black", "starts": 2.0, "until": 4.5}
    (tmp_path / "laser").mkdir()
    _, slow = run(tmp_path / "laser", black, duration=6.0)
    speeds = [tick.truth.twist_robot_in_body.speed for tick in slow.ticks]
    assert speeds[40] > 0.8 and speeds[88] == pytest.approx(0.3, abs=0.03) and speeds[118] > 0.8
    (tmp_path / "none").mkdir()
    robot = {"start": [1.0, 0.0, 0.0], "laser": None}
    _, stopped = run(tmp_path / "none", black, duration=6.0, localization="truth", robot=robot)
    assert stopped.ticks[88].truth.twist_robot_in_body.speed < 0.02
    assert stopped.ticks[88].decision.status is Status.BLIND
    assert stopped.ticks[118].decision.status is Status.MOVING


@pytest.mark.scenario
def test_a_faulty_run_is_replayed_from_its_files_with_the_same_faults_and_frames(tmp_path: Path) -> None:
    faults = [
        {"kind": "frozen", "target": "left", "starts": 1.0, "until": 1.5},
        {"kind": "dropped", "target": "right", "share": 0.5},
        {"kind": "late", "target": "left", "starts": 2.0},
    ]
    noticed, watcher = run(tmp_path, *faults, duration=3.0)
    assert Counter(fault["kind"] for fault in noticed) >= Counter(["frozen", "dropped", "late"])
    with (tmp_path / "run" / "frames.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(len(tick.decision.detections) for tick in watcher.ticks)
    replayed = replay(read_run(tmp_path / "run"), 3.0)
    assert replayed.tick.decision.faults == watcher.ticks[-1].decision.faults
    assert {camera: look.scan.time for camera, look in replayed.looks.items()} == {
        camera: pytest.approx(max(s.time for t in watcher.ticks for s in t.decision.scans if s.camera == camera))
        for camera in ("left", "right")
    }


@pytest.mark.scenario
def test_the_robots_own_camera_knocked_is_noticed_by_whom_others_see_and_left_out_till_it_is_put_right(
    tmp_path: Path,
) -> None:
    fault = {"kind": "knocked", "target": "onboard", "degrees": 3.0, "starts": 1.0, "until": 3.0}
    (tmp_path / "world.yaml").write_text(
        yaml.safe_dump(yaml.safe_load(find_world("real4").read_text()) | {"faults": [fault]})
    )
    watcher = Watcher()
    result = run_world(tmp_path / "world.yaml", RunOptions(video=False), tmp_path / "run", hooks=[watcher])
    (noticed,) = json.loads((tmp_path / "run" / "result.json").read_text())["faults"]
    assert (noticed["sensor"], noticed["kind"]) == ("onboard", "knocked")
    assert 1.2 < noticed["from"] < 1.7 and 3.2 < noticed["until"] < 4.2
    assert watcher.scans_of("onboard", 0.0, 1.0) == 10
    assert watcher.scans_of("onboard", noticed["from"], noticed["until"]) == 0
    assert watcher.scans_of("onboard", noticed["until"], noticed["until"] + 1.0) == 10
    assert watcher.scans_of("camera3", 0.0, 4.0) == 40
    assert result.checks and all(check.passed for check in result.checks)
    replayed = replay(read_run(tmp_path / "run"), 3.5)
    assert replayed.differs_since is None and "onboard" in replayed.looks
    assert replayed.looks["onboard"].scan.time < noticed["from"] + 1e-6
