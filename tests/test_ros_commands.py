"""`han-bullet ros-live` and `ros-robot`: what is wrong is told in a sentence, before ROS is asked for anything."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from live_robot import write_live_robot

from han_bullet.cli import main


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["ros-live", "nothing.yaml"], "nothing.yaml: not readable as YAML"),
        (["ros-live"], "the following arguments are required: CONFIG"),
        (["ros-robot", "nowhere"], "world 'nowhere' is not known"),
        (["ros-robot", "real2", "--pace", "0"], "'0' is no pace; a positive number such as 0.5 would be right"),
        (["ros-robot", "real2", "--pace", "fast"], "'fast' is no pace"),
    ],
)
def test_bad_input_is_told_in_a_sentence(arguments: list[str], reason: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert reason in said and said.count("\n") == 1


def test_without_a_master_both_say_so_and_write_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    config = write_live_robot(tmp_path)
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:1")
    out = tmp_path / "out"
    for arguments in (["ros-live", str(config)], ["ros-robot", "real2", "--out", str(out)]):
        assert main(arguments) == 2
        said = capsys.readouterr().err
        assert "no ROS master answers at http://127.0.0.1:1" in said or "has no rospy" in said
    assert not out.exists()


def test_the_stack_on_a_real_robot_imports_neither_pybullet_nor_rospy() -> None:
    modules = ", ".join(f"han_bullet.ros.{name}" for name in ("live", "live_stack", "live_setup", "live_topics"))
    code = f"import sys, {modules}, han_bullet.commands.ros_live; print(*({{'pybullet', 'rospy'}} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
