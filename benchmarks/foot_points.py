"""How far from the true people the foot points of a run's detections are, along and across the camera's view.

The people of each frame are those of the simulator; a place belongs to the nearest of them within 1.2 m. Errors along
the view are positive where a person is placed too far from the camera. Nothing is run twice: the places are those of
the boxes as they are, and with the rows of feet that fixed cameras know.

Usage: python -m benchmarks.foot_points [--worlds real4,real2,sim2] [--seeds 2] [--first-seed 100]
"""

import argparse
import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.provenance import provenance
from han_bullet.assembly import build_projection
from han_bullet.episode import Hook, Tick
from han_bullet.geometry import Array
from han_bullet.markdown import markdown_table
from han_bullet.messages import Detections, Frame, Scan
from han_bullet.runner import RunOptions, run_world
from han_bullet.tracking.projection import GroundProjection
from han_bullet.variation import vary
from han_bullet.world_file import load_world

SAME_PERSON = 1.2  # [m]
HEIGHTS = (0.0, 120.0, 160.0, 200.0, 260.0, 480.0)  # [px]
WAYS = ("by the box", "with known feet")


@dataclass(frozen=True)
class FootError:
    """One place against the truth.

    Attributes:
        camera: Its name.
        posture: Of the true person.
        height: Of the box [px].
        by_feet: Whether the place is that of the feet, not of the head or the seat.
        known: Whether the row of the feet was known.
        along, across: Error [m].
        claimed: Deviation along the view that the covariance tells [m].
    """

    camera: str
    posture: str
    height: float
    by_feet: bool
    known: bool
    along: float
    across: float
    claimed: float


class FootPoints(Hook):
    """Compares the places of every frame with the people who were there, in each way.

    Attributes:
        errors: By way.
    """

    def __init__(self, projection: GroundProjection) -> None:
        self.errors: dict[str, list[FootError]] = {way: [] for way in WAYS}
        self._projection = projection

    def record(self, tick: Tick) -> None:
        """Take note of the frames of one tick."""
        people = np.array([person.pose_in_world.position for person in tick.truth.people]).reshape(-1, 2)
        postures = [person.posture.value for person in tick.truth.people]
        for image, found in zip(tick.observation.images, tick.decision.detections, strict=True):
            bare = Detections(found.boxes, found.scores, found.probabilities)
            robot = tick.decision.estimate.pose_robot_in_world
            frame = image.placed(robot)
            rows = self._projection.known_rows(frame, found.boxes, found.feet, robot)
            for way, detections in zip(WAYS, (bare, replace(found, feet=rows)), strict=True):
                scan = self._projection.project(frame, detections, robot)
                self.errors[way] += self._compare(frame, detections, scan, people, postures)

    def _compare(
        self, frame: Frame, found: Detections, scan: Scan, people: Array, postures: list[str]
    ) -> list[FootError]:
        feet = self._projection.foot_points(frame, found.boxes, found.feet).positions
        eye = frame.camera_in_world[:2, 3]
        errors = []
        for place, covariance, box in zip(scan.positions, scan.covariances, scan.sources, strict=True):
            distances = np.linalg.norm(people - place, axis=1)
            if distances.min(initial=np.inf) > SAME_PERSON:
                continue
            person = int(distances.argmin())
            ray = (people[person] - eye) / np.linalg.norm(people[person] - eye)
            off = place - people[person]
            errors.append(
                FootError(
                    frame.camera,
                    postures[person],
                    float(found.boxes[box, 3]),
                    bool(np.allclose(feet[box], place)),
                    found.feet is not None and bool(np.isfinite(found.feet[box])),
                    float(off @ ray),
                    float(ray[0] * off[1] - ray[1] * off[0]),
                    float(np.sqrt(ray @ covariance @ ray)),
                )
            )
        return errors


def row(name: str, errors: list[FootError]) -> list[object]:
    """Return how many errors there are, of how many feet the row is known, and their figures."""
    along, across = (np.array([getattr(error, side) for error in errors]) for side in ("along", "across"))
    return [
        name,
        len(errors),
        f"{100.0 * np.mean([error.known for error in errors]):.0f} %",
        *(f"{value:+.3f}" for value in (along.mean(), across.mean())),
        *(f"{value:.3f}" for value in (along.std(), across.std(), np.sqrt(np.mean(along**2 + across**2)))),
        f"{np.mean([error.claimed for error in errors]):.2f}",
    ]


def rows(errors: list[FootError]) -> list[list[object]]:
    """Return the table: by camera and posture, what is placed by head or seat, then by height in the image."""
    groups: list[tuple[str, Callable[[FootError], bool]]] = []
    for camera, posture in sorted({(error.camera, error.posture) for error in errors}):
        groups.append(
            (
                f"{camera}, {posture}",
                lambda e, c=camera, p=posture: e.by_feet and (e.camera, e.posture) == (c, p),  # type: ignore[misc]
            )
        )
    groups.append(("not by the feet", lambda e: not e.by_feet))
    for low, high in itertools.pairwise(HEIGHTS):
        for kind in ("ceiling", "onboard"):
            groups.append(
                (
                    f"{kind}, {low:.0f} to {high:.0f} px",
                    lambda e, a=low, b=high, k=kind: (  # type: ignore[misc]
                        _upright(e) and a <= e.height < b and (e.camera == "onboard") == (k == "onboard")
                    ),
                )
            )
    groups += [("**ceiling cameras**", lambda e: _upright(e) and e.camera != "onboard")]
    groups += [("**onboard camera**", lambda e: _upright(e) and e.camera == "onboard")]
    chosen = [(name, [error for error in errors if wanted(error)]) for name, wanted in groups]
    return [row(name, some) for name, some in chosen if some]


def _upright(error: FootError) -> bool:
    return error.by_feet and error.posture != "seated"


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--worlds", default="real4,real2,sim2")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--first-seed", type=int, default=100, help="others than those of the scenarios")
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    errors: dict[str, list[FootError]] = {way: [] for way in WAYS}
    for world in options.worlds.split(","):
        for seed in range(options.first_seed, options.first_seed + options.seeds):
            hook = FootPoints(build_projection(vary(load_world(world), seed)))
            with TemporaryDirectory() as folder:
                run_options = RunOptions(seed=seed, workers=options.workers, video=False)
                run_world(world, run_options, Path(folder), hooks=[hook])
            for way in WAYS:
                errors[way] += hook.errors[way]
    last = options.first_seed + options.seeds - 1
    print(f"### Foot points: {options.worlds}, seeds {options.first_seed} to {last}\n\n{provenance()}")
    header = ("people [m]", "places", "feet known", "mean along", "mean across", "deviation along", "across", "RMS")
    for way in WAYS:
        print(f"\nPlaced {way}:\n\n{markdown_table((*header, 'claimed along'), rows(errors[way]))}")


if __name__ == "__main__":
    main()
