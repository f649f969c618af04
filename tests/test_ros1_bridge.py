"""The catkin package: what the node may import, what ROS's own commands find in it, and that its parts agree."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from ros_master import Master

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "ros1_bridge"
SCRIPT = PACKAGE / "scripts/han_bullet"
MODULES = sorted(PACKAGE.glob("*.py"))
OF_ROS = {"rospy", "rosgraph", "roslib"}


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.name)
def test_a_module_of_the_node_is_python_3_8_and_needs_only_ros(path: Path) -> None:
    tree = ast.parse(path.read_text(), feature_version=(3, 8))
    used = {
        name.split(".")[0]
        for node in ast.walk(tree)
        for name in (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [node.module or ""]
            if isinstance(node, ast.ImportFrom)
            else []
        )
    }
    assert used <= OF_ROS | sys.stdlib_module_names | {module.stem for module in MODULES}


def test_there_are_modules_to_look_at() -> None:
    assert {path.name for path in MODULES} >= {"node.py", "wire.py", "master_watch.py"}


def test_all_that_the_package_needs_is_installed_by_make_ros() -> None:
    package = ElementTree.parse(PACKAGE / "package.xml").getroot()
    installed = (ROOT / ".ci/install_ros").read_text()
    needed = [element.text or "" for element in package.findall("exec_depend")]
    assert package.findtext("name") == PACKAGE.name and "rospy" in needed
    for name in needed:
        assert f" python3-{name.replace('_', '-')}" in installed or f" {name} " in installed


def test_every_folder_of_the_package_is_installed() -> None:
    folders = {path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert {"config", "launch", "rviz", "scripts"} <= folders
    cmake, setup = (PACKAGE / "CMakeLists.txt").read_text(), (ROOT / "setup.py").read_text()
    (directories,) = re.findall(r"install\(DIRECTORY (.*) DESTINATION", cmake)
    assert {*directories.split(), "scripts"} == folders and "install(PROGRAMS scripts/han_bullet " in cmake
    assert all(f'"{name}/*"' in setup for name in folders)


def test_the_script_hands_on_all_but_remappings(tmp_path: Path) -> None:
    assert (
        said(tmp_path, "real2", "--out", "a b", "__name:=run", "__log:=/tmp/x", "*") == "run|--ros|real2|--out|a b|*|"
    )


def test_the_script_ends_as_the_command_does(tmp_path: Path) -> None:
    command = tmp_path / "han-bullet"
    command.write_text("#!/bin/sh\nexit 3\n")
    command.chmod(0o755)
    assert subprocess.run([SCRIPT, "real2"], env=os.environ | {"HAN_BULLET": str(command)}).returncode == 3


def test_the_script_names_the_variable_where_there_is_no_command() -> None:
    environment = {"PATH": "/usr/bin:/bin"}
    done = subprocess.run([SCRIPT, "real2"], env=environment, capture_output=True, text=True)
    assert done.returncode == 127
    assert done.stderr == "no command 'han-bullet'; set HAN_BULLET to the han-bullet of your virtual environment\n"


def said(folder: Path, *arguments: str, script: tuple[str, ...] = (str(SCRIPT),)) -> str:
    """What a command that shows its arguments gets from the script."""
    command = folder / "han-bullet"
    command.write_text('#!/bin/sh\nprintf "%s|" "$@"\n')
    command.chmod(0o755)
    environment = os.environ | {"HAN_BULLET": str(command), "ROS_PACKAGE_PATH": f"{PACKAGE}:/usr/share"}
    done = subprocess.run([*script, *arguments], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def launch(*arguments: str) -> list[str]:
    """Lines that roslaunch prints about the launch file."""
    environment = os.environ | {"ROS_PACKAGE_PATH": f"{PACKAGE}:/usr/share"}
    command = ["/usr/bin/roslaunch", *arguments]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.ros
def test_rosrun_finds_the_script(ros_master: Master, tmp_path: Path) -> None:
    rosrun = ("/usr/bin/rosrun", "ros1_bridge", "han_bullet")
    assert said(tmp_path, "real2", "__name:=run", script=rosrun) == "run|--ros|real2|"


@pytest.mark.ros
def test_the_launch_file_starts_the_run_and_rviz_where_it_is_asked_for(ros_master: Master) -> None:
    assert launch("--nodes", "ros1_bridge", "demo.launch") == ["/han_bullet"]
    assert launch("--nodes", "ros1_bridge", "demo.launch", "rviz:=true") == ["/han_bullet", "/rviz"]
    (command,) = launch("--args", "/han_bullet", "ros1_bridge", "demo.launch", "world:=real3", "seed:=4")
    assert f"{SCRIPT} real3 --seed 4 --stay" in command
    (command,) = launch("--args", "/rviz", "ros1_bridge", "demo.launch", "rviz:=true")
    assert f"-d {PACKAGE}/rviz/han_bullet.rviz" in command


@pytest.mark.ros
@pytest.mark.parametrize("address", [None, "192.0.2.7"])
def test_what_is_launched_is_of_this_machine_unless_an_address_is_named(
    address: str | None, ros_master: Master, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("ROS_IP")
    if address:
        monkeypatch.setenv("ROS_IP", address)
    (command,) = launch("--args", "/han_bullet", "ros1_bridge", "demo.launch")
    assert ('ROS_IP="127.0.0.1"' in command) == (address is None)  # roslaunch shows only what it changes
