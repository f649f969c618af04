"""Our tracker and Stone Soup's on the same detections: how well, and how fast, by the number of people.

Usage: python -m benchmarks.tracker [--people 2 5 10 20] [--acceleration 0.3 1.5] [--seconds 20] [--seeds 3] [--limit 2]

People walk, turn, stop and cross each other in a room of 12 x 12 m, half a metre apart at least; the last rows are 20
people in 5 x 5 m. Ten scans a second find a person with probability 0.9 and 0.1 m of noise on each axis, and 0.005
false measurements per square metre. All trackers have the same motion model, noise, gate, probability of detection and
clutter density, and begin a track after three measurements. They differ in this:

- Stone Soup ends a track 1.5 s after its last measurement; ours after 0.6 s while it is young, 1.5 s if the person
  walks and 3 s if they stand.
- Ours joins a new track to a lost one near by, lets confirmed tracks choose first, and takes no measurement more than
  1 m off.
- Stone Soup's JPDA corrects a track by the mean over all measurements; ours, the nearest neighbour version, by one.
- Stone Soup's GNN has the least sum of distances, ours the most likely event.
- Ours has the whole room in view at all times, without a camera's geometry.
"""

import argparse
import math
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from types import FrameType

import numpy as np
from numpy.typing import NDArray

from benchmarks.crowd import CLUTTER_DENSITY, DETECTION_PROBABILITY, POSITION_DEVIATION, SCAN_PERIOD, Recording, record
from benchmarks.provenance import provenance
from benchmarks.track_quality import TrackQuality
from han_bullet.assembly import ASSOCIATIONS
from han_bullet.commands.parsing import positive
from han_bullet.errors import HanError
from han_bullet.geometry import Array, Intrinsics, Pose2D
from han_bullet.markdown import markdown_table
from han_bullet.messages import Frame, Scan
from han_bullet.tracking.field_of_view import FieldOfView
from han_bullet.tracking.kalman import ACCELERATION_DEVIATION, ConstantVelocity
from han_bullet.tracking.tracker import MultiCameraTracker

ROOM, SMALL_ROOM, CROWD = 12.0, 5.0, 20  # [m], [m], people
# Accelerations that a tracker expects [m/s^2]: what ours does, and what suits the people of `crowd`.
MODELS = (ACCELERATION_DEVIATION, 1.5)
COLUMNS = (
    "people",
    "room [m]",
    "tracker",
    "OSPA, mean [m]",
    "OSPA, median [m]",
    "ID switches",
    "median [ms]",
    "95 % [ms]",
)

Step = Callable[[int], dict[int, Array]]  # the scan's number -> positions (2,) [m] by id
Start = Callable[[Recording], Step]


class TooSlow(HanError):
    """A scan took longer than it may."""


class WholeRoom(FieldOfView):
    """A view in which everybody always is."""

    def sees(self, frame: Frame, positions: Array, *, robot: Pose2D | None = None) -> NDArray[np.bool_]:
        """Say yes."""
        return np.ones(len(positions), bool)

    def hidden_by_people(self, frame: Frame, positions: Array, people: Array) -> NDArray[np.bool_]:
        """Say no."""
        return np.zeros(len(positions), bool)


@dataclass
class Outcome:
    """What one tracker did in all recordings of one size.

    Attributes:
        quality: One per recording.
        times: Of all scans [s].
        too_slow: Whether a scan took longer than it may; the rest of that recording is missing then.
    """

    quality: list[TrackQuality] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    too_slow: bool = False


def ours(association: str, motion: ConstantVelocity) -> Start:
    """Return what starts our tracker with an association by its name."""

    def start(recording: Recording) -> Step:
        chosen = ASSOCIATIONS[association](detection_probability=DETECTION_PROBABILITY, clutter_density=CLUTTER_DENSITY)
        tracker = MultiCameraTracker(field_of_view=WholeRoom(), association=chosen, motion=motion)
        scans = [_scan(k, found) for k, found in enumerate(recording.measurements)]
        return lambda k: {p.id: p.position_in_world for p in tracker.update([scans[k]], scans[k].time)}

    return start


def _scan(number: int, found: Array) -> Scan:
    at, covariances = number * SCAN_PERIOD, np.tile(POSITION_DEVIATION**2 * np.eye(2), (len(found), 1, 1))
    frame = Frame("room", at, np.zeros((1, 1, 3), np.uint8), Intrinsics(1, 1, 1.0, 1.0, 0.5, 0.5), np.eye(4), True)
    return Scan("room", at, found, covariances, np.arange(len(found)), frame)


def stone_soup(motion: ConstantVelocity) -> dict[str, Start]:
    """Return what starts Stone Soup's trackers, by name.

    Raises:
        BadInputError: Stone Soup is not installed.
    """
    from benchmarks import stone_soup  # only here, so that ours run without it

    return {
        "Stone Soup GNN": partial(stone_soup.gnn, motion=motion),
        "Stone Soup JPDA": partial(stone_soup.jpda, motion=motion),
        "Stone Soup JPDA, EHM2": partial(stone_soup.jpda_ehm2, motion=motion),
    }


def everybody(motion: ConstantVelocity) -> dict[str, Start]:
    """Return what starts each tracker of the comparison, by name."""
    return {f"ours, {name}": ours(name, motion) for name in ASSOCIATIONS} | stone_soup(motion)


def compare(trackers: dict[str, Start], recordings: Sequence[Recording], limit: float) -> dict[str, Outcome]:
    """Let trackers take turns at every scan; one with a scan over the limit [s] takes no further part."""
    outcomes = {name: Outcome() for name in trackers}
    for recording in recordings:
        steps = {name: start(recording) for name, start in trackers.items() if not outcomes[name].too_slow}
        for name in steps:
            outcomes[name].quality.append(TrackQuality())
        for k, truth in enumerate(recording.positions):
            for name in [name for name in steps if not outcomes[name].too_slow]:
                outcome, started = outcomes[name], time.perf_counter()
                try:
                    with at_most(limit):
                        tracks = steps[name](k)
                except TooSlow:
                    outcome.too_slow = True
                    continue
                outcome.times.append(time.perf_counter() - started)
                outcome.quality[-1].record(tracks, truth)
    return outcomes


@contextmanager
def at_most(seconds: float) -> Iterator[None]:
    """Raise TooSlow in what runs longer than some seconds."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise TooSlow(f"longer than {seconds:g} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def rows(people: int, side: float, outcomes: dict[str, Outcome], limit: float) -> list[tuple[object, ...]]:
    """Return a line for each tracker; one that was too slow has no figures, for the hard scans would miss in them."""
    lines: list[tuple[object, ...]] = []
    for name, outcome in outcomes.items():
        size = (people, f"{side:g} x {side:g}", name)
        if outcome.too_slow:
            lines.append((*size, "-", "-", "-", f"too slow (> {limit:g} s per scan)", "-"))
            continue
        distances = np.concatenate([quality.ospa for quality in outcome.quality])
        switches = sum(quality.id_switches for quality in outcome.quality)
        median, late = 1e3 * np.percentile(outcome.times, (50, 95))
        figures = (f"{distances.mean():.3f}", f"{np.median(distances):.3f}", switches)
        lines.append((*size, *figures, f"{median:.2f}", f"{late:.2f}"))
    return lines


def positive_number(text: str) -> float:
    """Read a positive number."""
    number = float(text)
    if not 0.0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number")
    return number


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--people", type=positive, nargs="+", default=[2, 5, 10, 20], help="how many in 12 x 12 m")
    parser.add_argument("--acceleration", type=positive_number, nargs="+", default=MODELS, help="expected [m/s^2]")
    parser.add_argument("--seconds", type=positive, default=20, help="of each recording")
    parser.add_argument("--seeds", type=positive, default=3, help="recordings of each size")
    parser.add_argument("--limit", type=positive_number, default=2.0, help="for one scan of one tracker [s]")
    options = parser.parse_args()
    try:
        models = {number: everybody(ConstantVelocity(acceleration_deviation=number)) for number in options.acceleration}
    except HanError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
    print("### Trackers of people on the same detections\n")
    print(f"{provenance()}; {options.seeds} recordings of {options.seconds} s at {1.0 / SCAN_PERIOD:.0f} Hz\n")
    print(
        f"Probability of detection {DETECTION_PROBABILITY}, noise {POSITION_DEVIATION} m, {CLUTTER_DENSITY} false "
        "measurements per square metre and scan; OSPA with c = 1 m and p = 2; the trackers take turns at every scan."
    )
    sizes = [*((number, ROOM) for number in options.people), (CROWD, SMALL_ROOM)]
    for deviation, trackers in models.items():
        lines: list[tuple[object, ...]] = []
        for people, side in sizes:
            recordings = [record(people, side, options.seconds, seed) for seed in range(options.seeds)]
            lines += rows(people, side, compare(trackers, recordings, options.limit), options.limit)
        ours_by_default = ", as our tracker has it" if deviation == ACCELERATION_DEVIATION else ""
        print(f"\nMotion model with accelerations of {deviation:g} m/s^2{ours_by_default}:\n")
        print(markdown_table(COLUMNS, lines), flush=True)


if __name__ == "__main__":
    main()
