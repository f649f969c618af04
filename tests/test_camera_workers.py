import os
import signal

import numpy as np
import pytest

from han_bullet.camera_workers import CameraStation, CameraWorkers, DetectorChoice
from han_bullet.errors import BadInputError, WorkerDiedError
from han_bullet.sim.simulator import Simulator
from han_bullet.variation import vary
from han_bullet.world_file import load_world

WORLD = vary(load_world("real2"), 0)
CAMERAS = ["camera1", "onboard"]


def test_workers_give_what_one_process_gives() -> None:
    station = CameraStation(WORLD, 0, CAMERAS, DetectorChoice())
    with (
        Simulator(WORLD, renderer=None) as simulator,
        CameraWorkers(WORLD, 0, CAMERAS, DetectorChoice(), count=2) as workers,
    ):
        simulator.reset()
        here = station.frames.render(CAMERAS, simulator.render_state)
        there = workers.render(CAMERAS, simulator.render_state)
        assert all(np.array_equal(one, other) for one, other in zip(here, there, strict=True))
        assert np.array_equal(
            workers.calibration_images(["camera1"])[0], station.frames.calibration_images(["camera1"])[0]
        )
    station.frames.close()


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
