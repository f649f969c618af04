"""The robot's URDF as ROS wants it."""

from pathlib import Path
from urllib.parse import unquote, urlparse
from xml.etree import ElementTree

import numpy as np
import pybullet
import pytest

from han_bullet import assets
from han_bullet.errors import BadInputError
from han_bullet.geometry import Pose2D
from han_bullet.mecanum import WHEELS
from han_bullet.ros.robot_description import RobotDescription
from han_bullet.sim.robot_model import RobotModel


def test_every_mesh_is_a_file_that_is_there() -> None:
    meshes = [
        mesh.attrib["filename"] for mesh in ElementTree.fromstring(RobotDescription("mbot.urdf").text).iter("mesh")
    ]
    assert len(meshes) > 10
    for mesh in meshes:
        address = urlparse(mesh)
        assert address.scheme == "file" and Path(unquote(address.path)).is_file()


def test_the_root_is_base_link_and_everything_hangs_on_it() -> None:
    robot = ElementTree.fromstring(RobotDescription("mbot.urdf").text)
    links = {link.attrib["name"] for link in robot.iter("link")}
    children = {child.attrib["link"] for child in robot.iter("child")}
    parents = {parent.attrib["link"] for parent in robot.iter("parent")}
    assert links - children == {"base_link"} and parents <= links


def test_the_wheels_are_where_the_physics_has_them() -> None:
    client = pybullet.connect(pybullet.DIRECT)
    try:
        wheels = RobotModel(client, "mbot.urdf", Pose2D(2.0, 1.0, 0.5), fixed=True).wheels()
    finally:
        pybullet.disconnect(client)
    read = RobotDescription("mbot.urdf").wheel_geometry
    np.testing.assert_allclose(
        [read.radius, read.half_length, read.half_width],
        [wheels.radius, wheels.half_length, wheels.half_width],
        atol=1e-6,
    )


def urdf(folder: Path, joints: str) -> None:
    (folder / "own.urdf").write_text(f'<robot name="own"><link name="root"/>{joints}</robot>')


def test_an_origin_turns_by_roll_then_pitch_then_yaw(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(assets, "urdf_folder", lambda: tmp_path)
    hung = '<joint name="{0}" type="continuous"><parent link="root"/><child link="{0}"/></joint><link name="{0}"/>'
    arm = (
        '<link name="arm"/><joint name="arm" type="fixed"><parent link="root"/><child link="arm"/>'
        '<origin xyz="1 2 3" rpy="1.5707963267948966 0 1.5707963267948966"/></joint>'
    )
    urdf(tmp_path, arm + "".join(hung.format(name) for name in WHEELS))
    joint = RobotDescription("own.urdf").joints[0]
    # Roll takes y to z and z to -y; yaw then takes x to y and y to -x.
    expected = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    np.testing.assert_allclose(joint.child_in_parent[:3, :3], expected, atol=1e-12)
    assert joint.child_in_parent[:3, 3].tolist() == [1.0, 2.0, 3.0] and joint.axis is None


@pytest.mark.parametrize(
    ("content", "said"),
    [(None, "cannot be read"), ("no XML", "cannot be read"), ("", "lacks the joint 'wheel_front_left'")],
)
def test_what_is_no_robot_is_refused(
    content: str | None, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(assets, "urdf_folder", lambda: tmp_path)
    if content == "no XML":
        (tmp_path / "own.urdf").write_text(content)
    elif content is not None:
        urdf(tmp_path, content)
    with pytest.raises(BadInputError, match=said):
        RobotDescription("own.urdf")


def test_a_wheel_that_does_not_turn_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(assets, "urdf_folder", lambda: tmp_path)
    stuck = '<joint name="{0}" type="fixed"><parent link="root"/><child link="{0}"/></joint><link name="{0}"/>'
    urdf(tmp_path, "".join(stuck.format(name) for name in WHEELS))
    with pytest.raises(BadInputError, match="wheel_front_left does not turn on the root link"):
        RobotDescription("own.urdf")
