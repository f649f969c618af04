"""A body of every kind of shape, posed, against PyBullet's own picture of it."""

import math
from pathlib import Path

import numpy as np
import pybullet
import pytest
from tiny_renderer import tiny_picture

from han_bullet.errors import BadInputError
from han_bullet.geometry import Intrinsics, look_at
from han_bullet.sim.jointed_body import JointedBody
from han_bullet.sim.raster import Raster, View
from han_bullet.sim.rasterizer import draw
from han_bullet.world_schema import Light

INTRINSICS = Intrinsics.from_vertical_field_of_view(320, 240, math.radians(45.0))
OBJ = "v 0 0 0\nv 0.4 0 0\nv 0 0.3 0\nv 0 0 0.5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def shape(geometry: str, origin: str, colour: str) -> str:
    return (
        f'<visual><origin {origin}/><geometry>{geometry}</geometry><material name="{colour}">'
        f'<color rgba="{colour}"/></material></visual>'
    )


def link(name: str, visual: str, inertial: str = 'xyz="0 0 0"') -> str:
    inertia = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    return f'<link name="{name}"><inertial><origin {inertial}/><mass value="1"/>{inertia}</inertial>{visual}</link>'


def robot(folder: Path, base: str) -> Path:
    """A base and an arm that turns about x, each with a centre of mass beside its origin."""
    (folder / "wedge.obj").write_text(OBJ)
    arm = shape('<box size="0.2 0.3 0.9"/>', 'xyz="0 0 0.5" rpy="0.2 0 0.4"', "0.2 0.4 0.9 1")
    arm += shape('<mesh filename="wedge.obj" scale="1.5 1 1"/>', 'xyz="0.3 0 0.6" rpy="0 0.5 0"', "0.9 0.5 0.1 1")
    joint = (
        '<joint name="arm" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.5"/>'
        '<axis xyz="1 0 0"/><limit lower="-3" upper="3" effort="0" velocity="0"/></joint>'
    )
    path = folder / "robot.urdf"
    links = link("base", base, 'xyz="0.1 0.2 0.3" rpy="0.3 0 0"') + link("arm", arm)
    path.write_text(f'<robot name="r">{links}{joint}</robot>')
    return path


ROUND = shape('<cylinder radius="0.4" length="0.5"/>', 'xyz="0.1 0 0.25" rpy="0 0.1 0"', "0.8 0.2 0.2 1") + shape(
    '<sphere radius="0.25"/>', 'xyz="0.7 0.5 0.3"', "0.3 0.8 0.3 1"
)
SQUARE = shape('<box size="0.8 0.7 0.5"/>', 'xyz="0.1 0 0.25" rpy="0 0.1 0"', "0.8 0.2 0.2 1")


@pytest.mark.parametrize(("base", "outline", "depth"), [(SQUARE, 0.002, 1e-4), (ROUND, 0.03, 2e-3)])
def test_a_posed_body_looks_as_pybullet_draws_it(tmp_path: Path, base: str, outline: float, depth: float) -> None:
    client = pybullet.connect(pybullet.DIRECT)
    body = pybullet.loadURDF(str(robot(tmp_path, base)), useFixedBase=True, physicsClientId=client)
    turn = pybullet.getQuaternionFromEuler((0.1, 0.2, 0.9))
    pybullet.resetBasePositionAndOrientation(body, (1.0, 2.0, 0.3), turn, physicsClientId=client)
    pybullet.resetJointState(body, 0, 0.7, physicsClientId=client)
    view = View(INTRINSICS, look_at(np.array([4.0, 3.5, 1.8]), np.array([1.0, 2.0, 0.6])))
    ours, theirs = Raster.blank(INTRINSICS), tiny_picture(client, view, Light())
    for mesh in JointedBody(client, body).meshes_in_world():
        draw(ours, mesh, view, Light())
    pybullet.disconnect(physicsClientId=client)
    seen = ours.drawn | theirs.drawn
    assert seen.sum() > 5000
    assert (ours.drawn != theirs.drawn).sum() <= outline * seen.sum()
    both = ours.drawn & theirs.drawn
    assert np.median(np.abs(1.0 / ours.inverse_depth[both] - 1.0 / theirs.inverse_depth[both])) < depth
    if base == SQUARE:  # PyBullet's cylinders and spheres are coarser, and shaded as if their edges were round
        assert (np.abs(ours.colour[both].astype(int) - theirs.colour[both]) <= 1).mean() > 0.995


def test_a_part_that_cannot_be_drawn_is_named(tmp_path: Path) -> None:
    client = pybullet.connect(pybullet.DIRECT)
    base = shape('<capsule radius="0.2" length="0.5"/>', 'xyz="0 0 0"', "1 1 1 1")
    body = pybullet.loadURDF(str(robot(tmp_path, base)), physicsClientId=client)
    with pytest.raises(BadInputError, match="part of link -1"):
        JointedBody(client, body)
    pybullet.disconnect(physicsClientId=client)
