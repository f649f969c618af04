"""Cameras as processes: rendering and detection of the camera frames, spread over workers in lockstep with the loop.

Each worker can serve every camera: the main process hands the next waiting camera to whichever worker is free and
waits until all are done. What a task gives depends only on what is handed over, so the number of workers never shows
in a result. Images travel through shared memory.
"""

from __future__ import annotations

from collections.abc import Sequence
from multiprocessing.connection import Connection
from multiprocessing.shared_memory import SharedMemory
from types import TracebackType

import numpy as np

from han_bullet.detection.camera_detector import FrameDetector
from han_bullet.detection.detector import Detector
from han_bullet.detection.threads import use_one_thread
from han_bullet.detector_choice import DetectorChoice
from han_bullet.errors import HanError
from han_bullet.fork_server import worker_context
from han_bullet.messages import Frame, FrameDetections
from han_bullet.mounted_camera import MountedCamera, camera_detector
from han_bullet.sim.renderer import FrameSource, Image, InProcessRenderer
from han_bullet.sim.scene_state import SceneState
from han_bullet.worker_pipes import Worker, answered, serving
from han_bullet.world_schema import Camera, World


class CameraStation:
    """Render and detect in this process: what a worker does, and what a run without workers does.

    Args:
        world: The concrete world.
        seed: Of the image noise.
        cameras: Names of the cameras in use: each tells how high people appear to it, and a fixed one gives a
            person-free image.
        detector: Of single images.
    """

    def __init__(self, world: World, seed: int, cameras: Sequence[str], detector: Detector) -> None:
        use_one_thread()
        self.frames = InProcessRenderer(world, seed)
        mounted = [MountedCamera.of_world(world.camera(name)) for name in cameras]
        fixed = [camera.name for camera in mounted if camera.fixed]
        empty_scenes = dict(zip(fixed, self.frames.calibration_images(fixed), strict=True))
        self.detector = camera_detector(detector, mounted, empty_scenes, world.seats(), world.solid_boxes())


class CameraWorkers(FrameSource, FrameDetector):
    """Worker processes that together are one source of frames and one detector.

    Args:
        world: The concrete world.
        seed: Of the image noise.
        cameras: Names of the cameras in use.
        choice: The detector that every worker loads.
        count: Number of processes at most; a camera is one task, so there are no more than cameras.

    Raises:
        WorkerDiedError: From any method, when a worker has ended.
    """

    def __init__(self, world: World, seed: int, cameras: Sequence[str], choice: DetectorChoice, count: int) -> None:
        self._shapes = {name: (*reversed(world.camera(name).size), 3) for name in cameras}
        self._onboard = {name for name in cameras if not world.camera(name).fixed}
        self._memories: dict[str, SharedMemory] = {}
        self._workers: list[Worker] = []
        self._threshold: float | None = None
        self._found: dict[tuple[str, float], FrameDetections] = {}
        try:
            for name, shape in self._shapes.items():
                self._memories[name] = SharedMemory(create=True, size=int(np.prod(shape)))
            self._start(world, seed, tuple(cameras), choice, min(count, len(cameras)))
        except BaseException:  # above all the keyboard, while the server still imports
            self.close()
            raise

    def render(self, cameras: Sequence[str], state: SceneState) -> list[Image]:
        """Return one image per camera, shape (height, width, 3), uint8.

        The worker that renders a picture looks for people in it at once, while other pictures are still being made;
        `detect` hands over what it found.
        """
        found = self._spread(self._longest_first(cameras), state)
        self._found = {(name, state.exposure_of(name).time): detections for name, detections in found.items()}
        return [self._view(name).copy() for name in cameras]

    def detect(self, frames: Sequence[Frame]) -> list[FrameDetections]:
        """Return the detections of frames whose pictures the last `render` made.

        Raises:
            HanError: A frame is another one.
        """
        for frame in frames:
            if (frame.camera, frame.time) not in self._found:
                raise HanError(f"frame of {frame.camera!r} at {frame.time} s is not among those just rendered")
        return [self._found[frame.camera, frame.time] for frame in frames]

    @property
    def process_ids(self) -> list[int]:
        """Return the operating system's ids of the workers."""
        return [worker.process.pid for worker in self._workers]

    def wait_until_ready(self) -> float:
        """Wait until every worker has loaded world and detector; return the detector's score threshold."""
        if self._threshold is None:
            thresholds = [worker.receive() for worker in self._workers]
            self._threshold = float(thresholds[0])
        return self._threshold

    def close(self) -> None:
        """End the workers and free the shared memory."""
        for worker in self._workers:
            worker.stop()
        for memory in self._memories.values():
            memory.close()
            memory.unlink()
        self._workers, self._memories = [], {}

    def __enter__(self) -> CameraWorkers:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _start(self, world: World, seed: int, cameras: tuple[str, ...], choice: DetectorChoice, count: int) -> None:
        context = worker_context()
        names = {name: memory.name for name, memory in self._memories.items()}
        for index in range(count):
            name = f"camera-worker-{index}"
            self._workers.append(Worker.started(context, name, _serve, world, seed, cameras, choice, names))

    def _view(self, camera: str) -> Image:
        return np.ndarray(self._shapes[camera], np.uint8, self._memories[camera].buf)

    def _longest_first(self, cameras: Sequence[str]) -> list[str]:
        """Put the onboard camera first: it renders everything and must not be the last one waited for."""
        return sorted(cameras, key=lambda name: name not in self._onboard)

    def _spread(self, cameras: list[str], state: SceneState) -> dict[str, FrameDetections]:
        """Hand each camera to the next free worker; return what was found, by camera."""
        self.wait_until_ready()
        waiting, free = list(cameras), list(self._workers)
        busy: dict[Worker, str] = {}
        results: dict[str, FrameDetections] = {}
        while waiting or busy:
            while waiting and free:
                worker, camera = free.pop(0), waiting.pop(0)
                worker.send((camera, state))
                busy[worker] = camera
            for worker in answered(busy):
                results[busy.pop(worker)] = worker.receive()
                free.append(worker)
        return results


def _serve(
    connection: Connection,
    world: World,
    seed: int,
    cameras: tuple[str, ...],
    choice: DetectorChoice,
    memory_names: dict[str, str],
) -> None:
    """Answer tasks until the main process closes the connection; the body of a worker process."""
    try:
        memories = {name: SharedMemory(memory) for name, memory in memory_names.items()}
    except FileNotFoundError:  # the main process has gone already
        return
    shapes = {name: (*reversed(world.camera(name).size), 3) for name in cameras}
    views: dict[str, Image] = {name: np.ndarray(shapes[name], np.uint8, memories[name].buf) for name in cameras}
    with serving(connection):
        detector = choice.load()
        station = CameraStation(world, seed, cameras, detector)
        connection.send(detector.threshold)
        while True:
            camera, state = connection.recv()
            connection.send(_look(station, world.camera(camera), state, views[camera]))
    views.clear()
    for memory in memories.values():
        memory.close()


def _look(station: CameraStation, camera: Camera, state: SceneState, view: Image) -> FrameDetections:
    """Render a picture and find the people in it; where the camera believes to be is not known here, nor needed."""
    view[:] = station.frames.render([camera.name], state)[0]
    time = state.exposure_of(camera.name).time
    frame = Frame(camera.name, time, view, camera.intrinsics, np.full((4, 4), np.nan), camera.fixed)
    return station.detector.detect([frame])[0]
