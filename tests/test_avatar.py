"""Dressed bodies in a real PyBullet client: where links are, what a camera sees."""

import math
from collections.abc import Iterator

import numpy as np
import pybullet as p
import pytest

from han_bullet import assets
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Pose2D
from han_bullet.messages import Posture
from han_bullet.sim.avatar import OUTFITS, Avatar
from han_bullet.sim.gait import JOINTS, BodyPose, Gait
from han_bullet.sim.skeleton import skeleton_of

WIDTH, HEIGHT = 200, 300  # [px]


@pytest.fixture
def client() -> Iterator[int]:
    number = p.connect(p.DIRECT)
    yield number
    p.disconnect(physicsClientId=number)


def standing(build: str, pose: Pose2D) -> BodyPose:
    return Gait(build).advance(pose, 0.0, 0.05, Posture.STANDING)


def link_vertices(client: int, avatar: Avatar, joint: str, mesh: str) -> Array:
    """Vertices of the link below a joint, in the world [m]."""
    text = (assets.urdf_folder() / "meshes" / f"{mesh}.obj").read_text().splitlines()
    vertices = np.array([line.split()[1:] for line in text if line.startswith("v ")], float)
    count = p.getNumJoints(avatar.body, physicsClientId=client)
    names = [p.getJointInfo(avatar.body, index, physicsClientId=client)[1].decode() for index in range(count)]
    state = p.getLinkState(avatar.body, names.index(joint), computeForwardKinematics=1, physicsClientId=client)
    turn = np.array(p.getMatrixFromQuaternion(state[5])).reshape(3, 3)
    world: Array = vertices @ turn.T + state[4]
    return world


def picture(client: int) -> tuple[Array, np.ndarray]:
    """Colours and body ids that a camera 4 m before the origin sees."""
    view = p.computeViewMatrix((4.0, 0.0, 1.0), (0.0, 0.0, 0.95), (0.0, 0.0, 1.0))
    lens = p.computeProjectionMatrixFOV(35.0, WIDTH / HEIGHT, 0.1, 20.0)
    _, _, colour, _, mask = p.getCameraImage(
        WIDTH, HEIGHT, view, lens, shadow=0, renderer=p.ER_TINY_RENDERER, physicsClientId=client
    )
    return np.reshape(colour, (HEIGHT, WIDTH, 4))[:, :, :3].astype(float), np.reshape(mask, (HEIGHT, WIDTH))


@pytest.mark.parametrize(("build", "height"), [("slim", 1.70), ("broad", 1.80)])
def test_a_standing_body_reaches_from_the_floor_to_its_height(client: int, build: str, height: float) -> None:
    avatar = Avatar(client, build, 0)
    avatar.place(standing(build, Pose2D(1.0, 2.0, 0.7)))
    soles = [link_vertices(client, avatar, f"ankle_roll_{side}", f"{build}_shoe") for side in ("left", "right")]
    crown = link_vertices(client, avatar, "hair", f"{build}_hair")
    assert all(abs(sole[:, 2].min()) < 0.006 for sole in soles)
    assert crown[:, 2].max() == pytest.approx(height, abs=0.03)
    assert np.linalg.norm(np.mean([sole.mean(axis=0) for sole in soles], axis=0)[:2] - [1.0, 2.0]) < 0.08


@pytest.mark.parametrize("build", ["slim", "broad"])
def test_proportions_are_those_of_people(client: int, build: str) -> None:
    skeleton = skeleton_of(build)
    avatar = Avatar(client, build, 0)
    avatar.place(standing(build, Pose2D(0.0, 0.0, 0.0)))
    hand = link_vertices(client, avatar, "hand_left", f"{build}_hand")
    arms = [link_vertices(client, avatar, f"shoulder_roll_{side}", f"{build}_upper_arm") for side in ("left", "right")]
    head = link_vertices(client, avatar, "neck_pitch", f"{build}_head")
    knee = skeleton.ankle + skeleton.shin
    assert 0.48 < (skeleton.leg + skeleton.ankle) / skeleton.height < 0.55
    assert 0.43 < arms[0][:, 1].max() - arms[1][:, 1].min() < 0.58
    assert knee < hand[:, 2].min() < knee + 0.75 * skeleton.thigh
    assert 0.12 < np.ptp(head[:, 1]) < 0.22


@pytest.mark.parametrize("speed", [0.35, 1.2])
def test_the_shoes_of_a_walker_touch_the_floor_and_never_sink_in(client: int, speed: float) -> None:
    avatar, gait = Avatar(client, "broad", 3), Gait("broad")
    for index in range(60):
        avatar.place(gait.advance(Pose2D(speed * 0.05 * index, 0.0, 0.0), speed, 0.05, Posture.WALKING))
        lowest = [
            link_vertices(client, avatar, f"ankle_roll_{side}", "broad_shoe")[:, 2].min() for side in ("left", "right")
        ]
        assert -0.012 < min(lowest) < 0.008


def test_place_sets_every_joint(client: int) -> None:
    avatar = Avatar(client, "slim", 2)
    angles = tuple(0.01 * (index + 1) for index in range(len(JOINTS)))
    avatar.place(BodyPose(Pose2D(1.0, -2.0, 0.3), 0.8, 0.1, angles))
    count = p.getNumJoints(avatar.body, physicsClientId=client)
    infos = [p.getJointInfo(avatar.body, index, physicsClientId=client) for index in range(count)]
    found = {info[1].decode(): p.getJointState(avatar.body, info[0], physicsClientId=client)[0] for info in infos}
    position, quaternion = p.getBasePositionAndOrientation(avatar.body, physicsClientId=client)
    assert tuple(found[name] for name in JOINTS) == pytest.approx(angles)
    assert position == pytest.approx((1.0, -2.0, 0.8))
    assert p.getEulerFromQuaternion(quaternion) == pytest.approx((0.0, 0.1, 0.3))


def test_every_outfit_looks_different_and_shirt_and_trousers_differ(client: int) -> None:
    chests, thighs = [], []
    for outfit in range(Avatar.outfits_count):
        avatar = Avatar(client, "slim", outfit)
        avatar.place(standing("slim", Pose2D(0.0, 0.0, 0.0)))
        colour, mask = picture(client)
        body = mask == avatar.body
        assert 0.05 < body.mean() < 0.5
        rows = np.flatnonzero(body.any(axis=1))
        at = [rows[0] + round(share * np.ptp(rows)) for share in (0.33, 0.63)]
        chests.append(np.median(colour[at[0]][body[at[0]]], axis=0))
        thighs.append(np.median(colour[at[1]][body[at[1]]], axis=0))
        p.removeBody(avatar.body, physicsClientId=client)
    assert Avatar.outfits_count == len(OUTFITS) == 8
    pairs = [(i, j) for i in range(8) for j in range(i)]
    assert min(np.abs(chests[i] - chests[j]).max() for i, j in pairs) > 10.0
    assert sum(np.abs(chest - thigh).max() > 15.0 for chest, thigh in zip(chests, thighs, strict=True)) == 8


def test_the_face_looks_where_the_body_faces(client: int) -> None:
    avatar = Avatar(client, "slim", 5)
    shades = []
    for yaw in (0.0, math.pi):
        avatar.place(standing("slim", Pose2D(0.0, 0.0, yaw)))
        colour, mask = picture(client)
        rows = np.flatnonzero((mask == avatar.body).any(axis=1))
        face = colour[rows[0] + 9 : rows[0] + 15]
        shades.append(face[mask[rows[0] + 9 : rows[0] + 15] == avatar.body].mean())
    assert shades[0] > 1.3 * shades[1]


def test_pictures_repeat_bit_for_bit(client: int) -> None:
    avatar = Avatar(client, "broad", 6)
    pictures = []
    for yaw in (0.4, 1.9, 0.4):
        avatar.place(standing("broad", Pose2D(0.0, 0.0, yaw)))
        pictures.append(picture(client)[0])
    assert np.array_equal(pictures[0], pictures[2])
    assert not np.array_equal(pictures[0], pictures[1])


@pytest.mark.parametrize("outfit", [-1, 8])
def test_an_outfit_that_does_not_exist_is_refused(client: int, outfit: int) -> None:
    with pytest.raises(BadInputError, match=f"outfit is {outfit}; there are 0 to 7"):
        Avatar(client, "slim", outfit)


def test_a_build_that_does_not_exist_is_refused(client: int) -> None:
    with pytest.raises(BadInputError, match="'slim' or 'broad'"):
        Avatar(client, "tall", 0)
