"""The short form of a fault on the command line."""

import argparse
from pathlib import Path

import pytest

from han_bullet.cli import main
from han_bullet.commands.fault_option import fault, fault_word
from han_bullet.world_schema import Black, Dropped, Frozen, InjectedFault, Knocked, Late, Slippery, Trigger


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("camera2=frozen@5", Frozen(target="camera2", starts=Trigger(delay=5.0))),
        ("camera1=dropped:0.5", Dropped(target="camera1", share=0.5)),
        ("all=black@3-6.5", Black(target="all", starts=Trigger(delay=3.0), until=6.5)),
        ("black", Black(target="all")),
        ("onboard=late:0.3@2", Late(target="onboard", delay=0.3, starts=Trigger(delay=2.0))),
        ("camera3=knocked:-3", Knocked(target="camera3", degrees=-3.0)),
        ("slip:5@3", Slippery(target="wheels", times=5.0, starts=Trigger(delay=3.0))),
        ("tv=dropped", Dropped(target="tv", share=1.0)),
    ],
)
def test_a_fault_is_read_as_it_is_meant(text: str, meant: object) -> None:
    assert fault(text) == meant


@pytest.mark.parametrize(
    ("meant", "word"),
    [
        (Frozen(target="camera2", starts=Trigger(delay=5.0)), "camera2=frozen@5"),
        (Black(until=6.5), "all=black@0-6.5"),
        (Knocked(target="camera3", degrees=-3.0), "camera3=knocked:-3"),
        (Dropped(target="tv", share=1e-7), "tv=dropped:0.0000001"),
        (
            Slippery(times=0.1 + 0.2, starts=Trigger(delay=100.0), until=120.0),
            "wheels=slip:0.30000000000000004@100-120",
        ),
        (Late(delay=0.3), "all=late:0.3"),
    ],
)
def test_the_word_of_a_fault_is_read_as_that_fault_again(meant: InjectedFault, word: str) -> None:
    assert fault_word(meant) == word
    assert fault(word) == meant


def test_a_fault_that_waits_for_an_event_has_no_word() -> None:
    assert fault_word(Frozen(target="camera2", starts=Trigger(when="robot_near"))) is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("camera2=melted", "kind 'melted'; one of frozen, black, dropped, late, knocked, slip would be right"),
        ("camera2=black:3", "black takes none"),
        ("camera2=frozen@soon", "such as camera2=frozen@5"),
        ("", "such as camera2=frozen@5"),
        ("dropped:2", "less than or equal to 1"),
        ("frozen@5-3", "starts at 5 s and ends at 3 s"),
        ("late:0", "greater than 0"),
    ],
)
def test_what_is_no_fault_is_refused_with_what_would_be_right(text: str, message: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=message):
        fault(text)


def test_a_fault_of_a_sensor_that_the_world_lacks_is_one_sentence_and_exit_code_two(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert main(["run", "real2", "--fault", "camera9=frozen", "--out", str(tmp_path / "run")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith("'camera9'; one of all, camera1, camera2, camera3, camera4, onboard would be right")
    assert not (tmp_path / "run").exists()
