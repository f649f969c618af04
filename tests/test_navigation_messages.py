"""Goal, plan and trajectory as ROS messages."""

import dataclasses
import math

import numpy as np
import pytest
from ticks import tick

from han_bullet.geometry import Pose2D
from han_bullet.messages import GoTo, HandOver, Path, PoseEstimate, Scene
from han_bullet.ros.message_types import serialize
from han_bullet.ros.navigation_messages import LONGEST_TRAJECTORY, Trajectory, goal_message, plan_message


def yaw(pose: object) -> float:
    orientation = pose.orientation  # type: ignore[attr-defined]
    return 2.0 * math.atan2(orientation.z, orientation.w)


@pytest.mark.parametrize("cells", [1, 2, 3, 4, 5, 6, 7, 50])
def test_a_plan_begins_at_the_robot_ends_where_it_ends_and_looks_along_itself(cells: int) -> None:
    points = np.column_stack([np.full(cells, 2.0), 0.05 * np.arange(cells)])
    message = plan_message(Path(points, 1.0), 4.0)
    places = [(p.pose.position.x, p.pose.position.y) for p in message.poses]
    assert places[0] == (2.0, 0.0) and places[-1] == (2.0, points[-1, 1]) and len(set(places)) == len(places)
    assert [yaw(p.pose) for p in message.poses] == pytest.approx([math.pi / 2 if cells > 1 else 0.0] * len(places))
    assert message.header.frame_id == "map" and len(serialize(message))


def test_where_there_is_no_way_the_plan_is_empty() -> None:
    assert plan_message(None, 0.0).poses == []


def test_the_goal_is_the_tasks_pose() -> None:
    scene = Scene(1.0, task=GoTo(Pose2D(3.0, 4.0, 1.0)), pose_robot_in_world=Pose2D(0.0, 0.0, 0.0))
    message = goal_message(scene)
    assert (message.pose.position.x, message.pose.position.y, yaw(message.pose)) == pytest.approx((3.0, 4.0, 1.0))


def test_the_goal_of_a_hand_over_is_before_the_person_and_faces_them() -> None:
    task = HandOver(np.array([5.0, 0.0]), 1.0, person=1, heading=math.pi, position_in_world=np.array([5.0, 0.0]))
    message = goal_message(Scene(1.0, task=task, pose_robot_in_world=Pose2D(0.0, 0.0, 0.0)))
    assert (message.pose.position.x, message.pose.position.y) == pytest.approx((4.0, 0.0))
    assert math.cos(yaw(message.pose)) == pytest.approx(1.0)


def test_without_a_task_there_is_no_goal() -> None:
    assert goal_message(tick().decision.scene) is None


def at(x: float, turned: float = 0.0) -> PoseEstimate:
    return PoseEstimate(x, Pose2D(x, 0.0, turned))


def test_a_trajectory_grows_with_the_way_and_with_turns_but_not_while_the_robot_stands() -> None:
    trajectory = Trajectory()
    for estimate in (at(0.0), at(0.05), at(0.05), at(0.11), at(0.11, 0.3), at(0.11, 0.3)):
        trajectory.add(estimate)
    message = trajectory.message(9.0)
    assert [p.pose.position.x for p in message.poses] == [0.0, 0.11, 0.11]
    assert message.header.frame_id == "map" and len(serialize(message))


def test_a_trajectory_forgets_its_beginning() -> None:
    trajectory = Trajectory()
    for k in range(LONGEST_TRAJECTORY + 5):
        trajectory.add(dataclasses.replace(at(0.2 * k), time=0.05 * k))
    poses = trajectory.message(0.0).poses
    assert len(poses) == LONGEST_TRAJECTORY and poses[0].pose.position.x == pytest.approx(1.0)
