"""From pictures of a couch to the end of a track: who vanished from it is believed in for a second, not for ten."""

import json
import math
import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from made_runs import RESULT

from han_bullet.ablation import TrueLocalization
from han_bullet.assembly import build_stack, build_tracker
from han_bullet.camera_workers import CameraStation, DetectorChoice
from han_bullet.coverage import empty_image
from han_bullet.episode import Hook, Tick
from han_bullet.explain.explainer import explain
from han_bullet.explain.recorded_run import read_run
from han_bullet.explain.replay import AGREEMENT, replay
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.messages import CameraImage, Observation, Odometry, Posture, TruePerson, Truth
from han_bullet.recorder import (
    CommandsRecorder,
    DetectionsRecorder,
    EmptySeatsRecorder,
    FeetRecorder,
    FramesRecorder,
    LaserRecorder,
    LegsRecorder,
    MessagesRecorder,
    OdometryRecorder,
    PosesRecorder,
    StatusRecorder,
    TraceRecorder,
    TracksRecorder,
)
from han_bullet.sim.gait import Gait
from han_bullet.sim.scene_state import RobotPosture, SceneState
from han_bullet.variation import vary
from han_bullet.world_file import load_world, save_world
from han_bullet.world_schema import CONTROL_PERIOD, World

SEAT, CORRIDOR, ROBOT = Pose2D(19.5, -0.4, -0.5 * math.pi), Pose2D(10.0, 0.5, 0.0), Pose2D(14.0, 0.0, 0.0)
LEAVES, END = 3.0, 4.5  # [s]
GONE = "its seat was seen to be empty for 1.00 s by camera4"

Where = Callable[[float], tuple[Pose2D, Posture]]


def vanishing(time: float) -> tuple[Pose2D, Posture]:
    """Sit on the couch for three seconds, and be elsewhere from one frame to the next."""
    return (SEAT, Posture.SEATED) if time < LEAVES - 1e-6 else (CORRIDOR, Posture.STANDING)


def passing(time: float) -> tuple[Pose2D, Posture]:
    """Walk past the couch, a metre before it, from x = 17 to 22 m."""
    return Pose2D(17.0 + time, -1.4, 0.0), Posture.WALKING


@dataclass
class Film:
    """What the stack made of one person before camera4.

    Attributes:
        folder: With the files of a run.
        empty: Times at which the couch was seen to be empty [s].
        seated: Times at which somebody was believed to sit on it [s].
    """

    folder: Path
    empty: list[float]
    seated: list[float]


def film(where: Where, end: float, folder: Path) -> Film:
    """Let a person be somewhere at each time up to an end [s], before a robot that stands still."""
    world = vary(load_world("real3"), 1)
    world = world.model_copy(update={"cameras": (world.camera("camera4"),)})
    station = CameraStation(world, 1, ["camera4"], DetectorChoice().load())
    still = Truth(0.0, ROBOT, Twist2D(), ())
    stack = build_stack(
        world,
        localization=TrueLocalization(lambda: still),
        detector=station.detector,
        tracker=build_tracker(world),
    )
    recorders, result = files_of_a_run(folder, world), Film(folder, [], [])
    for index in range(round(end / CONTROL_PERIOD) + 1):
        time = index * CONTROL_PERIOD
        images = pictures(station, world, index, where) if index % 2 == 0 else ()
        observation = Observation(time, Odometry(time, ROBOT, Twist2D()), None, images)
        decision = stack.step(observation)
        pose, posture = where(time)
        truth = Truth(time, ROBOT, Twist2D(), (TruePerson("viewer", pose, np.zeros(2), posture),))
        for recorder in recorders:
            recorder.record(Tick(observation, decision, truth))
        result.empty.extend(time for found in decision.detections if "couch" in found.empty_seats)
        result.seated.extend(time for person in decision.people if person.seat == "couch")
    for recorder in recorders:
        recorder.close()
    station.frames.close()
    return result


def pictures(station: CameraStation, world: World, index: int, where: Where) -> tuple[CameraImage, ...]:
    """Return camera4's image of a tick."""
    time = index * CONTROL_PERIOD
    pose, posture = where(time)
    body = Gait(world.people[0].build).advance(pose, 0.0, CONTROL_PERIOD, posture)
    state = SceneState(time, index, RobotPosture(ROBOT), (body,), (("tv", False),))
    (image,) = station.frames.render(["camera4"], state)
    return (replace(empty_image(world.camera("camera4"), time), image=image),)


def files_of_a_run(folder: Path, world: World) -> list[Hook]:
    save_world(world, folder / "world.yaml", "a person before camera4")
    (folder / "result.json").write_text(json.dumps(RESULT))
    return [
        TraceRecorder(folder / "trace.csv", world),
        TracksRecorder(folder / "tracks.csv"),
        DetectionsRecorder(folder / "detections.csv"),
        FeetRecorder(folder / "feet.csv"),
        EmptySeatsRecorder(folder / "empty_seats.csv"),
        StatusRecorder(folder / "status.csv"),
        FramesRecorder(folder / "frames.csv"),
        LegsRecorder(folder / "legs.csv"),
        PosesRecorder(folder / "poses.csv"),
        OdometryRecorder(folder / "odometry.csv"),
        CommandsRecorder(folder / "commands.csv"),
        LaserRecorder(folder / "laser.csv", 0),
        MessagesRecorder(folder / "messages.csv", ["tv"]),
    ]


@pytest.fixture(scope="module")
def vanished(tmp_path_factory: pytest.TempPathFactory) -> Film:
    return film(vanishing, END, tmp_path_factory.mktemp("vanished"))


def test_the_couch_is_seen_to_be_empty_in_every_frame_since_nobody_sits_on_it_and_in_none_before(
    vanished: Film,
) -> None:
    assert vanished.empty == pytest.approx(
        [3.0, 3.1, 3.2, 3.3, 3.4, 3.5, 3.6, 3.7, 3.8, 3.9, 4.0, 4.1, 4.2, 4.3, 4.4, 4.5]
    )


def test_the_track_ends_when_that_has_gone_on_for_a_second(vanished: Film) -> None:
    assert vanished.seated[0] < 1.0
    assert vanished.seated[-1] == pytest.approx(LEAVES + 0.95)


def test_a_replay_of_the_files_agrees_and_says_why_the_track_ended(vanished: Film) -> None:
    replayed = replay(read_run(vanished.folder), END)
    assert replayed.differs_since is None and replayed.difference < AGREEMENT
    (viewer,) = explain(replayed).people
    assert viewer.track is None
    (told,) = viewer.history
    assert told.startswith("track 0 ended at 4.00 s") and GONE in told


def test_the_replay_needs_what_was_seen_of_the_seats(vanished: Film, tmp_path: Path) -> None:
    folder = tmp_path / "bare"
    shutil.copytree(vanished.folder, folder)
    (folder / "empty_seats.csv").write_text("time,camera,seat\n")
    assert replay(read_run(folder), END).differs_since == pytest.approx(LEAVES + 1.0)


def test_while_somebody_walks_past_before_the_couch_nothing_is_said_of_it(tmp_path: Path) -> None:
    seen = film(passing, 5.0, tmp_path).empty
    before, after = [time for time in seen if time < 2.5], [time for time in seen if time > 2.5]
    assert before[0] == 0.0 and after[-1] == pytest.approx(5.0)
    assert before[-1] < 1.6 and after[0] > 3.4  # the couch is from x = 18.55 to 20.45 m, 1.55 to 3.45 s
