"""Which rendered people a detector finds, and which it does not: by height, view, hiding, facing and posture.

It looks at the detector as a run uses it, at its threshold, with and without the still scene of fixed cameras, and
saves its mistakes as pictures. Miss rates and speeds of its stages on the same sequences are those of
`han-bullet evaluate --rendered`.

Usage: python -m benchmarks.rendered_people [--frames 1000] [--seed 0] [--model default] [--out DIR]
"""

import argparse
import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import Progress

from benchmarks.contact_sheet import ContactSheet
from benchmarks.provenance import provenance
from han_bullet.detection.camera_detector import CameraDetector
from han_bullet.detection.detector import Detector
from han_bullet.detection.loading import load_detector
from han_bullet.detection.matching import assign, fix_aspect, in_ignored
from han_bullet.detection.threads import use_one_thread
from han_bullet.markdown import markdown_table
from han_bullet.messages import Detections
from han_bullet.rendered_sequences import PersonInPicture, RenderedFrame, corridor, couch, mbot

COUCH_SHARE = 5  # the couch gets a fifth of the frames: only noise, light, clothes and build differ there
BANDS: tuple[tuple[str, Callable[[PersonInPicture], float], tuple[float, ...], str], ...] = (
    ("height", lambda person: float(person.box[3]), (110.0, 150.0, 200.0, 300.0, 480.0), "px"),
    ("seen from above", lambda person: math.degrees(person.elevation), (-5.0, 5.0, 15.0, 25.0, 35.0), "degrees"),
    ("hidden", lambda person: 100.0 * person.hidden, (0.0, 1e-9, 10.0, 20.0, 30.1), "%"),
    ("turned away", lambda person: math.degrees(abs(person.facing)), (0.0, 45.0, 75.0, 105.0, 135.0, 180.1), "degrees"),
)


@dataclass
class Tally:
    """What one detector did on one sequence.

    Attributes:
        name: Of sequence and detector.
        frames: How many there were.
        false_positives: Detections of nobody, of somebody twice, or of a part of somebody.
        sightings: Each time a person who counts was in the picture, and whether they were found.
    """

    name: str
    frames: int = 0
    false_positives: int = 0
    sightings: list[tuple[PersonInPicture, bool]] = field(default_factory=list)

    def recall(self, wanted: Callable[[PersonInPicture], bool] = lambda person: True) -> str:
        """Return the share that was found of some people, and how many they are."""
        found = [found for person, found in self.sightings if wanted(person)]
        return f"{np.mean(found):.3f} ({len(found)})" if found else "-"


def count(frame: RenderedFrame, found: Detections, tally: Tally, sheets: tuple[ContactSheet, ContactSheet]) -> None:
    """Add one frame to a tally, and what went wrong in it to the sheets of misses and of false positives."""
    misses, mistakes = sheets
    persons = assign(found.boxes, fix_aspect(frame.boxes))
    excused = in_ignored(found.boxes, frame.ignored)
    tally.frames += 1
    for number, person in enumerate(person for person in frame.people if person.counts):
        hit = number in persons
        tally.sightings.append((person, hit))
        if not hit:
            misses.add(frame, person.box, found, describe(person))
    for number in np.flatnonzero((persons < 0) & ~excused):
        tally.false_positives += 1
        mistakes.add(frame, found.boxes[number], found, f"score {found.scores[number]:.0f}")


def describe(person: PersonInPicture) -> str:
    """Return a person's height, hidden share, elevation and facing in a line."""
    turned, steep = math.degrees(person.facing), math.degrees(person.elevation)
    return f"{person.box[3]:.0f} px {100 * person.hidden:.0f}% {steep:.0f} deg, turned {turned:.0f}"


class BothWays:
    """Detects in a picture alone and, where the camera is fixed, with the still scene as in a run."""

    def __init__(self, detector: Detector) -> None:
        self._image_detector, self._camera_detector = detector, CameraDetector(detector)
        self._calibrated: object = None

    def detect(self, frame: RenderedFrame) -> list[tuple[str, Detections]]:
        """Return the name of each way and what it finds."""
        ways = [("image alone", self._image_detector.detect(frame.image))]
        if frame.empty is None:
            return ways
        if frame.empty is not self._calibrated:  # once for a take
            self._camera_detector.calibrate([replace(frame.frame, image=frame.empty)])
            self._calibrated = frame.empty
        return [*ways, ("with still scene", self._camera_detector.detect([frame.frame])[0])]


def measure(name: str, frames: Iterator[RenderedFrame], detector: BothWays, out: Path | None) -> Iterator[Tally]:
    """Yield a tally for each way to detect, over one sequence; save contact sheets where a folder is given."""
    tallies: dict[str, tuple[Tally, tuple[ContactSheet, ContactSheet]]] = {}
    for frame in frames:
        for way, found in detector.detect(frame):
            if way not in tallies:
                tallies[way] = Tally(f"{name}, {way}"), (ContactSheet(), ContactSheet())
            count(frame, found, *tallies[way])
    for way, (tally, sheets) in tallies.items():
        for what, sheet in zip(("misses", "false_positives"), sheets, strict=True):
            if out is not None:
                sheet.save(out / f"{name}_{way.replace(' ', '_')}_{what}.png")
        yield tally


def rows(tallies: list[Tally]) -> list[list[object]]:
    """Return the table: first the figures, then recall by band."""
    result: list[list[object]] = [
        ["frames", *(tally.frames for tally in tallies)],
        ["false positives per image", *(f"{tally.false_positives / tally.frames:.3f}" for tally in tallies)],
        ["**recall (people)**", *(f"**{tally.recall()}**" for tally in tallies)],
    ]
    for name, value, edges, unit in BANDS:
        for low, high in itertools.pairwise(edges):
            cells = [tally.recall(lambda p, f=value, a=low, b=high: a <= f(p) < b) for tally in tallies]
            band = "not" if high == 1e-9 else f"{low:.0f} to {high:.0f} {unit}"
            result.append([f"{name}: {band}", *cells])
    for posture in ("walking", "standing", "seated"):
        cells = [tally.recall(lambda p, wanted=posture: p.posture.value == wanted) for tally in tallies]
        result.append([posture, *cells])
    return result


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--frames", type=int, default=1000, help="of corridor and MBOT; the couch gets a fifth")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--model", default="default", help="as `han-bullet detect` takes it")
    parser.add_argument("--out", type=Path, help="folder for contact sheets of misses and false positives")
    options = parser.parse_args()
    use_one_thread()
    detector = BothWays(load_detector(options.model))
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
    tallies: list[Tally] = []
    sequences = (("corridor", corridor, 1), ("MBOT", mbot, 1), ("couch", couch, COUCH_SHARE))
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for name, sequence, share in sequences:
            frames = max(1, options.frames // share)
            report = partial(_advance, progress, progress.add_task(name, total=frames))
            tallies += measure(name, sequence(frames, options.seed, report), detector, options.out)
    print(f"### Rendered people: model {Path(options.model).stem}, seed {options.seed}\n\n{provenance()}\n")
    print(markdown_table(("", *(tally.name for tally in tallies)), rows(tallies)))


def _advance(progress: Progress, task: object, done: int) -> None:
    progress.update(task, completed=done)  # type: ignore[arg-type]


if __name__ == "__main__":
    main()
