"""How far people by their legs are from the true people: standing, walking and seated, by range.

One person at a time in an empty room, in every direction from the laser and turned every way; the laser's pose is
exact. Of each sweep the measurement nearest to the person counts, if within 0.6 m. "claimed" is the root of the
covariance's trace; "fit" is half the mean squared Mahalanobis distance, 1 where the covariance is honest.

Usage: python -m benchmarks.legs [--people 150] [--seed 0]
"""

import argparse
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.provenance import provenance
from han_bullet.geometry import Array, Pose2D, rotation
from han_bullet.markdown import markdown_table
from han_bullet.messages import LaserScan, PoseEstimate, Posture
from han_bullet.sim.gait import Gait
from han_bullet.sim.laser import LaserScanner
from han_bullet.tracking.legs import PAIR_DEVIATIONS, LaserLegs
from han_bullet.world_file import parse_world
from han_bullet.world_schema import Laser

RANGES = (0.5, 1.0, 2.0, 3.0, 4.0)  # [m]
SWEEPS = 20  # of each person
PERIOD, BODY_PERIOD = 0.1, 0.05  # [s] of sweeps, and of the body's motion
SAME_PERSON = 0.6  # [m]
STILL = Pose2D(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class LegError:
    """One measurement against the truth.

    Attributes:
        pair: Whether both legs were seen.
        along, across: Error [m], along the ray positive where the person is placed too far.
        claimed: Root of the trace of the covariance [m].
        squared: Mahalanobis distance, squared.
    """

    pair: bool
    along: float
    across: float
    claimed: float
    squared: float


def scanner_before(build: str, rng: np.random.Generator) -> LaserScanner:
    """Return a scanner over the robot's middle, in a room without anything but one person of a build."""
    world = parse_world(
        {
            "name": "room",
            "description": "empty",
            "floor": [{"x": [-9.0, 9.0], "y": [-9.0, 9.0]}],
            "people": [{"name": "one", "build": build, "start": [0.0, 0.0, 0.0]}],
            "robot": {"start": [3.0, 0.0, 0.0]},
            "task": {"kind": "go_to", "pose": [5.0, 0.0, 0.0]},
        }
    )
    return LaserScanner(world, Laser(forward=0.0), rng)


def sweeps(posture: Posture, least: float, most: float, rng: np.random.Generator) -> Iterator[tuple[LaserScan, Array]]:
    """Yield sweeps with the true place, (2,) [m], of somebody at a distance between two from the scanner [m]."""
    build = ("slim", "broad")[int(rng.integers(2))]
    gait, speed = Gait(build), float(rng.uniform(0.3, 1.2)) if posture is Posture.WALKING else 0.0
    distance, bearing, yaw = rng.uniform(least, most), rng.uniform(-2.2, 2.2), rng.uniform(-math.pi, math.pi)
    scanner = scanner_before(build, rng)
    count = round(PERIOD / BODY_PERIOD)
    middle = distance * rotation(bearing)[:, 0]
    for tick in range(-40, SWEEPS * count):  # a walker has two seconds to find their stride, and is nearest halfway
        ahead = (tick - 0.5 * SWEEPS * count) * BODY_PERIOD * speed
        place = middle + ahead * rotation(yaw)[:, 0]
        body = gait.advance(Pose2D(float(place[0]), float(place[1]), yaw), speed, BODY_PERIOD, posture)
        if tick >= 0 and tick % count == 0 and least <= np.hypot(*place) <= most:
            yield scanner.scan(tick * BODY_PERIOD, STILL, [body]), place


def compare(posture: Posture, least: float, most: float, people: int, seed: int) -> tuple[list[LegError], int]:
    """Return the errors, and the number of sweeps."""
    rng, finder = np.random.default_rng(seed), LaserLegs()
    errors, total = [], 0
    for _ in range(people):
        for scan, place in sweeps(posture, least, most, rng):
            total += 1
            legs = finder.find(scan, PoseEstimate(scan.time, STILL), ())
            if legs is None or not len(legs.positions):
                continue
            row = int(np.argmin(np.linalg.norm(legs.positions - place, axis=1)))
            error, covariance = legs.positions[row] - place, legs.covariances[row]
            if np.hypot(*error) <= SAME_PERSON:
                ray = place / np.hypot(*place)
                claimed = math.sqrt(np.trace(covariance))
                squared = float(error @ np.linalg.solve(covariance, error))
                pair = claimed < 1.01 * math.hypot(*PAIR_DEVIATIONS)
                errors.append(
                    LegError(pair, float(error @ ray), float(ray[0] * error[1] - ray[1] * error[0]), claimed, squared)
                )
    return errors, total


def row(name: str, errors: list[LegError], total: int) -> list[str]:
    """Return a row of the table."""
    if not errors:
        return [name, f"{total}", *["-"] * 7]
    along, across = np.array([e.along for e in errors]), np.array([e.across for e in errors])
    rmse = [float(np.sqrt(np.mean(values**2))) for values in (along, across, np.hypot(along, across))]
    claimed = float(np.sqrt(np.mean([e.claimed**2 for e in errors])))
    fit = 0.5 * float(np.mean([e.squared for e in errors]))
    numbers = [along.mean(), *rmse, claimed]
    return [name, f"{total}", f"{len(errors) / total:.2f}", *(f"{value:.3f}" for value in numbers), f"{fit:.2f}"]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--people", type=int, default=150, help="of each posture and range (default 150)")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    rows = []
    for posture in (Posture.STANDING, Posture.WALKING, Posture.SEATED):
        for least, most in itertools.pairwise(RANGES):
            errors, total = compare(posture, least, most, options.people, options.seed)
            name = f"{posture.value}, {least:g} to {most:g} m"
            rows.append(row(f"{name}, both legs", [e for e in errors if e.pair], total))
            rows.append(row(f"{name}, one leg", [e for e in errors if not e.pair], total))
    header = ["person", "sweeps", "found", "mean along [m]", "RMSE along", "across", "RMSE [m]", "claimed [m]", "fit"]
    print(provenance() + "\n")
    print(markdown_table(header, rows))


if __name__ == "__main__":
    main()
