"""What a seed changes in a world: a world file and a seed give one concrete world."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from han_bullet.world_schema import Light, Person, Robot, SeedVariation, Sit, Walk, World

OUTFITS = 8
BUILDS = ("slim", "broad")
LIGHT_TURN = 0.4  # [rad] either way about the vertical; enough to move the bright side of bodies
LIGHT_TINT = 0.08  # relative, either way, per colour; between a warm lamp and daylight


def vary(world: World, seed: int) -> World:
    """Return the world that a seed stands for: starts, speeds, delays, clothes, light and image noise are drawn.

    Every draw is made in a fixed order whether or not it is used, so that switching one variation off leaves the
    others as they were. What `seed_varies` sets to zero keeps the file's value.
    """
    rng = np.random.default_rng(seed)
    limits = world.seed_varies
    low, high = limits.image_noise
    noise = float(rng.uniform(low, high))
    return world.model_copy(
        update={
            "light": _vary_light(world.light, limits, rng),
            "image_noise": world.image_noise if low == high == 0.0 else noise,
            "robot": _vary_robot(world.robot, limits, rng),
            "people": tuple(_vary_person(person, limits, rng) for person in world.people),
        }
    )


def _vary_light(light: Light, limits: SeedVariation, rng: np.random.Generator) -> Light:
    turn = rng.uniform(-LIGHT_TURN, LIGHT_TURN)
    tint = rng.uniform(1.0 - LIGHT_TINT, 1.0 + LIGHT_TINT, size=3)
    if not limits.light:
        return light
    x, y, z = light.direction
    direction = (x * math.cos(turn) - y * math.sin(turn), x * math.sin(turn) + y * math.cos(turn), z)
    return light.model_copy(update={"direction": direction, "colour": tuple(tint * np.array(light.colour))})


def _vary_robot(robot: Robot, limits: SeedVariation, rng: np.random.Generator) -> Robot:
    return robot.model_copy(update={"start": _shifted(robot.start, limits.robot_start, limits.heading, rng)})


def _vary_person(person: Person, limits: SeedVariation, rng: np.random.Generator) -> Person:
    start = _shifted(person.start, limits.person_start, limits.heading, rng)
    faster = 1.0 + limits.speed * rng.uniform(-1.0, 1.0)
    later = limits.start_delay * rng.uniform()
    outfit, build = int(rng.integers(OUTFITS)), BUILDS[int(rng.integers(len(BUILDS)))]
    update: dict[str, Any] = {}
    if limits.outfits:
        update |= {"outfit": outfit, "build": build}
    if not isinstance(person.behaviour, Sit):
        update["start"] = start
    if isinstance(person.behaviour, Walk):
        trigger = person.behaviour.starts
        trigger = trigger.model_copy(update={"delay": trigger.delay + later})
        behaviour = {"speed": person.behaviour.speed * faster, "starts": trigger}
        update["behaviour"] = person.behaviour.model_copy(update=behaviour)
    return person.model_copy(update=update)


def _shifted(
    start: tuple[float, float, float], shift: float, turn: float, rng: np.random.Generator
) -> tuple[float, float, float]:
    """Move a start pose by up to `shift` [m] along each axis and turn it by up to `turn` [rad]."""
    dx, dy, dyaw = rng.uniform(-1.0, 1.0, size=3)
    return start[0] + shift * float(dx), start[1] + shift * float(dy), start[2] + turn * float(dyaw)
