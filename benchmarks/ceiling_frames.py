"""How long the detector takes on the stack's frames, with and without knowing where people may be, and whom it finds.

Every frame of the rendered sequences is looked at in each way in turn, as `CameraDetector` does in a run: everywhere,
then within the scan limits of its camera, then (fixed cameras) also only where something changed. Frames of the
corridor's ceiling cameras, of a person on the couch, and of the robot's camera, whose limits are as constant. Times are
those of the processor in this thread, so that other processes only count by what they take of its caches.

Usage: python -m benchmarks.ceiling_frames [--frames 1000] [--seed 0]
"""

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from rich.console import Console
from rich.progress import Progress

from benchmarks.contact_sheet import ContactSheet
from benchmarks.provenance import provenance
from benchmarks.rendered_people import COUCH_SHARE, Tally, count
from han_bullet.detection.acf import AcfDetector, Scan, load_acf_model
from han_bullet.detection.camera_detector import CameraDetector
from han_bullet.detection.cnn import load_classifier
from han_bullet.detection.detector import Detector
from han_bullet.detection.pedestrian_detector import PedestrianDetector
from han_bullet.detection.pictures import Image
from han_bullet.detection.scan_limits import SHORTEST_SEATED, limits_on_floor
from han_bullet.detection.search_area import SearchArea
from han_bullet.detection.threads import use_one_thread
from han_bullet.markdown import markdown_table
from han_bullet.messages import Detections
from han_bullet.rendered_sequences import RenderedFrame, corridor, couch, mbot

EVERYWHERE, LIMITED, CHANGED = "everywhere", "scan limits", "scan limits, what changed"
HEADER = ("sequence", "where people are looked for", "frames", "ACF [ms]", "CNN [ms]", "all [ms]", "all, 95 % [ms]")


class CountingAcf(AcfDetector):
    """Counts the windows that it looks at."""

    windows = 0

    def scan(self, image: Image, area: SearchArea | None = None) -> Scan:
        """Scan and count."""
        found = super().scan(image, area)
        self.windows += found.windows
        return found


class Timed(Detector):
    """The shipped detector, which is told where to look only as far as a way has it, and times its stages.

    Attributes:
        taken: Seconds in the first and in the second stage since they were last set to 0.
    """

    def __init__(self, inner: PedestrianDetector, way: str, limits: SearchArea | None = None) -> None:
        """Take a detector, and the limits of the way that has no others."""
        self.inner, self.way, self.limits = inner, way, limits
        self.smallest_area = inner.smallest_area
        self.taken = [0.0, 0.0]

    def detect(self, image: Image) -> Detections:
        """Detect everywhere."""
        return self.decide(image, self.propose(image))

    def propose(self, image: Image, area: SearchArea | None = None) -> Detections:
        """Propose where the way has it."""
        started = time.thread_time()
        found = self.inner.propose(image, {EVERYWHERE: None, LIMITED: self.limits, CHANGED: area}[self.way])
        self.taken[0] += time.thread_time() - started
        return found

    def decide(self, image: Image, proposals: Detections) -> Detections:
        """Decide."""
        started = time.thread_time()
        kept = self.inner.decide(image, proposals)
        self.taken[1] += time.thread_time() - started
        return kept


@dataclass
class Record:
    """What one way took and found.

    Attributes:
        tally: Whom it found.
        times: Of each frame with a person who counts: ACF, CNN, all with the comparison with the empty scene [s].
        windows: Looked at in each of these frames.
    """

    tally: Tally
    times: list[tuple[float, float, float]] = field(default_factory=list)
    windows: list[int] = field(default_factory=list)

    def row(self, sequence: str, way: str) -> tuple[object, ...]:
        """Return a line of the table."""
        if not self.times:
            return sequence, way, 0, "-", "-", "-", "-", "-", self.tally.recall(), "-"
        times = 1e3 * np.array(self.times)
        medians = [float(np.median(column)) for column in times.T]
        windows = float(np.median(self.windows))
        rate = f"{self.tally.false_positives / self.tally.frames:.3f}"
        return (
            sequence,
            way,
            len(times),
            *medians,
            float(np.percentile(times[:, 2], 95)),
            windows,
            self.tally.recall(),
            rate,
        )


class Way:
    """One way to look at the frames of a sequence."""

    def __init__(self, way: str) -> None:
        """Load a detector."""
        model = load_acf_model()
        self.way, self.acf = way, CountingAcf(model)
        self.detector = PedestrianDetector(self.acf, load_classifier(), model.score_threshold)
        self.record = Record(Tally(way))
        self._take = -1

    def look(self, frame: RenderedFrame) -> None:
        """Detect in a frame and note everything; the first frame of a take also calibrates."""
        if frame.take != self._take:
            self._start(frame)
        self.acf.windows, self._timed.taken = 0, [0.0, 0.0]
        started = time.thread_time()
        (found,) = self._cameras.detect([frame.frame])
        whole = time.thread_time() - started
        count(frame, found, self.record.tally, (ContactSheet(), ContactSheet()))
        if len(frame.boxes):
            self.record.times.append((self._timed.taken[0], self._timed.taken[1], whole))
            self.record.windows.append(self.acf.windows)

    def _start(self, frame: RenderedFrame) -> None:
        """Set up the camera of a take."""
        self._take = frame.take
        pose, intrinsics = frame.frame.camera_in_world, frame.frame.intrinsics
        limits = limits_on_floor(intrinsics, pose, shortest=SHORTEST_SEATED)
        self._timed = Timed(self.detector, self.way, limits)
        self._cameras = CameraDetector(self._timed, {} if self.way == EVERYWHERE else {frame.frame.camera: limits})
        if frame.empty is not None:
            self._cameras.calibrate([replace(frame.frame, image=frame.empty)])


def measure(name: str, frames: Iterator[RenderedFrame]) -> list[tuple[object, ...]]:
    """Return the table's lines of one sequence."""
    ways: list[Way] = []
    for frame in frames:
        if not ways:
            names = (EVERYWHERE, LIMITED) if frame.empty is None else (EVERYWHERE, LIMITED, CHANGED)
            ways = [Way(way) for way in names]
            for way in ways:
                way.detector.detect(frame.image)  # compiled code loaded
        for way in ways:
            way.look(frame)
    return [way.record.row(name, way.way) for way in ways]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--frames", type=int, default=1000, help="of corridor and MBOT; the couch gets a fifth")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    use_one_thread()
    lines: list[tuple[object, ...]] = []
    sequences = (("corridor", corridor, 1), ("couch", couch, COUCH_SHARE), ("MBOT", mbot, 1))
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for name, sequence, share in sequences:
            frames = max(1, options.frames // share)
            task = progress.add_task(name, total=frames)
            report = partial(_advance, progress, task)
            lines += measure(name, sequence(frames, options.seed, report))
    print(f"### Where people are looked for, seed {options.seed}\n\n{provenance()}; one thread\n")
    print("Medians over the frames with a person who counts; the comparison with the empty scene is in all.\n")
    print(markdown_table((*HEADER, "windows", "recall (people)", "false positives per image"), lines))


def _advance(progress: Progress, task: object, done: int) -> None:
    progress.update(task, completed=done)  # type: ignore[arg-type]


if __name__ == "__main__":
    main()
