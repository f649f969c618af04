"""How well and how fast the robot localizes itself on the ways that it drove.

The worlds are run with true perception; odometry and scans, with the people's legs in them, are the simulator's.

Usage: python -m benchmarks.localization [--worlds sim1,sim2,real1,real2,real3,real4,two_abreast] [--seeds 10]
"""

import argparse
import math
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.provenance import provenance
from han_bullet.episode import Hook, Tick
from han_bullet.geometry import Array, Pose2D, wrap_angle
from han_bullet.localization.lidar import LidarLocalization
from han_bullet.localization.occupancy_grid import OccupancyGrid
from han_bullet.markdown import markdown_table
from han_bullet.messages import LaserScan, Odometry
from han_bullet.runner import RunOptions, run_world
from han_bullet.variation import vary
from han_bullet.wall_faces import with_doors
from han_bullet.world_file import load_world
from han_bullet.world_schema import CONTROL_PERIOD

WORLDS = "sim1,sim2,real1,real2,real3,real4,two_abreast"
START_DEVIATIONS = np.array([0.05, 0.05, math.radians(2.0)])  # somebody put the robot there [m], [rad]
SETTLING = 0.5  # from the start, which is no merit and no fault of the method [s]


class Recording(Hook):
    """What the robot sensed on its way, and where it truly was."""

    def __init__(self) -> None:
        self.odometry: list[Odometry] = []
        self.scans: list[LaserScan | None] = []
        self.poses: list[Pose2D] = []

    def record(self, tick: Tick) -> None:
        """Keep one tick."""
        self.odometry.append(tick.observation.odometry)
        self.scans.append(tick.observation.laser)
        self.poses.append(tick.truth.pose_robot_in_world)


@dataclass(frozen=True)
class Replay:
    """What a localization made of a recording.

    Attributes:
        errors: Of x, y and yaw by tick, shape (n, 3) [m], [m], [rad].
        normalized: Squared errors, by the covariances; 3 on average if these are honest, shape (n,).
        lost: Ticks that said so.
        seconds: CPU time of all updates [s].
    """

    errors: Array
    normalized: Array
    lost: int
    seconds: float


def recorded(world: str, seed: int) -> Recording:
    """Drive through a world."""
    recording = Recording()
    with tempfile.TemporaryDirectory() as folder:
        run_world(world, RunOptions(seed=seed, perception="truth", video=False), Path(folder), [recording])
    return recording


def replayed(world: str, seed: int, recording: Recording) -> Replay:
    """Localize along a recorded way, from a start that is known roughly."""
    concrete = vary(load_world(world), seed)
    assert concrete.robot.laser is not None
    grid = OccupancyGrid.of_building(
        [(area.x, area.y) for area in concrete.floor],
        with_doors(concrete.solid_boxes(), concrete.floor),
        scan_height=concrete.robot.laser.height,
    )
    true_start = recording.poses[0]
    x, y, yaw = np.random.default_rng([seed, 1]).normal(0.0, START_DEVIATIONS).tolist()
    start = Pose2D(true_start.x + x, true_start.y + y, true_start.yaw + yaw)
    robot = LidarLocalization(grid, start, np.diag(START_DEVIATIONS**2), np.random.default_rng([seed, 2]))
    errors, normalized, lost, seconds = [], [], 0, 0.0
    for odometry, scan, true in zip(recording.odometry, recording.scans, recording.poses, strict=True):
        begun = time.process_time()
        estimate = robot.update(odometry, scan)
        seconds += time.process_time() - begun
        pose = estimate.pose_robot_in_world
        error = np.array([pose.x - true.x, pose.y - true.y, wrap_angle(pose.yaw - true.yaw)])
        errors.append(error)
        normalized.append(float(error @ np.linalg.solve(estimate.covariance, error)))
        lost += estimate.lost
    return Replay(np.array(errors), np.array(normalized), lost, seconds)


def row(world: str, replays: Sequence[Replay]) -> tuple[object, ...]:
    """Return a world's line of the table."""
    settled = round(SETTLING / CONTROL_PERIOD)
    errors = np.concatenate([replay.errors[settled:] for replay in replays])
    normalized = np.concatenate([replay.normalized[settled:] for replay in replays])
    position, yaw = np.hypot(errors[:, 0], errors[:, 1]), np.degrees(np.abs(errors[:, 2]))
    ticks, seconds = sum(len(replay.errors) for replay in replays), sum(replay.seconds for replay in replays)
    return (
        world,
        100.0 * math.sqrt((position**2).mean()),
        100.0 * float(position.max()),
        math.sqrt((yaw**2).mean()),
        float(yaw.max()),
        float(normalized.mean()),
        sum(replay.lost for replay in replays),
        1e3 * seconds / ticks,
        ticks * CONTROL_PERIOD / seconds,
    )


COLUMNS = (
    "world",
    "position RMSE [cm]",
    "worst [cm]",
    "yaw RMSE [deg]",
    "worst [deg]",
    "normalized error (3: honest)",
    "ticks lost",
    "ms per tick",
    "times real time",
)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--worlds", default=WORLDS, help="names with commas between")
    parser.add_argument("--seeds", type=int, default=10, help="0 to N - 1")
    options = parser.parse_args()
    print(f"### Localization by odometry and laser: {options.seeds} seeds\n\n{provenance()}\n")
    replayed(first := options.worlds.split(",")[0], 0, recorded(first, 0))  # compiled code loaded
    rows = []
    for world in options.worlds.split(","):
        recordings = ((seed, recorded(world, seed)) for seed in range(options.seeds))
        rows.append(row(world, [replayed(world, seed, recording) for seed, recording in recordings]))
    print(markdown_table(COLUMNS, rows))


if __name__ == "__main__":
    main()
