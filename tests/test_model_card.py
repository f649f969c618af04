"""The log of a training and the card of its weights, as a stranger reads them."""

import re
import sys
from datetime import date
from pathlib import Path

import pytest

from han_bullet.model_card import LINES_SHOWN, TrainingLog, write_model_card


def card(folder: Path, lines: int = 3, resumed: bool = False) -> str:
    """Write a card of made-up weights and return its text."""
    weights = folder / "mine.safetensors"
    weights.write_bytes(b"x" * 12_345)
    with TrainingLog(folder / "mine.log", resumed) as log:
        for number in range(lines):
            log.write(f"epoch {number}")
    path = write_model_card(weights, "train cnn", "han-bullet evaluate --classifier mine", 7, folder / "photos", log)
    assert path == folder / "mine.md"
    return path.read_text(encoding="utf-8")


def rows(text: str) -> dict[str, str]:
    """Return the card's table; every line of it has two cells."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    cells = [re.split(r"(?<!\\)\|", line)[1:-1] for line in lines]
    assert all(len(cell) == 2 for cell in cells) and len(cells) >= 10
    return {name.strip(): value.strip() for name, value in cells[2:]}


def test_a_card_says_where_the_weights_come_from(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["/somewhere/bin/han-bullet", "train", "cnn", "--data", "my photos"])
    table = rows(card(tmp_path))
    assert table["file"] == "`mine.safetensors`, 12 kB"
    assert table["command"] == "`han-bullet train cnn --data 'my photos'`"
    assert "INRIA Person" in table["data"] and "`photos`" in table["data"] and "research use" in table["data"]
    assert table["seed"] == "7"
    assert table["date"] == date.today().isoformat()
    assert re.fullmatch(r"\d+ s on .+", table["training time"])
    assert re.fullmatch(r"[0-9a-f]{40}(-dirty)?|unknown", table["commit"])
    assert re.search(r"python 3\.\d+\.\d+, .*torch \d", table["versions"])


def test_a_card_has_a_title_a_log_and_says_how_to_measure(tmp_path: Path) -> None:
    text = card(tmp_path)
    assert text.startswith("# mine: made by `train cnn`\n")
    assert [line for line in text.splitlines() if line.startswith("## ")] == ["## Log", "## Figures"]
    assert re.search(r"```\n +0\.\d s  epoch 0\n +0\.\d s  epoch 1\n +0\.\d s  epoch 2\n```", text)
    assert text.endswith("Not measured yet: `han-bullet evaluate --classifier mine` prints them.\n")


def test_a_long_log_is_cut_and_the_card_says_so(tmp_path: Path) -> None:
    text = card(tmp_path, lines=LINES_SHOWN + 5)
    assert f"## Log, the last {LINES_SHOWN} lines of {LINES_SHOWN + 5}\n" in text
    assert "epoch 4\n" not in text and "epoch 5\n" in text and f"epoch {LINES_SHOWN + 4}\n" in text


def test_a_bar_in_the_command_does_not_break_the_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["han-bullet", "train", "--data", "a|b"])
    assert rows(card(tmp_path))["command"] == "`han-bullet train --data 'a\\|b'`"


def test_the_data_folder_has_a_name_even_if_it_is_given_as_a_dot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "photos").mkdir()
    monkeypatch.chdir(tmp_path / "photos")
    weights = tmp_path / "mine.npz"
    weights.write_bytes(b"x")
    path = write_model_card(weights, "train acf", "", 0, Path("."), TrainingLog(tmp_path / "mine.log"))
    assert "`photos`" in rows(path.read_text(encoding="utf-8"))["data"]


def test_every_line_is_in_the_file_as_soon_as_it_is_written(tmp_path: Path) -> None:
    with TrainingLog(tmp_path / "a.log") as log:
        log.write("first")
        assert re.fullmatch(r" +0\.\d s  first\n", (tmp_path / "a.log").read_text())
        log.write("second")
    assert (tmp_path / "a.log").read_text().splitlines() == log.lines


def test_a_training_that_never_says_anything_leaves_an_earlier_log_alone(tmp_path: Path) -> None:
    (tmp_path / "a.log").write_text("earlier\n")
    with TrainingLog(tmp_path / "a.log"):
        pass
    assert (tmp_path / "a.log").read_text() == "earlier\n"
    with TrainingLog(tmp_path / "a.log") as log:
        log.write("new")
    assert "earlier" not in (tmp_path / "a.log").read_text()


def test_a_resumed_training_goes_on_with_its_log_and_its_card_says_so(tmp_path: Path) -> None:
    (tmp_path / "mine.log").write_text("   60.0 s  half of it\n")
    text = card(tmp_path, lines=1, resumed=True)
    assert re.search(r"```\n   60\.0 s  half of it\n +0\.\d s  epoch 0\n```", text)
    assert re.fullmatch(r"\d+ s since it was resumed on .+", rows(text)["training time"])
    assert len((tmp_path / "mine.log").read_text().splitlines()) == 2
