"""Detection as processes that never keep the loop waiting: images go in as they come, people come out later."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Mapping, Sequence
from multiprocessing.connection import Connection

from han_bullet.detection.camera_detector import FrameDetector
from han_bullet.detection.pictures import Image
from han_bullet.detector_choice import DetectorChoice
from han_bullet.errors import HanError
from han_bullet.fork_server import worker_context
from han_bullet.geometry import Pose2D, SolidBox
from han_bullet.messages import CameraImage, Frame, FrameDetections, Seat
from han_bullet.mounted_camera import MountedCamera, camera_detector
from han_bullet.worker_pipes import Worker, answered, serving

GATHER = 0.03  # [s] that a batch waits for the other cameras' images: theirs may come a little later
IMPORTED = ("han_bullet.detection_workers", "han_bullet.detection.cnn", "numba.np.arraymath")  # once, for all workers


class DetectionWorkers(FrameDetector):
    """Look for people in batches: the newest image of each camera, all handed on together when the last is done.

    Frames thus reach the tracker in the order in which they were exposed, which it needs, however long each took. While
    a batch is looked at, of a camera's further images only the newest is kept.

    Args:
        cameras: In use.
        empty_scenes: What fixed cameras see without people, by name; of others every mistake of the detector counts.
        seats: Sitting areas of the map.
        obstacles: Walls and furniture.
        choice: The detector that every worker loads.
        count: Number of processes at most; an image is one task, so there are no more than cameras.

    Raises:
        WorkerDiedError: From any method, when a worker has ended.
    """

    def __init__(
        self,
        cameras: Sequence[MountedCamera],
        empty_scenes: Mapping[str, Image],
        seats: Sequence[Seat],
        obstacles: Sequence[SolidBox],
        choice: DetectorChoice,
        count: int,
    ) -> None:
        self._newest: dict[str, CameraImage] = {}
        self._cameras, self._offered_at = len(cameras), 0.0
        self._waiting: deque[CameraImage] = deque()
        self._batch: tuple[CameraImage, ...] = ()
        self._found: dict[tuple[str, float], FrameDetections] = {}
        self._busy: dict[Worker, CameraImage] = {}
        self._workers: list[Worker] = []
        context = worker_context(IMPORTED)
        try:
            for index in range(min(count, len(cameras))):
                name = f"detection-worker-{index}"
                arguments = (tuple(cameras), dict(empty_scenes), tuple(seats), tuple(obstacles), choice)
                self._workers.append(Worker.started(context, name, _serve, *arguments))
        except BaseException:
            self.close()
            raise

    def wait_until_ready(self) -> float:
        """Wait until every worker has loaded its detector; return its score threshold. To be called once."""
        return min(float(worker.receive()) for worker in self._workers)

    def offer(self, image: CameraImage) -> None:
        """Take an image; it replaces one of the same camera that nobody has looked at yet."""
        if not self._newest:
            self._offered_at = time.monotonic()
        self._newest[image.camera] = image

    def advance(self) -> None:
        """Take what workers have found, and hand them what waits."""
        for worker in answered(self._busy, timeout=0.0):
            image = self._busy.pop(worker)
            self._found[image.camera, image.time] = worker.receive()
        self._hand_out()

    def finished(self) -> tuple[CameraImage, ...]:
        """Return the images of a batch that has been looked at since the last call, often none; begin the next."""
        self.advance()
        if self._busy or self._waiting:
            return ()
        done, self._batch = self._batch, ()
        if len(self._newest) == self._cameras or time.monotonic() - self._offered_at > GATHER:
            self._batch, self._newest = tuple(self._newest.values()), {}
            self._waiting.extend(self._batch)
            self._hand_out()
        return done

    def detect(self, frames: Sequence[Frame]) -> list[FrameDetections]:
        """Return what was found in each frame of a finished batch, each of which can be asked for once."""
        for frame in frames:
            if (frame.camera, frame.time) not in self._found:
                raise HanError(f"frame of {frame.camera!r} at {frame.time} s is not among those just looked at")
        return [self._found.pop((frame.camera, frame.time)) for frame in frames]

    @property
    def process_ids(self) -> list[int]:
        """Return the operating system's ids of the workers."""
        return [worker.process.pid for worker in self._workers]

    def close(self) -> None:
        """End the workers."""
        for worker in self._workers:
            worker.stop()
        self._workers = []

    def __enter__(self) -> DetectionWorkers:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _hand_out(self) -> None:
        for worker in self._workers:
            if self._waiting and worker not in self._busy:
                self._busy[worker] = image = self._waiting.popleft()
                worker.send(image.placed(Pose2D(0.0, 0.0, 0.0)))  # where it was nobody asks here


def _serve(
    connection: Connection,
    cameras: Sequence[MountedCamera],
    empty_scenes: Mapping[str, Image],
    seats: Sequence[Seat],
    obstacles: Sequence[SolidBox],
    choice: DetectorChoice,
) -> None:
    """Look at frames until the main process closes the connection; the body of a worker process."""
    with serving(connection):
        chosen = choice.load()
        detector = camera_detector(chosen, cameras, empty_scenes, seats, obstacles)
        connection.send(chosen.threshold)
        while True:
            connection.send(detector.detect([connection.recv()])[0])
