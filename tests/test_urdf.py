"""The committed bodies: what they hold, and that the scripts beside them still make them."""

import math
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pybullet as p
import pytest
from PIL import Image

from han_bullet import assets
from han_bullet.geometry import Array
from han_bullet.sim.gait import JOINTS
from han_bullet.sim.skeleton import skeleton_of

URDF = assets.urdf_folder()
MESHES = sorted((URDF / "meshes").glob("*.obj"))
TEXTURES = ("tiles", "parquet", "plaster", "wood", "fabric", "screen_on")
WHEELS = tuple(f"wheel_{end}_{side}" for end in ("front", "rear") for side in ("left", "right"))


@pytest.fixture
def client() -> Iterator[int]:
    number = p.connect(p.DIRECT)
    yield number
    p.disconnect(physicsClientId=number)


def read_mesh(path: Path) -> tuple[Array, Array, np.ndarray]:
    """Vertices, normals and faces of an OBJ file."""
    lines = [line.split() for line in path.read_text().splitlines()]
    vertices = np.array([line[1:] for line in lines if line[0] == "v"], float)
    normals = np.array([line[1:] for line in lines if line[0] == "vn"], float)
    faces = np.array([[item.split("/")[0] for item in line[1:]] for line in lines if line[0] == "f"], int) - 1
    return vertices, normals, faces


def triangles(urdf: str) -> int:
    """Number of triangles of all links together."""
    files = [mesh.get("filename", "") for mesh in ET.parse(URDF / urdf).iter("mesh")]
    return sum(len(read_mesh(URDF / file)[2]) for file in files)


def joints(client: int, body: int) -> dict[str, tuple[int, int]]:
    infos = [
        p.getJointInfo(body, i, physicsClientId=client) for i in range(p.getNumJoints(body, physicsClientId=client))
    ]
    return {info[1].decode(): (info[0], info[2]) for info in infos}


@pytest.mark.parametrize("path", MESHES, ids=lambda path: path.stem)
def test_faces_are_wound_outward_and_normals_point_outward(path: Path) -> None:
    vertices, normals, faces = read_mesh(path)
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    across = np.cross(b - a, c - a)
    agree = np.einsum("ij,ij->i", across, normals[faces].sum(axis=1)) > 0.0
    area = np.linalg.norm(across, axis=1)
    assert area[agree].sum() > 0.995 * area.sum()
    # A closed surface wound outward encloses a positive volume; open bands of the robot are judged by the normals.
    assert np.einsum("ij,ij->i", a, across).sum() > 0.0
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, atol=0.01)


@pytest.mark.parametrize(
    ("urdf", "limit"),
    [("avatar_slim.urdf", 4000), ("avatar_broad.urdf", 4000), ("mbot.urdf", 3000), ("couch.urdf", 3000)],
)
def test_bodies_are_cheap_to_draw(urdf: str, limit: int) -> None:
    assert 500 < triangles(urdf) <= limit


def test_the_folder_stays_small() -> None:
    size = sum(path.stat().st_size for path in URDF.rglob("*") if path.is_file() and path.suffix != ".pyc")
    assert size < 4_000_000


@pytest.mark.parametrize("build", ["slim", "broad"])
def test_an_avatars_bones_are_as_long_as_the_gait_believes(client: int, build: str) -> None:
    body = p.loadURDF(str(URDF / f"avatar_{build}.urdf"), useFixedBase=True, physicsClientId=client)
    named, s = joints(client, body), skeleton_of(build)
    assert set(JOINTS) <= set(named)

    def place(joint: str) -> Array:
        state = p.getLinkState(body, named[joint][0], computeForwardKinematics=1, physicsClientId=client)
        return np.array(state[4])

    for side in ("left", "right"):
        hip, knee, ankle = (place(f"{name}_{side}") for name in ("hip_yaw", "knee", "ankle_pitch"))
        assert np.linalg.norm(knee - hip) == pytest.approx(s.thigh, abs=1e-3)
        assert np.linalg.norm(ankle - knee) == pytest.approx(s.shin, abs=1e-3)
        assert abs(hip[1]) == pytest.approx(s.hip, abs=1e-3)


def test_the_robot_weighs_forty_kilograms_and_is_one_cylinder(client: int) -> None:
    flag = p.URDF_USE_IMPLICIT_CYLINDER  # without it the engine turns a cylinder into a hull of points
    body = p.loadURDF(str(URDF / "mbot.urdf"), flags=flag, physicsClientId=client)
    named = joints(client, body)
    masses = [p.getDynamicsInfo(body, link, physicsClientId=client)[0] for link in range(-1, len(named))]
    hulls = [
        shape for link in range(-1, len(named)) for shape in p.getCollisionShapeData(body, link, physicsClientId=client)
    ]
    assert sum(masses) == pytest.approx(40.0, abs=0.5)
    assert min(masses) > 0.0
    assert len(hulls) == 1
    assert hulls[0][2] == p.GEOM_CYLINDER
    assert hulls[0][3][:2] == pytest.approx((0.98, 0.3))
    assert p.getAABB(body, -1, physicsClientId=client)[0][2] > 0.0


def test_the_robot_has_its_wheels_head_and_camera_where_they_belong(client: int) -> None:
    body = p.loadURDF(str(URDF / "mbot.urdf"), useFixedBase=True, physicsClientId=client)
    named = joints(client, body)
    state = p.getLinkState(body, named["camera_mount"][0], computeForwardKinematics=1, physicsClientId=client)
    assert all(named[name][1] == p.JOINT_REVOLUTE for name in ("head_pan", *WHEELS))
    assert state[4] == pytest.approx((0.25, 0.0, 1.2))
    for name in WHEELS:
        x, y, z = p.getLinkState(body, named[name][0], physicsClientId=client)[4]
        assert (x > 0.0) == ("front" in name)
        assert (y > 0.0) == ("left" in name)
        assert z == pytest.approx(0.075)


def test_nothing_of_the_robot_is_before_its_camera(client: int) -> None:
    """From the optical point, level and 20 degrees down, the software renderer sees an empty picture."""
    body = p.loadURDF(str(URDF / "mbot.urdf"), useFixedBase=True, physicsClientId=client)
    lens = p.computeProjectionMatrixFOV(60.0, 4.0 / 3.0, 0.1, 20.0)
    for down in (0.05, math.radians(20.0)):
        view = p.computeViewMatrix((0.25, 0.0, 1.2), (1.25, 0.0, 1.2 - math.tan(down)), (0.0, 0.0, 1.0))
        mask = p.getCameraImage(160, 120, view, lens, renderer=p.ER_TINY_RENDERER, shadow=0, physicsClientId=client)[4]
        assert not (np.asarray(mask) == body).any()


def test_the_robot_stays_upright_and_in_its_footprint() -> None:
    vertices = [
        read_mesh(path)[0]
        for path in MESHES
        if path.stem in {"robot_shell", "robot_column", "robot_chassis", "robot_boom"}
    ]
    assert len(vertices) == 4
    assert max(np.linalg.norm(each[:, :2], axis=1).max() for each in vertices) <= 0.3


def test_the_couch_has_the_declared_size() -> None:
    parts = [read_mesh(URDF / "meshes" / f"couch_{name}.obj")[0] for name in ("cloth", "feet")]
    low, high = (
        np.min([part.min(axis=0) for part in parts], axis=0),
        np.max([part.max(axis=0) for part in parts], axis=0),
    )
    assert low == pytest.approx((-0.4, -0.95, 0.0), abs=0.015)
    assert high == pytest.approx((0.4, 0.95, 0.8), abs=0.015)
    seat = parts[0][(np.abs(parts[0][:, 0] - 0.1) < 0.3) & (np.abs(parts[0][:, 1]) < 0.6)]
    assert seat[seat[:, 0] > 0.0][:, 2].max() == pytest.approx(0.42, abs=0.02)


@pytest.mark.parametrize("name", TEXTURES)
def test_textures_are_small_pictures(name: str) -> None:
    with Image.open(URDF / "textures" / f"{name}.png") as picture:
        assert picture.mode == "RGB"
        assert 256 <= max(picture.size) <= 512


@pytest.mark.parametrize("name", ["tiles", "parquet", "plaster", "wood", "fabric"])
def test_textures_go_on_without_a_seam(name: str) -> None:
    with Image.open(URDF / "textures" / f"{name}.png") as picture:
        grey = np.asarray(picture.convert("L"), float)
    for axis in (0, 1):
        inside = np.abs(np.diff(grey, axis=axis)).mean(axis=1 - axis)
        seam = np.abs(np.take(grey, 0, axis=axis) - np.take(grey, -1, axis=axis)).mean()
        assert seam <= 1.2 * inside.max()


@pytest.mark.parametrize("script", ["make_avatars", "make_robot", "make_couch", "make_textures"])
def test_the_scripts_still_make_what_is_committed(script: str, tmp_path: Path) -> None:
    pytest.importorskip("skimage", reason="scikit-image makes the meshes; install the extra 'dev'")
    subprocess.run(
        [sys.executable, str(URDF / f"{script}.py"), "--out", str(tmp_path)], check=True, capture_output=True
    )
    made = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert len(made) >= 3
    for path in made:
        committed = URDF / path.relative_to(tmp_path)
        if path.suffix == ".png":
            with Image.open(path) as new, Image.open(committed) as old:
                assert np.abs(np.asarray(new, int) - np.asarray(old, int)).mean() < 1.0
        elif path.suffix == ".obj":
            assert len(read_mesh(path)[2]) == len(read_mesh(committed)[2])
            assert np.allclose(read_mesh(path)[0], read_mesh(committed)[0], atol=2e-3)
        else:
            assert path.read_text() == committed.read_text()
