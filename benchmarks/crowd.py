"""Simulated people in a square room, and what a detector that misses and invents some would measure of them."""

from dataclasses import dataclass

import numpy as np

from han_bullet.geometry import Array

SCAN_PERIOD = 0.1  # [s]
SPEEDS = (0.4, 1.2)  # [m/s], drawn for each leg of a walk
ACCELERATION = 0.8  # Most [m/s^2]: from a walk to a stop, or half about, in a second or two.
BRAKING_DISTANCE, ARRIVAL = 0.6, 0.2  # [m] before a target
PAUSE_PROBABILITY, PAUSES = 0.4, (1.0, 4.0)  # at a target; [s]
NEAREST = 0.5  # [m] between two people's centres: they pass shoulder to shoulder
MARGIN = 0.3  # [m] from the walls
POSITION_DEVIATION = 0.1  # [m] of a measurement, each axis
DETECTION_PROBABILITY = 0.9
CLUTTER_DENSITY = 0.005  # false measurements per scan and square metre


@dataclass(frozen=True)
class Recording:
    """Some seconds of a room.

    Attributes:
        positions: Of the people, shape (scans, people, 2) [m].
        measurements: Of each scan, shape (n, 2) [m], in random order.
    """

    positions: Array
    measurements: tuple[Array, ...]


def record(people: int, side: float, seconds: float, seed: int) -> Recording:
    """Let people walk about in a square room with sides [m] from 0 on, and measure them at every scan."""
    generator = np.random.default_rng([seed, people, round(100.0 * side)])
    positions = walk(people, side, round(seconds / SCAN_PERIOD), generator)
    return Recording(positions, tuple(measure(at, side, generator) for at in positions))


def walk(people: int, side: float, scans: int, generator: np.random.Generator) -> Array:
    """Return the positions, shape (scans, people, 2) [m], of people who walk, turn, stop and cross each other."""
    places = _keep_apart(generator.uniform(MARGIN, side - MARGIN, (people, 2)), side)
    velocities, targets = np.zeros((people, 2)), generator.uniform(MARGIN, side - MARGIN, (people, 2))
    speeds, pauses = generator.uniform(*SPEEDS, people), np.zeros(people)
    walked = []
    for _ in range(scans):
        walked.append(places)
        ahead = targets - places
        distances = np.hypot(*ahead.T)
        for k in np.flatnonzero((distances < ARRIVAL) & (pauses <= 0.0)):
            targets[k], speeds[k] = generator.uniform(MARGIN, side - MARGIN, 2), generator.uniform(*SPEEDS)
            pauses[k] = generator.uniform(*PAUSES) if generator.random() < PAUSE_PROBABILITY else 0.0
        wanted = speeds * np.minimum(1.0, distances / BRAKING_DISTANCE) / np.maximum(distances, 1e-9)
        change = np.where(pauses > 0.0, 0.0, wanted)[:, None] * ahead - velocities
        most = ACCELERATION * SCAN_PERIOD / np.maximum(np.hypot(*change.T), 1e-9)
        velocities = velocities + np.minimum(1.0, most)[:, None] * change
        pauses = pauses - SCAN_PERIOD
        places = _keep_apart(places + SCAN_PERIOD * velocities, side)
    return np.array(walked)


def measure(positions: Array, side: float, generator: np.random.Generator) -> Array:
    """Return noisy measurements, shape (n, 2) [m], of some of the positions, shape (people, 2), and clutter."""
    found = positions[generator.random(len(positions)) < DETECTION_PROBABILITY]
    noisy = found + generator.normal(0.0, POSITION_DEVIATION, found.shape)
    clutter = generator.uniform(0.0, side, (generator.poisson(CLUTTER_DENSITY * side**2), 2))
    return generator.permutation(np.concatenate([noisy, clutter]))


def _keep_apart(places: Array, side: float) -> Array:
    """Push people out of each other and off the walls; where a room is full, as far as a few rounds go."""
    places = places.copy()
    for _ in range(10):
        difference = places[:, None] - places[None, :]
        distance = np.hypot(*np.moveaxis(difference, -1, 0)) + 10.0 * NEAREST * np.eye(len(places))
        push = 0.5 * np.maximum(NEAREST - distance, 0.0) / np.maximum(distance, 1e-9)
        places = np.clip(places + (push[..., None] * difference).sum(axis=1), MARGIN, side - MARGIN)
        if distance.min() >= NEAREST:
            break
    return places
