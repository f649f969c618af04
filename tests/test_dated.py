"""Stamps that are set to another clock, through and through."""

import numpy as np

from han_bullet.geometry import Pose2D
from han_bullet.messages import Path
from han_bullet.ros.dated import dated
from han_bullet.ros.message_types import header, make, seconds, serialize
from han_bullet.ros.navigation_messages import plan_message
from han_bullet.ros.occupancy import grid_message
from han_bullet.ros.placing import floor_transform


def test_every_header_within_a_message_is_later_by_the_epoch_and_nothing_else_changes() -> None:
    plan = plan_message(Path(np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.5]]), 2.0), 1.5)
    later = dated(plan, 1e9)
    assert seconds(later.header.stamp) == 1e9 + 1.5
    assert len(later.poses) == len(plan.poses) == 2
    assert {seconds(pose.header.stamp) for pose in later.poses} == {1e9 + 1.5}
    assert seconds(plan.header.stamp) == 1.5
    assert serialize(dated(later, -1e9)) == serialize(plan)


def test_transforms_and_numbers_are_dated_too_and_a_message_without_header_stays() -> None:
    tree = make("tf2_msgs/TFMessage", transforms=[floor_transform(header(2.0, "map"), "odom", Pose2D(1.0, 2.0, 0.5))])
    assert seconds(dated(tree, 100.0).transforms[0].header.stamp) == 102.0
    grid = grid_message(np.zeros((2, 3), np.int8), np.zeros(2), 0.05, 3.0)
    later = dated(grid, 100.0)
    assert (seconds(later.header.stamp), seconds(later.info.map_load_time)) == (103.0, 103.0)
    assert later.data is grid.data
    marker = make("visualization_msgs/Marker", lifetime=make("builtin_interfaces/Duration", sec=1))
    assert dated(marker, 100.0).lifetime.sec == 1
    twist = make("geometry_msgs/Twist")
    assert serialize(dated(twist, 100.0)) == serialize(twist)
