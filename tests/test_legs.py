"""The legs that a laser sees are where the drawn body has them."""

from collections.abc import Iterator

import numpy as np
import pybullet
import pytest

from han_bullet.geometry import Pose2D
from han_bullet.messages import Posture
from han_bullet.sim.avatar import Avatar
from han_bullet.sim.gait import Gait
from han_bullet.sim.legs import SHIN_RADIUS, THIGH_RADIUS, leg_bones
from han_bullet.sim.skeleton import skeleton_of


@pytest.fixture
def client() -> Iterator[int]:
    number = pybullet.connect(pybullet.DIRECT)
    yield number
    pybullet.disconnect(physicsClientId=number)


@pytest.mark.parametrize("build", ["slim", "broad"])
@pytest.mark.parametrize("posture", [Posture.WALKING, Posture.SEATED])
def test_knees_and_ankles_are_those_of_the_drawn_body(client: int, build: str, posture: Posture) -> None:
    avatar, gait = Avatar(client, build, 0), Gait(build)
    names = {
        pybullet.getJointInfo(avatar.body, index, physicsClientId=client)[1].decode(): index
        for index in range(pybullet.getNumJoints(avatar.body, physicsClientId=client))
    }

    def joint(name: str) -> tuple[float, float, float]:
        state = pybullet.getLinkState(avatar.body, names[name], computeForwardKinematics=True, physicsClientId=client)
        place: tuple[float, float, float] = state[4]
        return place

    speed = 1.0 if posture is Posture.WALKING else 0.0
    for tick in range(30):
        pose = Pose2D(2.0 + 0.6 * speed * tick * 0.05, 1.0 - 0.8 * speed * tick * 0.05, -0.927)
        body_pose = gait.advance(pose, speed, 0.05, posture)
        avatar.place(body_pose)
        left_thigh, left_shin, right_thigh, right_shin = leg_bones(skeleton_of(build), body_pose)
        for side, thigh, shin in (("left", left_thigh, left_shin), ("right", right_thigh, right_shin)):
            assert thigh.upper == pytest.approx(joint(f"hip_yaw_{side}"), abs=1e-6)
            assert thigh.lower == pytest.approx(joint(f"knee_{side}"), abs=1e-6)
            assert np.array_equal(shin.upper, thigh.lower)
            assert shin.lower == pytest.approx(joint(f"ankle_pitch_{side}"), abs=1e-6)
            assert (thigh.radius, shin.radius) == (THIGH_RADIUS, SHIN_RADIUS)
