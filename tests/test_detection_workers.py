"""Detection in processes of its own: batch by batch, the newest image of each camera, nobody waits."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator

import numpy as np
import pytest
from mosquitto import until

from han_bullet.detection.pictures import Image
from han_bullet.detection_workers import DetectionWorkers
from han_bullet.detector_choice import DetectorChoice
from han_bullet.errors import BadInputError, HanError, WorkerDiedError
from han_bullet.geometry import Pose2D
from han_bullet.messages import CameraImage
from han_bullet.mounted_camera import MountedCamera, camera_detector
from han_bullet.sim.renderer import Renderer
from han_bullet.sim.simulator import Simulator
from han_bullet.world_file import load_world
from han_bullet.world_schema import CONTROL_PERIOD, World

CAMERAS = ("camera1", "camera2")
CHOICE = DetectorChoice(classifier="default")


@pytest.fixture(scope="module")
def world() -> World:
    return load_world("real2")


@pytest.fixture(scope="module")
def pictures(world: World) -> dict[str, Image]:
    """What each camera sees at the start, with somebody before camera1."""
    with Simulator(world, renderer=None) as simulator:
        simulator.reset()
        renderer = Renderer(world, seed=0)
        pictures = {name: renderer.render(name, simulator.render_state) for name in CAMERAS}
        renderer.close()
    return pictures


@pytest.fixture(scope="module")
def empty(world: World) -> dict[str, Image]:
    renderer = Renderer(world, seed=0)
    scenes = {name: renderer.calibration_image(name) for name in CAMERAS}
    renderer.close()
    return scenes


def mounted(world: World) -> list[MountedCamera]:
    return [MountedCamera.of_world(world.camera(name)) for name in CAMERAS]


@pytest.fixture
def workers(world: World, empty: dict[str, Image]) -> Iterator[DetectionWorkers]:
    with DetectionWorkers(mounted(world), empty, world.seats(), world.solid_boxes(), CHOICE, count=2) as workers:
        workers.wait_until_ready()
        yield workers


def image(camera: MountedCamera, pixels: Image, time: float) -> CameraImage:
    return CameraImage(camera.name, time, pixels, camera.intrinsics, camera.mount, camera.fixed)


def finished(workers: DetectionWorkers) -> tuple[CameraImage, ...]:
    done: list[CameraImage] = []

    def some() -> bool:
        done.extend(workers.finished())
        return bool(done)

    until(some)
    return tuple(done)


def test_what_workers_find_is_what_a_detector_in_this_process_finds(
    workers: DetectionWorkers, world: World, pictures: dict[str, Image], empty: dict[str, Image]
) -> None:
    cameras = mounted(world)
    for camera in cameras:
        workers.offer(image(camera, pictures[camera.name], 1.0))
    frames = [one.placed(Pose2D(0.0, 0.0, 0.0)) for one in finished(workers)]
    assert [frame.camera for frame in frames] == list(CAMERAS)
    found = workers.detect(frames)
    detector = camera_detector(CHOICE.load(), cameras, empty, world.seats(), world.solid_boxes())
    assert len(found[0].boxes) >= 1
    for ours, theirs in zip(found, detector.detect(frames), strict=True):
        np.testing.assert_array_equal(ours.boxes, theirs.boxes)
        assert (ours.camera, ours.time, ours.health) == (theirs.camera, theirs.time, theirs.health)


def test_of_images_that_come_while_a_batch_is_looked_at_only_the_newest_of_a_camera_is_next(
    workers: DetectionWorkers, world: World, pictures: dict[str, Image]
) -> None:
    first, second = mounted(world)
    for camera in (first, second):
        workers.offer(image(camera, pictures[camera.name], 1.0))
    assert workers.finished() == ()  # begins the batch
    for time in (1.1, 1.2, 1.3):
        workers.offer(image(first, pictures["camera1"], time))
    batch = finished(workers)
    assert [(one.camera, one.time) for one in batch] == [("camera1", 1.0), ("camera2", 1.0)]
    assert [(one.camera, one.time) for one in finished(workers)] == [("camera1", 1.3)]


def test_a_frame_is_asked_for_once_and_only_if_it_was_looked_at(
    workers: DetectionWorkers, world: World, pictures: dict[str, Image]
) -> None:
    camera = mounted(world)[0]
    workers.offer(image(camera, pictures["camera1"], 1.0))
    frames = [one.placed(Pose2D(0.0, 0.0, 0.0)) for one in finished(workers)]
    assert len(workers.detect(frames)) == 1
    with pytest.raises(HanError, match=r"frame of 'camera1' at 1.0 s is not among those"):
        workers.detect(frames)


def test_a_worker_that_dies_is_told_by_its_name(
    workers: DetectionWorkers, world: World, pictures: dict[str, Image]
) -> None:
    for process in workers.process_ids:
        os.kill(process, signal.SIGKILL)
    with pytest.raises(WorkerDiedError, match="detection-worker-"):
        while True:
            workers.offer(image(mounted(world)[0], pictures["camera1"], CONTROL_PERIOD))
            workers.finished()


def test_a_detector_that_does_not_exist_is_told_before_anything_is_looked_at(world: World) -> None:
    choice = DetectorChoice(name="nothing.npz")
    with (
        DetectionWorkers(mounted(world), {}, (), (), choice, count=1) as workers,
        pytest.raises(BadInputError, match="nothing"),
    ):
        workers.wait_until_ready()
