"""People and detections as markers for rviz."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Sequence
from typing import Any

from han_bullet.geometry import Array
from han_bullet.messages import LegScan, Posture, Scan, TrackedPerson
from han_bullet.ros.frames import MAP
from han_bullet.ros.message_types import header, make
from han_bullet.ros.placing import point, vector, yaw_message

ARROW, SPHERE, CYLINDER, TEXT = 0, 2, 3, 9  # kinds of visualization_msgs/Marker
ADD, DELETE = 0, 2
PERSON_LIFETIME = 1.0  # [s]: people of a bridge that has died vanish by themselves
DETECTION_LIFETIME = 0.3  # [s]: three frames
DEVIATIONS = 2.4477  # of the ellipse in which a place lies with a probability of 95 %
BODY_DIAMETER, STANDING_HEIGHT, SEATED_HEIGHT = 0.45, 1.7, 1.3  # [m]
ARROW_FROM = 0.05  # [m/s]; who is slower stands
COLOURS = {Posture.STANDING: (0.25, 0.5, 0.9), Posture.WALKING: (0.95, 0.5, 0.1), Posture.SEATED: (0.3, 0.7, 0.3)}
ELLIPSE_COLOUR, TEXT_COLOUR, DETECTION_COLOUR = (0.6, 0.3, 0.8, 0.5), (0.1, 0.1, 0.1, 1.0), (0.9, 0.1, 0.4, 0.9)
Key = tuple[str, int]


class PeopleMarkers:
    """Markers of tracked people, with the track's id in namespaces body, velocity, label and covariance.

    A marker whose person has left, or who has stopped and lost the arrow, is deleted by the next message.
    """

    def __init__(self) -> None:
        self._shown: frozenset[Key] = frozenset()

    def message(self, people: Sequence[TrackedPerson], time: float) -> Any:
        """Return a visualization_msgs/MarkerArray of those who are there at a time [s]."""
        stamp = header(time, MAP)
        markers = [marker for person in people for marker in _person(person, stamp)]
        now = frozenset((marker.ns, marker.id) for marker in markers)
        gone = [_deleted(key, stamp) for key in sorted(self._shown - now)]
        self._shown = now
        return make("visualization_msgs/MarkerArray", markers=[*gone, *markers])


def detection_markers(scans: Sequence[Scan], legs: LegScan | None, time: float) -> Any | None:
    """Return a visualization_msgs/MarkerArray of measurements on the floor, a namespace per camera; None without any.

    They vanish by themselves after `DETECTION_LIFETIME`.
    """
    found: list[Scan | LegScan] = [*scans, *([] if legs is None else [legs])]
    markers = [marker for scan in found for marker in _measurements(scan, header(time, MAP))]
    return make("visualization_msgs/MarkerArray", markers=markers) if markers else None


def _person(person: TrackedPerson, stamp: Any) -> Iterator[Any]:
    (x, y), (vx, vy) = person.position_in_world.tolist(), person.velocity_in_world.tolist()
    height = SEATED_HEIGHT if person.posture is Posture.SEATED else STANDING_HEIGHT
    colour, identity = (*COLOURS[person.posture], 0.8), person.id
    body = (BODY_DIAMETER, BODY_DIAMETER, height)
    yield _marker("body", identity, stamp, CYLINDER, _pose(x, y, 0.5 * height, person.heading or 0.0), body, colour)
    if person.speed >= ARROW_FROM:
        points = [point(x, y, 0.5 * height), point(x + vx, y + vy, 0.5 * height)]  # where they are in a second
        arrow = (0.06, 0.14, 0.2)  # of shaft and head: diameters, and length of the head [m]
        yield _marker("velocity", identity, stamp, ARROW, _pose(), arrow, colour, points=points)
    words = f"{identity} {person.posture.value}"
    above = _pose(x, y, height + 0.2)
    yield _marker("label", identity, stamp, TEXT, above, (0.0, 0.0, 0.25), TEXT_COLOUR, text=words)
    yield _ellipse("covariance", identity, stamp, (x, y), person.covariance, PERSON_LIFETIME)


def _measurements(scan: Scan | LegScan, stamp: Any) -> Iterator[Any]:
    for row, (place, covariance) in enumerate(zip(scan.positions.tolist(), scan.covariances, strict=True)):
        x, y = place
        ball, seconds = (0.12, 0.12, 0.12), DETECTION_LIFETIME
        yield _marker(scan.camera, row, stamp, SPHERE, _pose(x, y, 0.06), ball, DETECTION_COLOUR, seconds)
        yield _ellipse(f"{scan.camera} covariance", row, stamp, (x, y), covariance, seconds)


def _ellipse(
    namespace: str, identity: int, stamp: Any, place: tuple[float, float], covariance: Array, seconds: float
) -> Any:
    """Return a flat marker in which the place, two numbers [m], truly lies with a probability of 95 %."""
    along, across, direction = _axes(covariance)
    size = (2.0 * DEVIATIONS * along, 2.0 * DEVIATIONS * across, 0.01)
    return _marker(namespace, identity, stamp, CYLINDER, _pose(*place, 0.01, direction), size, ELLIPSE_COLOUR, seconds)


def _axes(covariance: Array) -> tuple[float, float, float]:
    """Return the standard deviations along and across the longer axis of a place's covariance [m], and its yaw."""
    xx, xy, yy = float(covariance[0, 0]), float(covariance[0, 1]), float(covariance[1, 1])
    mean, half = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy)
    direction = 0.5 * math.atan2(2.0 * xy, xx - yy)
    return math.sqrt(max(mean + half, 1e-8)), math.sqrt(max(mean - half, 1e-8)), direction


def _deleted(key: Key, stamp: Any) -> Any:
    namespace, identity = key
    return make("visualization_msgs/Marker", header=stamp, ns=namespace, id=identity, action=DELETE, pose=_pose())


def _marker(
    namespace: str,
    identity: int,
    stamp: Any,
    kind: int,
    pose: Any,
    size: tuple[float, float, float],
    colour: tuple[float, ...],
    seconds: float = PERSON_LIFETIME,
    *,
    text: str = "",
    points: Sequence[Any] = (),
) -> Any:
    return make(
        "visualization_msgs/Marker",
        header=stamp,
        ns=namespace,
        id=identity,
        type=kind,
        action=ADD,
        pose=pose,
        scale=vector(*size),
        color=_colour(*colour),
        lifetime=_duration(seconds),
        points=list(points),
        text=text,
    )


def _pose(x: float = 0.0, y: float = 0.0, z: float = 0.0, yaw: float = 0.0) -> Any:
    return make("geometry_msgs/Pose", position=point(x, y, z), orientation=yaw_message(yaw))


@functools.cache
def _colour(red: float, green: float, blue: float, opacity: float) -> Any:
    return make("std_msgs/ColorRGBA", r=red, g=green, b=blue, a=opacity)


@functools.cache
def _duration(seconds: float) -> Any:
    whole = math.floor(seconds)
    return make("builtin_interfaces/Duration", sec=whole, nanosec=round((seconds - whole) * 1e9))
