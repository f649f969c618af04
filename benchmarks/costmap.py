"""How long an update of the whole costmap takes, layer by layer, by the number of people.

Usage: python -m benchmarks.costmap [--people 1 2 5 10 20 50] [--updates 200] [--seed 0]

The room is 20 x 20 m in cells of 5 cm, 400 x 400 of them, with walls, tables and a television that is on. Of three
people one walks, one stands and one sits before the television; before each update those on their feet are put
somewhere else. An update is what the stack does: a copy of the free floor, then every layer.
"""

import argparse
import math
import time
from collections.abc import Sequence

import numpy as np

from benchmarks.provenance import provenance
from han_bullet.commands.parsing import natural, positive
from han_bullet.costmap.grid import Costmap
from han_bullet.costmap.layer import Layer
from han_bullet.costmap.layers import standard_layers
from han_bullet.geometry import Array, Pose2D, SolidBox
from han_bullet.markdown import markdown_table
from han_bullet.messages import Device, GoTo, LaserScan, Posture, Scene, Seat, TrackedPerson

SIDE, RESOLUTION = 20.0, 0.05  # [m]
ROBOT_RADIUS = 0.3  # [m]
TELEVISION = Device("tv", np.array([19.7, 10.0]), on=True)
# Of the seats: the first row's distance from the television, between rows, between neighbours [m]; seats in a row.
FIRST_ROW, ROW_PITCH, SEAT_PITCH, ROW_LENGTH = 2.5, 1.2, 0.8, 6
POSTURES = (Posture.WALKING, Posture.STANDING, Posture.SEATED)
WARMING = 20  # updates: compiled code is loaded, the building drawn
COPY, TOTAL = "copy of the free floor", "whole update"


def building() -> list[SolidBox]:
    """Return four walls, eight tables and the television."""
    half = 0.5 * SIDE
    walls = [((half, 0.05), (SIDE, 0.1)), ((half, SIDE - 0.05), (SIDE, 0.1))]
    walls += [((0.05, half), (0.1, SIDE)), ((SIDE - 0.05, half), (0.1, SIDE))]
    tables = [((x, y), (1.6, 0.8)) for x in (3.0, 7.0, 11.0, 15.0) for y in (4.0, 16.0)]
    solids = [*walls, *tables, ((19.8, 10.0), (0.1, 1.2))]
    return [SolidBox("box", "object", np.array([*at, 0.4]), np.array([*size, 0.8]), 0.0) for at, size in solids]


def seats(number: int) -> list[Seat]:
    """Return seats in rows before the television, all facing it."""
    found = []
    for k in range(number):
        row, place = divmod(k, ROW_LENGTH)
        x = TELEVISION.position_in_world[0] - FIRST_ROW - ROW_PITCH * row
        y = TELEVISION.position_in_world[1] + SEAT_PITCH * (place - 0.5 * (ROW_LENGTH - 1))
        found.append(Seat(f"seat {k}", np.array([x, y]), 0.0, 0.8, 0.6, watches=TELEVISION.name))
    return found


def scene(people: int, generator: np.random.Generator, number: int = 0) -> Scene:
    """Return a scene in which every third person walks, stands or sits; the seated have the first seats.

    The robot is on its way past the first who walks, and comes towards them; its laser sees something off the
    map 2 m about it, anew with each number.
    """
    places = seats(people // len(POSTURES))
    everybody = tuple(_person(k, places, generator) for k in range(people))
    robot, task = Pose2D(0.5 * SIDE, 0.5 * SIDE, 0.0), None
    if everybody:
        there, ahead = everybody[0].position_in_world, everybody[0].velocity_in_world / max(everybody[0].speed, 1e-6)
        (robot_x, robot_y), (x, y) = (there + 3.0 * ahead).tolist(), (there - 3.0 * ahead).tolist()
        robot = Pose2D(robot_x, robot_y, 0.0)
        task = GoTo(Pose2D(x, y, 0.0))
    return Scene(0.0, everybody, (TELEVISION,), tuple(places), task, robot, _sweep(0.1 * number))


def _person(number: int, places: Sequence[Seat], generator: np.random.Generator) -> TrackedPerson:
    posture = POSTURES[number % len(POSTURES)]
    position, heading, speed = generator.uniform(1.0, SIDE - 1.0, 2), generator.uniform(-math.pi, math.pi), 0.0
    seat = None
    if posture is Posture.SEATED:
        seat = places[number // len(POSTURES)]
        position, heading = seat.position_in_world, seat.facing
    elif posture is Posture.WALKING:
        speed = generator.uniform(0.3, 1.4)
    velocity: Array = speed * np.array([math.cos(heading), math.sin(heading)])
    covariance = 0.05**2 * np.eye(4)
    return TrackedPerson(
        number, 0.0, position, velocity, covariance, posture, heading, None if seat is None else seat.name
    )


def _sweep(time: float) -> LaserScan:
    return LaserScan(time, np.full(541, 2.0), -0.75 * math.pi, math.radians(0.5), 0.05, 8.0, Pose2D(0.2, 0.0, 0.0))


def update_times(free_space: Costmap, layers: Sequence[Layer], scenes: Sequence[Scene]) -> dict[str, list[float]]:
    """Return the time of each part of each update [s], and of the whole."""
    times: dict[str, list[float]] = {name: [] for name in (TOTAL, COPY, *(layer.name for layer in layers))}
    for one in scenes:
        marks = [time.perf_counter()]
        costmap = free_space.copy()
        marks.append(time.perf_counter())
        for layer in layers:
            layer.apply(costmap, one)
            marks.append(time.perf_counter())
        times[TOTAL].append(marks[-1] - marks[0])
        for name, taken in zip((COPY, *(layer.name for layer in layers)), np.diff(marks), strict=True):
            times[name].append(float(taken))
    return times


def measure(counts: Sequence[int], updates: int, seed: int) -> dict[int, dict[str, list[float]]]:
    """Return the times of updates by number of people."""
    free_space = Costmap.covering([((0.0, SIDE), (0.0, SIDE))], RESOLUTION)
    layers = standard_layers(building(), robot_radius=ROBOT_RADIUS)
    measured = {}
    for people in counts:
        generator = np.random.default_rng([seed, people])
        update_times(free_space, layers, [scene(people, generator, k) for k in range(WARMING)])
        measured[people] = update_times(
            free_space, layers, [scene(people, generator, WARMING + k) for k in range(updates)]
        )
    return measured


def rows(measured: dict[int, dict[str, list[float]]]) -> list[list[str]]:
    """Return a line for each part: median and 95th percentile [ms] by number of people."""
    parts = next(iter(measured.values()))
    return [[part, *(_cell(times[part]) for times in measured.values())] for part in parts]


def _cell(times: Sequence[float]) -> str:
    median, late = 1e3 * np.percentile(times, (50, 95))
    return f"{median:.3f} ({late:.3f})"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--people", type=positive, nargs="+", default=[1, 2, 5, 10, 20, 50], help="how many")
    parser.add_argument("--updates", type=positive, default=200)
    parser.add_argument("--seed", type=natural, default=0)
    options = parser.parse_args()
    measured = measure(options.people, options.updates, options.seed)
    print("### Update of the costmap: 400 x 400 cells of 5 cm\n")
    print(f"{provenance()}; {options.updates} updates, seed {options.seed}; median (95 %) [ms]\n")
    print(markdown_table(("part", *(f"{n} {'person' if n == 1 else 'people'}" for n in measured)), rows(measured)))


if __name__ == "__main__":
    main()
