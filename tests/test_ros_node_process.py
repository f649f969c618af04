"""Starting the node's process: what is refused and how; no ROS is needed for these."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from han_bullet.errors import BadInputError, HanError
from han_bullet.ros import node_process
from han_bullet.ros.node_process import NodeProcess, check_ros

URI = "http://127.0.0.1:1"


def python(folder: Path, program: str) -> str:
    """A program in the place of the system's python3."""
    path = folder / "python3"
    path.write_text(f"#!/bin/sh\n{program}\n")
    path.chmod(0o755)
    return str(path)


@pytest.mark.parametrize("instead", [sys.executable, "/no/such/python3"])
def test_a_machine_without_ros_is_told_how_to_get_it(instead: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(node_process, "SYSTEM_PYTHON", instead)
    with pytest.raises(BadInputError, match=r"has no rospy; `make ros` installs it"):
        check_ros()


def test_a_ros_that_the_shell_knows_is_found_and_nothing_else_of_its_module_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (
        "workspace/rospy",
        "workspace/rosgraph",
        "workspace/roslib",
        "isolated/genpy",
        "isolated/std_msgs",
        "other/json",
    ):
        (tmp_path / module).mkdir(parents=True)
        (tmp_path / module / "__init__.py").touch()
    monkeypatch.setattr(node_process, "SYSTEM_PYTHON", sys.executable)  # to which nobody else brings rospy
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path / 'other'}:{tmp_path / 'workspace'}:{tmp_path / 'isolated'}:")
    check_ros()
    assert node_process._environment(URI)["PYTHONPATH"] == f"{tmp_path / 'workspace'}:{tmp_path / 'isolated'}"
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path / 'other'}:{tmp_path / 'workspace'}")
    with pytest.raises(BadInputError):
        check_ros()


def test_a_ros_of_its_own_packages_is_found_though_no_shell_knows_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "rospy").mkdir()
    monkeypatch.setattr(node_process, "NOETIC", str(tmp_path))
    monkeypatch.delenv("PYTHONPATH", raising=False)
    assert node_process._environment(URI)["PYTHONPATH"] == str(tmp_path)


def test_a_node_that_dies_while_it_starts_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(node_process, "SYSTEM_PYTHON", python(tmp_path, "echo first >&2; echo the reason >&2; exit 1"))
    with pytest.raises(HanError, match=r"^the ROS node does not start: the reason$"):
        NodeProcess("/han_bullet", URI)


def test_a_node_that_is_never_ready_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(node_process, "SYSTEM_PYTHON", python(tmp_path, f"echo $$ > {tmp_path}/id; exec sleep 600"))
    monkeypatch.setattr(node_process, "READY_WITHIN", 0.5)
    with pytest.raises(HanError, match=r"it was not ready within 0.5 s"):
        NodeProcess("/han_bullet", URI)
    assert not Path(f"/proc/{(tmp_path / 'id').read_text().strip()}").exists()


def test_a_start_that_is_given_up_is_not_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(node_process, "SYSTEM_PYTHON", python(tmp_path, "exec sleep 600"))
    monkeypatch.setattr(node_process, "READY_WITHIN", 500.0)
    with pytest.raises(HanError):
        NodeProcess("/han_bullet", URI, given_up=lambda: True)


def test_only_this_machine_may_connect_unless_an_address_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_IP", raising=False)
    monkeypatch.delenv("ROS_HOSTNAME", raising=False)
    assert node_process._environment(URI)["ROS_IP"] == "127.0.0.1"
    monkeypatch.setenv("ROS_HOSTNAME", "robot")
    assert "ROS_IP" not in node_process._environment(URI)


def test_without_the_message_library_everything_imports_and_a_link_says_what_is_missing() -> None:
    code = """
import sys
sys.modules["rosbags"] = None  # as if it were not installed
from han_bullet import cli
from han_bullet.ros import link, message_types
try:
    message_types.make("std_msgs/Int32")
except link.BadInputError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "ROS messages need the package rosbags; `pip install 'han_bullet[ros]'` brings it\n"
