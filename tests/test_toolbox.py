"""Detectors of the toolbox as models of ours; broken and hostile ones as one clear sentence."""

import copy
import io
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from han_bullet.detection.acf import AcfDetector
from han_bullet.detection.toolbox import load_toolbox_model
from han_bullet.errors import BadInputError

# Trees by columns: a whole one of depth 2, one with an early leaf on its left, one with a single branch.
CHILD = np.array([[2, 2, 2], [4, 0, 0], [6, 4, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]], np.uint32)
FEATURES = np.array([[0, 5119, 512], [31, 7, 7], [32, 3, 7], [7, 7, 7], [7, 7, 7], [7, 7, 7], [7, 7, 7]], np.uint32)
THRESHOLDS = np.linspace(0.1, 0.7, 21, dtype=np.float32).reshape(7, 3)
SCORES = np.arange(21, dtype=np.float32).reshape(7, 3)


def toolbox_detector() -> dict[str, Any]:
    """What savemat makes a detector file of."""
    channels = {
        "shrink": 4,
        "pColor": {"enabled": 1, "smooth": 1, "colorSpace": "luv"},
        "pGradMag": {"enabled": 1, "colorChn": 0, "normRad": 5, "normConst": 0.005, "full": 0},
        "pGradHist": {"enabled": 1, "nOrients": 6, "softBin": 0, "useHog": 0, "binSize": np.empty((0, 0))},
        "pCustom": np.empty((0, 0)),
    }
    pyramid = {
        "pChns": channels,
        "nPerOct": 8,
        "nOctUp": 0,
        "nApprox": 7,
        "lambdas": np.array([[0.0, 0.1, 0.2]]),
        "pad": np.array([[16, 12]]),
        "smooth": 1,
    }
    options = {
        "pPyramid": pyramid,
        "filters": np.empty((0, 0)),
        "modelDs": np.array([[100, 41]]),
        "modelDsPad": np.array([[128, 64]]),
        "pNms": {"type": "maxg", "overlap": 0.65, "ovrDnm": "min"},
        "stride": 4,
        "cascThr": -1.0,
    }
    tables = {"fids": FEATURES, "thrs": THRESHOLDS, "child": CHILD, "hs": SCORES}
    return {"clf": {name: table.copy() for name, table in tables.items()}, "opts": options}


def write(path: Path, detector: object) -> Path:
    savemat(path, {"detector": detector})
    return path


def changed(path: str, value: object) -> dict[str, Any]:
    """A detector with one value changed; without it where the value is None."""
    detector = copy.deepcopy(toolbox_detector())
    *folders, name = path.split(".")
    place = detector
    for folder in folders:
        place = place[folder]
    if value is None:
        del place[name]
    else:
        place[name] = value
    return detector


def table(original: np.ndarray, place: tuple[int, int], value: float) -> np.ndarray:
    values = original.astype(np.float64)
    values[place] = value
    return values


def test_trees_are_completed_by_repeating_the_leaf_above(tmp_path: Path) -> None:
    model = load_toolbox_model(write(tmp_path / "detector.mat", toolbox_detector()), calibration=0.0)
    assert model.leaves.tolist() == [[9, 12, 15, 18], [4, 4, 10, 13], [5, 5, 8, 8]]
    assert model.thresholds == pytest.approx(
        np.array(
            [
                [THRESHOLDS[0, 0], THRESHOLDS[1, 0], THRESHOLDS[2, 0]],
                [THRESHOLDS[0, 1], 0, THRESHOLDS[2, 1]],
                [THRESHOLDS[0, 2], 0, 0],
            ]
        )
    )
    # Of (channel, column, row) with 16 columns and 32 rows: 31 is row 31, 32 column 1, 512 channel 1, 5119 the last.
    assert model.features.tolist() == [[0, 31 * 16 * 10, 10], [5119, 0, 3 * 16 * 10], [1, 0, 0]]
    assert (model.lambdas, model.cascade_threshold, model.rough) == ((0.0, 0.1, 0.2), -1.0, True)


def test_the_calibration_is_that_of_the_demo_unless_another_is_given(tmp_path: Path) -> None:
    path = write(tmp_path / "detector.mat", toolbox_detector())
    assert load_toolbox_model(path).leaves[0] == pytest.approx([9.01, 12.01, 15.01, 18.01])


def test_the_threshold_of_the_paper_is_for_models_like_the_toolbox_s_inria_model_alone(tmp_path: Path) -> None:
    inria = toolbox_detector()
    inria["clf"] = {name: np.tile(values[:, :1], 2048) for name, values in inria["clf"].items()}
    path = write(tmp_path / "inria.mat", inria)
    assert load_toolbox_model(path).score_threshold == 40.0
    assert load_toolbox_model(path, 0.05).score_threshold == pytest.approx(40.0 + 2048 * 0.04)
    inria["opts"]["modelDs"] = np.array([[50, 20]])
    assert load_toolbox_model(write(tmp_path / "low.mat", inria)).score_threshold == -math.inf
    assert load_toolbox_model(write(tmp_path / "few.mat", toolbox_detector())).score_threshold == -math.inf


def test_filters_come_with_smaller_cells_and_no_calibration(tmp_path: Path) -> None:
    detector = changed("opts.filters", np.arange(5 * 5 * 10 * 4, dtype=np.float32).reshape(5, 5, 10, 4))
    detector["opts"]["pPyramid"]["pChns"]["shrink"] = 2
    detector["opts"]["pPyramid"]["pad"] = np.array([[14, 12]])
    detector["clf"]["fids"] = table(FEATURES, (0, 0), 20479)
    model = load_toolbox_model(write(tmp_path / "detector.mat", detector))
    assert model.filters is not None
    assert model.filters.shape == (4, 5, 5, 10)
    assert model.filters[3, 1, 2, 7] == 1 * 200 + 2 * 40 + 7 * 4 + 3
    assert (model.cell, model.window_cell, model.padding_height) == (2, 4, 14)
    assert model.features[0, 0] == 20479
    assert model.leaves[0].tolist() == [9, 12, 15, 18]
    assert model.score_threshold == -math.inf


@pytest.mark.parametrize(
    ("path", "value", "reason"),
    [
        ("clf", None, "it has no detector.clf"),
        ("clf", 3.0, "it has no child"),
        ("clf.hs", None, "it has no hs"),
        ("clf.hs", "text", "its hs is no table of numbers"),
        ("clf.hs", SCORES[:, :2], "must have one shape"),
        ("clf.hs", table(SCORES, (3, 0), math.nan), "must be finite"),
        ("clf.hs", table(SCORES, (3, 0), 1e300), "must be finite"),
        ("clf.thrs", table(THRESHOLDS, (1, 0), math.inf), "must be finite"),
        ("clf.thrs", np.array([[{"a": 1}]], dtype=object), "its thrs is no table of numbers"),
        ("clf.fids", table(FEATURES, (0, 0), 5120), "feature 5120 of 5120"),
        ("clf.fids", table(FEATURES, (0, 0), -1), "whole numbers from 0 on"),
        ("clf.fids", table(FEATURES, (0, 0), 0.5), "whole numbers from 0 on"),
        ("clf.fids", table(FEATURES, (0, 0), math.nan), "whole numbers from 0 on"),
        ("clf.fids", table(FEATURES, (0, 0), 1e18), "whole numbers from 0 on"),
        ("clf.child", table(CHILD, (1, 0), 2), "turn in a circle"),
        ("clf.child", table(CHILD, (1, 0), 1), "children that are none of them"),
        ("clf.child", table(CHILD, (1, 0), 7), "children that are none of them"),
        ("clf.child", table(CHILD, (1, 0), 1e9), "children that are none of them"),
        ("clf.child", table(CHILD, (1, 0), -2), "children that are none of them"),
        ("clf.child", table(CHILD, (1, 0), 2.5), "children that are none of them"),
        ("clf.child", table(CHILD, (1, 0), math.nan), "children that are none of them"),
        ("clf.child", np.zeros((7, 3)), "none of its trees has a branch"),
        ("opts.modelDs", np.array([[200, 41]]), "must fit the window"),
        ("opts.modelDs", np.array([[0, 0]]), "must fit the window"),
        ("opts.modelDs", np.array([[100]]), "modelDs must be 2 numbers"),
        ("opts.modelDsPad", np.array([[1e9, 64]]), "modelDsPad is"),
        ("opts.modelDsPad", np.array([[math.nan, 64]]), "modelDsPad is"),
        ("opts.modelDsPad", "luv", "modelDsPad must be 2 numbers"),
        ("opts.pPyramid.pad", np.array([[15, 12]]), "whole cells"),
        ("opts.pPyramid.lambdas", np.empty((0, 0)), "lambdas must be 3 numbers"),
        ("opts.pPyramid.lambdas", np.array([[0.0, math.nan, 0.1]]), "must be finite"),
        ("opts.pPyramid.nPerOct", 4, "nPerOct is not 8"),
        ("opts.pPyramid.pChns.shrink", 2, "windows lie 4 px apart"),
        ("opts.pPyramid.pChns.shrink", 0, "windows lie 4 px apart"),
        ("opts.pPyramid.pChns.pColor.colorSpace", "rgb", "colorSpace is not luv"),
        ("opts.pPyramid.pChns.pGradHist.softBin", 1, "softBin is not 0"),
        ("opts.pPyramid.pChns.pCustom", np.array([[1.0]]), "pCustom"),
        ("opts.stride", 8, "windows lie 8 px apart"),
        ("opts.cascThr", math.nan, "must be finite"),
        ("opts.filters", "text", "its filters are no numbers"),
        ("opts.filters", np.zeros((5, 5)), r"its filters have shape \(5, 5\)"),
    ],
)
def test_a_detector_that_makes_no_sense_is_bad_input(tmp_path: Path, path: str, value: object, reason: str) -> None:
    file = write(tmp_path / "detector.mat", changed(path, value))
    with pytest.raises(BadInputError, match=reason) as caught:
        load_toolbox_model(file)
    assert str(caught.value).startswith(f"{file} is not an ACF or LDCF detector of the toolbox: ")


@pytest.mark.parametrize("content", [b"", b"MATLAB 5.0 MAT-file, but not really", b"\x89HDF\r\n\x1a\n" + bytes(200)])
def test_a_file_of_another_kind_is_bad_input(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "model.mat").write_bytes(content)
    with pytest.raises(BadInputError, match="is not an ACF or LDCF detector of the toolbox"):
        load_toolbox_model(tmp_path / "model.mat")


def test_a_file_without_a_detector_and_a_missing_file_are_bad_input(tmp_path: Path) -> None:
    savemat(tmp_path / "other.mat", {"x": 1.0})
    with pytest.raises(BadInputError, match="it has no detector"):
        load_toolbox_model(tmp_path / "other.mat")
    with pytest.raises(BadInputError, match="No such file"):
        load_toolbox_model(tmp_path / "missing.mat")


def whole_file() -> bytes:
    stream = io.BytesIO()
    savemat(stream, {"detector": toolbox_detector()})
    return stream.getvalue()


WHOLE = whole_file()


@settings(max_examples=400, deadline=None)
@given(st.lists(st.tuples(st.integers(120, len(WHOLE) - 1), st.integers(0, 255)), min_size=1, max_size=5))
def test_changed_bytes_give_a_sound_model_or_one_sentence(
    tmp_path_factory: pytest.TempPathFactory, changes: list[tuple[int, int]]
) -> None:
    content = bytearray(WHOLE)
    for place, byte in changes:
        content[place] = byte
    path = tmp_path_factory.getbasetemp() / "changed.mat"
    path.write_bytes(content)
    try:
        model = load_toolbox_model(path)
    except BadInputError as error:
        assert "\n" not in str(error)
    else:
        found = AcfDetector(model).detect(np.full((130, 70, 3), 128, np.uint8))
        assert len(found.boxes) == len(found.scores)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, len(WHOLE) - 1))
def test_a_file_cut_short_is_bad_input(tmp_path_factory: pytest.TempPathFactory, length: int) -> None:
    path = tmp_path_factory.getbasetemp() / "short.mat"
    path.write_bytes(WHOLE[:length])
    with pytest.raises(BadInputError, match="toolbox"):
        load_toolbox_model(path)
