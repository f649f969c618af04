"""The benchmark of localization: one drive, and what its table says of it."""

import sys

import pytest

from benchmarks.localization import COLUMNS, main, recorded, replayed, row


def test_a_drive_through_the_living_room_is_localized_within_centimetres() -> None:
    recording = recorded("real3", 0)
    assert sum(scan is not None for scan in recording.scans) >= len(recording.poses) // 2
    line = dict(zip(COLUMNS, row("real3", [replayed("real3", 0, recording)]), strict=True))
    assert 0.0 < float(str(line["position RMSE [cm]"])) < 2.0
    assert float(str(line["worst [cm]"])) < 5.0
    assert line["ticks lost"] == 0


def test_it_tells_its_options(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", ["localization", "--help"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 0
    assert "--seeds" in capsys.readouterr().out
