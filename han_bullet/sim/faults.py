"""Faults of sensors, made to happen: what the world's `faults` do to pictures, scans, wheels and messages.

Nothing of this reaches the stack but what it does to an observation.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from han_bullet.sim.scene_state import Exposure, SceneState
from han_bullet.sim.trigger import RobotNow, StartSignal
from han_bullet.world_schema import (
    ALL_CAMERAS,
    WHEELS,
    Black,
    Camera,
    CeilingCamera,
    Dropped,
    Frozen,
    InjectedFault,
    Knocked,
    Late,
    Slippery,
    World,
)

LOSSES = 7  # sets the draws of what gets lost apart from the others made with the same seed


class Occurrence:
    """One fault of one target: whether it is happening now.

    Args:
        fault: What goes wrong.
        position_in_world: Of the target [m], for a fault that starts when the robot is near; None: on the robot.
    """

    def __init__(self, fault: InjectedFault, position_in_world: tuple[float, float] | None) -> None:
        self.fault = fault
        self._position = position_in_world
        self._signal = StartSignal(fault.starts)

    def happens(self, robot: RobotNow) -> bool:
        """Tell whether it is happening; call this every tick."""
        x, y = robot.pose_in_world.position.tolist()
        started = self._signal.given(robot, self._position or (x, y))
        return started and (self.fault.until is None or robot.time < self.fault.until - 1e-9)


class Faults:
    """Know what is wrong with each target at this tick.

    Args:
        world: With its faults and targets.
        seed: Decides what gets lost.
    """

    def __init__(self, world: World, seed: int) -> None:
        self._seed = seed
        places = {c.name: c.position[:2] if isinstance(c, CeilingCamera) else None for c in world.cameras}
        everywhere = {device.name: device.position for device in world.devices} | places
        self._occurrences: dict[str, list[Occurrence]] = {}
        for fault in world.faults:
            for target in places if fault.target == ALL_CAMERAS else [fault.target]:
                self._occurrences.setdefault(target, []).append(Occurrence(fault, everywhere.get(target)))
        self._now: dict[str, list[InjectedFault]] = {}

    def update(self, robot: RobotNow) -> None:
        """Find out what is wrong now."""
        self._now = {
            target: [occurrence.fault for occurrence in occurrences if occurrence.happens(robot)]
            for target, occurrences in self._occurrences.items()
        }

    def of(self, target: str) -> Sequence[InjectedFault]:
        """Return what is wrong with a target now."""
        return self._now.get(target, ())

    @property
    def slip(self) -> float:
        """Return how many times the usual the wheels slip."""
        return max((fault.times for fault in self.of(WHEELS) if isinstance(fault, Slippery)), default=1.0)

    def loses(self, target: str, tick: int) -> bool:
        """Tell whether what a target sends at this tick gets lost."""
        share = max((fault.share for fault in self.of(target) if isinstance(fault, Dropped)), default=0.0)
        numbers = [self._seed, LOSSES, tick, *target.encode()]
        return share > 0.0 and bool(np.random.default_rng(numbers).random() < share)


@dataclass(frozen=True)
class Shot:
    """A picture that reaches the robot at this tick.

    Attributes:
        camera: That takes it.
        exposure: Of what.
    """

    camera: Camera
    exposure: Exposure


class CameraFaults:
    """Decide which pictures reach the robot, and what they show.

    A late picture is taken when it arrives, of the moment that it shows: a lost one is then never rendered, and there
    is at most one picture of a camera per tick. When a camera is no longer late, what was on its way is lost.

    Args:
        cameras: Of the world.
        faults: What is wrong with them.
    """

    def __init__(self, cameras: Sequence[Camera], faults: Faults) -> None:
        self._cameras = tuple(cameras)
        self._faults = faults
        self._last: dict[str, Exposure] = {}
        self._on_their_way: dict[str, deque[Shot]] = {camera.name: deque() for camera in cameras}

    def take(self, state: SceneState) -> list[Shot]:
        """Return the pictures that arrive now, in the order of the cameras; the state is the scene now."""
        shots = []
        for camera in self._cameras:
            waiting = self._on_their_way[camera.name]
            delay = max((fault.delay for fault in self._faults.of(camera.name) if isinstance(fault, Late)), default=0.0)
            if delay == 0.0:
                waiting.clear()
            if state.frame_number % camera.ticks_per_frame == 0 and not self._faults.loses(
                camera.name, state.frame_number
            ):
                waiting.append(Shot(camera, self._expose(camera.name, state)))
            if waiting and waiting[0].exposure.time <= state.time - delay + 1e-9:
                shots.append(waiting.popleft())
        return shots

    def _expose(self, camera: str, state: SceneState) -> Exposure:
        faults = self._faults.of(camera)
        turned = float(np.radians(sum(fault.degrees for fault in faults if isinstance(fault, Knocked))))
        black = any(isinstance(fault, Black) for fault in faults)
        exposure = Exposure(camera, state.time, state, black, turned)
        if any(isinstance(fault, Frozen) for fault in faults) and camera in self._last:
            exposure = replace(self._last[camera], time=state.time)
        self._last[camera] = exposure
        return exposure
