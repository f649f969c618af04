import multiprocessing.context
import os
import signal
from dataclasses import replace
from multiprocessing.context import ForkServerContext
from multiprocessing.shared_memory import SharedMemory
from typing import ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

from han_bullet.camera_workers import CameraStation, CameraWorkers, DetectorChoice
from han_bullet.detection.acf import Scan
from han_bullet.detection.pedestrian_detector import PedestrianDetector
from han_bullet.detection.search_area import SearchArea
from han_bullet.errors import BadInputError, HanError, WorkerDiedError
from han_bullet.geometry import Twist2D
from han_bullet.messages import Frame
from han_bullet.sim.renderer import InProcessRenderer
from han_bullet.sim.scene_state import Exposure
from han_bullet.sim.simulator import Simulator
from han_bullet.variation import vary
from han_bullet.world_file import load_world

WORLD = vary(load_world("real2"), 0)
CAMERAS = ["camera1", "onboard"]


def frames(images: list[NDArray[np.uint8]], time: float = 0.0) -> list[Frame]:
    cameras = [WORLD.camera(name) for name in CAMERAS]
    return [
        Frame(camera.name, time, image, camera.intrinsics, np.eye(4), fixed=camera.kind == "ceiling")
        for camera, image in zip(cameras, images, strict=True)
    ]


def test_workers_give_what_one_process_gives() -> None:
    station = CameraStation(WORLD, 0, CAMERAS, DetectorChoice().load())
    with (
        Simulator(WORLD, renderer=None) as simulator,
        CameraWorkers(WORLD, 0, CAMERAS, DetectorChoice(), count=2) as workers,
    ):
        simulator.reset()
        here = station.frames.render(CAMERAS, simulator.render_state)
        there = workers.render(CAMERAS, simulator.render_state)
        assert all(np.array_equal(one, other) for one, other in zip(here, there, strict=True))
        for found_here, found_there in zip(
            station.detector.detect(frames(here)), workers.detect(frames(there)), strict=True
        ):
            assert len(found_here.boxes) == 1
            assert np.array_equal(found_here.boxes, found_there.boxes)
            assert np.array_equal(found_here.probabilities, found_there.probabilities)
    station.frames.close()


def test_workers_tell_which_seats_are_empty_as_one_process_does() -> None:
    camera = ["camera4"]
    station = CameraStation(WORLD, 0, camera, DetectorChoice().load())
    with (
        Simulator(WORLD, renderer=None) as simulator,
        CameraWorkers(WORLD, 0, camera, DetectorChoice(), count=1) as workers,
    ):
        simulator.reset()
        (image,) = workers.render(camera, simulator.render_state)
        frame = Frame("camera4", 0.0, image, WORLD.camera("camera4").intrinsics, np.eye(4), fixed=True)
        for detector in (station.detector, workers):
            assert detector.detect([frame])[0].empty_seats == ("couch",)
    station.frames.close()


def test_workers_take_the_faulty_exposures_that_one_process_takes_and_know_late_frames_by_their_stamps() -> None:
    with (
        Simulator(WORLD, renderer=None) as simulator,
        CameraWorkers(WORLD, 0, CAMERAS, DetectorChoice(), count=2) as workers,
    ):
        simulator.reset()
        before = simulator.render_state
        for _ in range(10):
            simulator.step(Twist2D(0.5, 0.0, 0.0))
        faulty = (Exposure("camera1", before.time, before), Exposure("onboard", 0.5, before, black=True))
        state = replace(simulator.render_state, exposures=faulty)
        station = InProcessRenderer(WORLD, 0)
        here, there = station.render(CAMERAS, state), workers.render(CAMERAS, state)
        assert all(np.array_equal(one, other) for one, other in zip(here, there, strict=True))
        assert np.array_equal(there[0], station.render(CAMERAS[:1], before)[0]) and there[1].mean() < 5.0
        late, black = workers.detect([frames(there, before.time)[0], frames(there, state.time)[1]])
        assert (late.time, black.time) == (0.0, 0.5)
        assert black.health is not None and black.health.brightness < 5.0
        station.close()


def test_frames_that_the_workers_did_not_just_render_are_refused() -> None:
    with (
        Simulator(WORLD, renderer=None) as simulator,
        CameraWorkers(WORLD, 0, CAMERAS, DetectorChoice(), count=1) as workers,
    ):
        simulator.reset()
        images = workers.render(CAMERAS, simulator.render_state)
        with pytest.raises(HanError, match=r"camera1.* at 3.0 s"):
            workers.detect(frames(images, time=3.0))


def test_there_are_no_more_workers_than_cameras() -> None:
    with CameraWorkers(WORLD, 0, CAMERAS[:1], DetectorChoice(), count=4) as workers:
        assert len(workers.process_ids) == 1


class Interrupted(multiprocessing.context.SpawnProcess):
    """A process that the keyboard stops while it starts."""

    memory_names: ClassVar[list[str]] = []

    def start(self) -> None:
        self.memory_names.extend(self._args[-1].values())  # type: ignore[attr-defined]
        raise KeyboardInterrupt


def test_a_start_that_the_keyboard_stops_leaves_no_shared_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ForkServerContext, "Process", Interrupted)
    with pytest.raises(KeyboardInterrupt):
        CameraWorkers(WORLD, 0, CAMERAS, DetectorChoice(), count=2)
    assert len(Interrupted.memory_names) == len(CAMERAS)
    for name in Interrupted.memory_names:
        with pytest.raises(FileNotFoundError):
            SharedMemory(name)


def test_a_worker_that_is_killed_is_reported_by_name() -> None:
    with (
        Simulator(WORLD, renderer=None) as simulator,
        CameraWorkers(WORLD, 0, CAMERAS, DetectorChoice(), count=1) as workers,
    ):
        simulator.reset()
        workers.render(CAMERAS, simulator.render_state)
        os.kill(workers.process_ids[0], signal.SIGKILL)
        with pytest.raises(WorkerDiedError, match="camera-worker-0"):
            workers.render(CAMERAS, simulator.render_state)


def test_a_detector_that_does_not_exist_is_reported_by_the_main_process() -> None:
    with (
        CameraWorkers(WORLD, 0, CAMERAS, DetectorChoice("nothing_like_it"), count=1) as workers,
        pytest.raises(BadInputError, match="nothing_like_it"),
    ):
        workers.wait_until_ready()


def test_every_camera_of_the_stack_looks_at_the_windows_that_its_limits_and_changes_leave() -> None:
    detector = DetectorChoice().load()
    assert isinstance(detector, PedestrianDetector)
    station = CameraStation(WORLD, 0, CAMERAS, detector)
    looked_at: list[int] = []
    whole_scan = detector.proposer.scan

    def counted(image: NDArray[np.uint8], area: SearchArea | None = None) -> Scan:
        found = whole_scan(image, area)
        looked_at.append(found.windows)
        return found

    detector.proposer.scan = counted  # type: ignore[method-assign]
    with Simulator(WORLD, renderer=None) as simulator:
        simulator.reset()
        images = station.frames.render(CAMERAS, simulator.render_state)
    (ceiling, onboard) = station.detector.detect(frames(images))
    everywhere = whole_scan(images[0]).windows
    assert len(ceiling.boxes) == len(onboard.boxes) == 1
    assert everywhere == 73_888
    assert 0 < looked_at[0] < 0.2 * everywhere
    assert 0 < looked_at[1] < 0.4 * everywhere
    station.frames.close()
