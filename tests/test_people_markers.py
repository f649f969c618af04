"""People and detections as markers."""

import math
from typing import Any

import numpy as np
import pytest
from ticks import frame, scan, track

from han_bullet.messages import LegScan
from han_bullet.ros.message_types import serialize
from han_bullet.ros.people_markers import DELETE, DEVIATIONS, PeopleMarkers, detection_markers

WALKING: dict[str, Any] = {"velocity": (0.8, 0.6), "heading": 0.6435, "posture": "walking"}


def keys(message: Any, action: int = 0) -> set[tuple[str, int]]:
    return {(marker.ns, marker.id) for marker in message.markers if marker.action == action}


def named(message: Any, namespace: str, identity: int = 3) -> Any:
    (marker,) = [m for m in message.markers if (m.ns, m.id) == (namespace, identity)]
    return marker


def test_a_walker_has_a_body_an_arrow_a_label_and_an_ellipse() -> None:
    message = PeopleMarkers().message([track(3, 2.0, 1.0, **WALKING)], 5.0)
    assert keys(message) == {("body", 3), ("velocity", 3), ("label", 3), ("covariance", 3)}
    body, arrow = named(message, "body"), named(message, "velocity")
    assert (body.pose.position.x, body.pose.position.y) == (2.0, 1.0)
    start, end = arrow.points
    assert (end.x - start.x, end.y - start.y) == pytest.approx((0.8, 0.6))
    assert named(message, "label").text == "3 walking"
    assert all(marker.header.frame_id == "map" for marker in message.markers) and len(serialize(message))


def test_the_ellipse_lies_along_the_larger_uncertainty() -> None:
    turn = np.array([[math.cos(0.5), -math.sin(0.5)], [math.sin(0.5), math.cos(0.5)]])
    covariance = np.zeros((4, 4))
    covariance[:2, :2] = turn @ np.diag([0.09, 0.01]) @ turn.T
    ellipse = named(PeopleMarkers().message([track(3, covariance=covariance)], 0.0), "covariance")
    assert (ellipse.scale.x, ellipse.scale.y) == pytest.approx((2 * DEVIATIONS * 0.3, 2 * DEVIATIONS * 0.1))
    yaw = 2.0 * math.atan2(ellipse.pose.orientation.z, ellipse.pose.orientation.w)
    assert yaw == pytest.approx(0.5)


def test_who_has_left_is_deleted_once_and_others_keep_their_ids() -> None:
    markers = PeopleMarkers()
    markers.message([track(3), track(7)], 0.0)
    second = markers.message([track(7)], 0.1)
    assert keys(second, DELETE) == {("body", 3), ("label", 3), ("covariance", 3)}
    assert ("body", 7) in keys(second)
    assert not keys(markers.message([track(7)], 0.2), DELETE)


def test_who_stops_loses_the_arrow_only() -> None:
    markers = PeopleMarkers()
    markers.message([track(3, **WALKING)], 0.0)
    assert keys(markers.message([track(3)], 0.1), DELETE) == {("velocity", 3)}


def test_markers_vanish_by_themselves_should_the_bridge_die() -> None:
    for marker in PeopleMarkers().message([track(3, **WALKING)], 0.0).markers:
        assert (marker.lifetime.sec, marker.lifetime.nanosec) == (1, 0)


def test_who_faces_nobody_knows_where_and_is_certain_has_finite_markers() -> None:
    message = PeopleMarkers().message([track(3, heading=None, covariance=np.zeros((4, 4)))], 0.0)
    ellipse = named(message, "covariance")
    assert ellipse.scale.x > 0.0 and ellipse.scale.y > 0.0  # rviz complains of a scale of 0
    assert named(message, "body").pose.orientation.w == 1.0


def test_measurements_of_each_camera_and_the_laser_have_namespaces_of_their_own() -> None:
    seen = scan([(1.0, 2.0), (3.0, 4.0)], frame())
    legs = LegScan(0.0, np.array([[5.0, 6.0]]), np.array([0.01 * np.eye(2)]))
    message = detection_markers([seen], legs, 0.0)
    assert message is not None
    assert {("ceiling", 0), ("ceiling", 1), ("ceiling covariance", 1), ("laser", 0)} <= keys(message)
    assert named(message, "ceiling", 1).pose.position.y == 4.0
    assert all(marker.lifetime.nanosec == 300_000_000 for marker in message.markers) and len(serialize(message))


def test_without_measurements_nothing_is_sent() -> None:
    assert detection_markers([scan([], frame())], None, 0.0) is None
