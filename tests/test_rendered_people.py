"""The benchmark on rendered people: what it takes for a hit, a miss and a mistake."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.contact_sheet import COLUMNS, ROWS, SIDE, ContactSheet
from benchmarks.rendered_people import Tally, count
from han_bullet.geometry import Array
from han_bullet.messages import Detections, Frame, Posture
from han_bullet.rendered_sequences import PersonInPicture, RenderedFrame
from han_bullet.world_file import load_world

ROOT = Path(__file__).parent.parent


def box_at(x: float, height: float = 200.0) -> Array:
    return np.array([x, 100.0, 0.41 * height, height])


def person_at(x: float, height: float = 200.0) -> PersonInPicture:
    return PersonInPicture(box_at(x, height), False, 0.0, 0.2, 0.0, Posture.WALKING)


def frame_of(*people: PersonInPicture) -> RenderedFrame:
    camera = load_world("real2").camera("camera1")
    frame = Frame("camera1", 0.0, np.zeros((480, 640, 3), np.uint8), camera.intrinsics, np.eye(4), True)
    return RenderedFrame(frame, people, None, 0)


def found(*boxes: Array) -> Detections:
    count = len(boxes)
    return Detections(np.reshape(boxes, (count, 4)), np.arange(count, 0, -1.0), np.ones(count))


def tally_of(frame: RenderedFrame, *boxes: Array) -> Tally:
    tally = Tally("test")
    count(frame, found(*boxes), tally, (ContactSheet(), ContactSheet()))
    return tally


def test_a_person_is_found_once_and_a_second_box_on_them_is_a_mistake() -> None:
    tally = tally_of(frame_of(person_at(100.0)), box_at(105.0), box_at(97.0))
    assert tally.recall() == "1.000 (1)"
    assert tally.false_positives == 1


def test_a_box_on_the_legs_alone_is_a_miss_and_a_mistake() -> None:
    tally = tally_of(frame_of(person_at(100.0)), np.array([120.0, 200.0, 41.0, 100.0]))
    assert tally.recall() == "0.000 (1)"
    assert tally.false_positives == 1


def test_a_box_on_somebody_who_does_not_count_is_neither_and_one_beside_is_a_mistake() -> None:
    small = person_at(100.0, 105.0)
    assert not small.counts
    assert tally_of(frame_of(small), small.box).false_positives == 0
    assert tally_of(frame_of(small), small.box + np.array([60.0, 0.0, 0.0, 0.0])).false_positives == 1


def test_a_person_who_counts_is_not_excused_by_one_who_does_not_behind_them() -> None:
    behind = replace(person_at(110.0), hidden=0.9)
    tally = tally_of(frame_of(person_at(100.0), behind))
    assert tally.recall() == "0.000 (1)"


def test_a_contact_sheet_shows_at_most_its_cells_spread_over_all(tmp_path: Path) -> None:
    sheet = ContactSheet()
    for _ in range(COLUMNS * ROWS + 5):
        sheet.add(frame_of(), box_at(100.0), found(), "nothing")
    sheet.save(tmp_path / "sheet.png")
    picture = cv2.imread(str(tmp_path / "sheet.png"))
    assert picture is not None and picture.shape == (ROWS * SIDE, COLUMNS * SIDE, 3)
    ContactSheet().save(tmp_path / "none.png")
    assert not (tmp_path / "none.png").exists()


@pytest.mark.scenario
def test_the_command_prints_the_table_and_finds_the_seated_person(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "benchmarks.rendered_people", "--frames", "20", "--out", str(tmp_path)]
    printed = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True).stdout
    rows = {cells[1].strip(): cells[2:-1] for line in printed.splitlines() if len(cells := line.split("|")) > 2}
    assert [int(cell) for cell in rows["frames"]] == [20, 20, 20, 4, 4]
    recalls = [float(cell.strip(" *").split()[0]) for cell in rows["**recall (people)**"]]
    assert min(recalls[:3]) >= 0.8  # twenty frames of one take each
    assert min(recalls[3:]) == 1.0
