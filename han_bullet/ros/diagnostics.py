"""How the robot is, as diagnostic_msgs/DiagnosticArray: one status per sensor and per stage."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Mapping
from typing import Any

from han_bullet.messages import Fault, Observation, Status
from han_bullet.ros.message_types import header, make
from han_bullet.ros.stage_times import StageTimes
from han_bullet.stack import Decision
from han_bullet.world_schema import LASER, WHEELS, World

OK, WARN, ERROR = 0, 1, 2  # levels
LESS = ("dropped", "late", "slip")  # faults of a sensor that still helps
LOOK_BACK = 2.0  # [s] over which rates are counted
BAD = (Status.LOST, Status.BLIND, Status.BLOCKED)
WAITS = (Status.WAITING, Status.YIELDING, Status.PROTECTIVE_STOP)


class Diagnostics:
    """Watch how often what arrives, and say how everything is.

    Args:
        world: With the cameras in use.
        times: Of the stages.
    """

    def __init__(self, world: World, times: StageTimes) -> None:
        self._sensors = [camera.name for camera in world.cameras]
        self._sensors += [LASER] if world.robot.laser is not None else []
        self._sensors.append(WHEELS)
        self._devices = [device.name for device in world.devices]
        self._arrivals: dict[str, deque[tuple[float, float]]] = {name: deque() for name in self._sensors}
        self._times = times

    def note(self, observation: Observation) -> None:
        """Take note of what has arrived with an observation."""
        now = observation.time
        for image in observation.images:
            self._arrive(image.camera, image.time, now)
        if observation.laser is not None:
            self._arrive(LASER, observation.laser.time, now)
        self._arrive(WHEELS, observation.odometry.time, now)

    def message(self, decision: Decision) -> Any:
        """Return a diagnostic_msgs/DiagnosticArray of a moment."""
        statuses = [*self._of_sensors(decision), *_of_stages(decision), self._of_loop()]
        return make("diagnostic_msgs/DiagnosticArray", header=header(decision.time, ""), status=statuses)

    def _arrive(self, sensor: str, taken: float, now: float) -> None:
        arrivals = self._arrivals.setdefault(sensor, deque())
        arrivals.append((now, now - taken))
        while arrivals[0][0] < now - LOOK_BACK + 1e-6:
            arrivals.popleft()

    def _of_sensors(self, decision: Decision) -> Iterator[Any]:
        faults: dict[str, list[Fault]] = {}
        for fault in decision.faults:
            faults.setdefault(fault.sensor, []).append(fault)
        for name in dict.fromkeys([*self._sensors, *self._devices, *faults]):
            yield _of_sensor(name, faults.get(name, ()), self._values(name, decision.time))

    def _values(self, sensor: str, now: float) -> dict[str, str]:
        if sensor not in self._arrivals:  # a device speaks when it has something to say
            return {}
        recent = [age for time, age in self._arrivals[sensor] if time >= now - LOOK_BACK + 1e-6]
        values = {"rate [Hz]": f"{len(recent) / LOOK_BACK:.1f}"}
        return values | ({"latency [ms]": f"{1e3 * recent[-1]:.0f}"} if recent else {})

    def _of_loop(self) -> Any:
        """Return how fast the program is; without a watched stack nothing is known of that."""
        values = {f"{stage} latency [ms]": f"{1e3 * taken:.3f}" for stage, taken in self._times.mean.items()}
        if self._times.rate is not None:
            values = {"rate [Hz]": f"{self._times.rate:.1f}"} | values
        return _status("loop", OK, "runs" if values else "not timed", values)


def _of_sensor(name: str, faults: Any, values: Mapping[str, str]) -> Any:
    level = max((WARN if fault.kind in LESS else ERROR for fault in faults), default=OK)
    words = ", ".join(f"{fault.kind} since {fault.since:.2f} s" for fault in faults)
    return _status(f"sensor {name}", level, words or "works", values)


def _of_stages(decision: Decision) -> Iterator[Any]:
    estimate, path = decision.estimate, decision.path
    x, y, yaw = (math.sqrt(max(float(variance), 0.0)) for variance in estimate.covariance.diagonal())
    deviations = {"deviation x [m]": f"{x:.3f}", "deviation y [m]": f"{y:.3f}", "deviation yaw [rad]": f"{yaw:.4f}"}
    lost = "lost: what is sensed does not fit to the map"
    yield _status("localization", *((ERROR, lost) if estimate.lost else (OK, "knows where it is")), deviations)
    seen = {"people": str(len(decision.people)), "measurements": str(sum(len(s.positions) for s in decision.scans))}
    yield _status("tracker", OK, "follows people" if decision.people else "nobody is there", seen)
    if decision.scene.task is None or decision.ends_task:
        yield _status("planner", OK, "has nothing to plan", {})
    elif path is None:
        yield _status("planner", WARN, "there is no free way", {})
    else:
        yield _status("planner", OK, "has a way", {"cost [m]": f"{path.cost:.2f}", "expanded": str(path.expanded)})
    yield _of_control(decision)


def _of_control(decision: Decision) -> Any:
    values = {"speed [m/s]": f"{decision.command.speed:.3f}"}
    if decision.step is not None:
        values["recovery"] = decision.step.value
    if decision.gave_up is not None:
        return _status("control", ERROR, f"gave up: {decision.gave_up}", values)
    level = ERROR if decision.status in BAD else WARN if decision.status in WAITS else OK
    return _status("control", level, decision.status.value, values)


def _status(name: str, level: int, message: str, values: Mapping[str, str]) -> Any:
    pairs = [make("diagnostic_msgs/KeyValue", key=key, value=value) for key, value in values.items()]
    return make(
        "diagnostic_msgs/DiagnosticStatus",
        level=level,
        name=f"han_bullet: {name}",
        message=message,
        hardware_id="han_bullet",
        values=pairs,
    )
