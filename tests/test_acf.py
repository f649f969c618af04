"""The ACF detector: its model file, its boxes, its agreement with the original."""

import csv
import io
import math
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.detection.acf import AcfDetector, load_acf_model
from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.pictures import read_picture
from han_bullet.errors import BadInputError


def small_model(seed: int = 1, trees: int = 6, depth: int = 2) -> AcfModel:
    """A classifier of random trees that lets some windows of noise through."""
    rng = np.random.default_rng(seed)
    features = rng.integers(0, 5120, (trees, 2**depth - 1)).astype(np.int32)
    thresholds = np.where(features % 10 < 3, 0.4, 0.02).astype(np.float32)
    leaves = rng.normal(0.0, 0.7, (trees, 2**depth)).astype(np.float32)
    return AcfModel(features, thresholds, leaves, (0.0, 0.11, 0.11))


def noise(seed: int = 0, height: int = 200, width: int = 260) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)


@pytest.mark.parametrize("depth", [1, 2, 5])
def test_a_saved_model_comes_back_bit_for_bit(tmp_path: Path, depth: int) -> None:
    model = replace(small_model(depth=depth), score_threshold=12.5)
    assert model.depth == depth
    model.save(tmp_path / "model.npz")
    loaded = AcfModel.load(tmp_path / "model.npz")
    assert np.array_equal(loaded.features, model.features)
    assert np.array_equal(loaded.thresholds, model.thresholds)
    assert np.array_equal(loaded.leaves, model.leaves)
    assert replace(loaded, features=model.features, thresholds=model.thresholds, leaves=model.leaves) == model


def test_a_file_of_the_first_version_is_a_model_with_plain_cells(tmp_path: Path) -> None:
    small_model().save(tmp_path / "model.npz")
    with np.load(tmp_path / "model.npz") as archive:
        arrays = {name: archive[name] for name in archive.files}
    assert "filters" not in arrays
    for name in ("cell", "padding_height", "padding_width", "rough"):
        del arrays[name]
    np.savez(tmp_path / "old.npz", **arrays)
    old, new = AcfModel.load(tmp_path / "old.npz"), AcfModel.load(tmp_path / "model.npz")
    assert (old.cell, old.padding_height, old.padding_width, old.filters, old.rough) == (4, 16, 12, None, False)
    assert replace(old, features=new.features, thresholds=new.thresholds, leaves=new.leaves) == new
    assert np.array_equal(old.features, new.features)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 no archive", b"\x93NUMPY", b"plain text"])
def test_a_malformed_file_is_bad_input(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "model.npz").write_bytes(content)
    with pytest.raises(BadInputError, match="is not an ACF model"):
        AcfModel.load(tmp_path / "model.npz")


def test_a_file_with_pickled_objects_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "model.npz", features=np.array([{"a": 1}], dtype=object), lambdas=np.zeros(3))
    with pytest.raises(BadInputError, match="features holds values of type object, numbers would be right") as caught:
        AcfModel.load(tmp_path / "model.npz")
    assert "allow_pickle" not in str(caught.value)


def with_values(path: Path, **values: object) -> Path:
    """Write a model's file in which some values are others."""
    small_model().save(path)
    with np.load(path) as archive:
        np.savez(path, **{**archive, **values})
    return path


@pytest.mark.parametrize(
    ("name", "value"),
    [("cell", math.inf), ("cell", math.nan), ("person_height", -math.inf), ("window_width", np.ones(2))],
)
def test_a_size_that_is_no_whole_number_is_bad_input(tmp_path: Path, name: str, value: object) -> None:
    with pytest.raises(BadInputError, match=r"model\.npz is not an ACF model"):
        AcfModel.load(with_values(tmp_path / "model.npz", **{name: value}))


def with_member(path: Path, name: str, shape: tuple[int, ...]) -> Path:
    """Write a model's file with one more member, whose header claims a shape of doubles that are not there."""
    small_model().save(path)
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": shape})
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(f"{name}.npy", header.getvalue() + bytes(80))
    return path


@pytest.mark.parametrize("shape", [(10**15,), (11,), (9,), (-1,), (10**9, 10**9, 10**9)])
def test_a_header_that_claims_other_than_the_member_holds_is_bad_input(tmp_path: Path, shape: tuple[int, ...]) -> None:
    path = with_member(tmp_path / "model.npz", "filters", shape)
    with pytest.raises(BadInputError, match=r"filters claims shape \(.*but holds 80 bytes"):
        AcfModel.load(path)


def test_what_is_not_of_a_model_is_not_read(tmp_path: Path) -> None:
    path = with_member(tmp_path / "model.npz", "surprise", (10**15,))
    assert np.array_equal(AcfModel.load(path).leaves, small_model().leaves)


REAL = Path(__file__).parent.parent / "han_bullet" / "models" / "acf_inria.npz"


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(0, 8 * REAL.stat().st_size - 1), min_size=1, max_size=4, unique=True))
def test_a_real_file_with_flipped_bits_is_bad_input_or_the_same_model(
    tmp_path_factory: pytest.TempPathFactory, bits: list[int]
) -> None:
    content = bytearray(REAL.read_bytes())
    for bit in bits:
        content[bit // 8] ^= 1 << bit % 8
    path = tmp_path_factory.mktemp("flipped") / "model.npz"
    path.write_bytes(content)
    try:
        model = AcfModel.load(path)
    except BadInputError as error:
        assert "\n" not in str(error)
        return
    for name in ("features", "thresholds", "leaves"):  # each member has a checksum
        assert np.array_equal(getattr(model, name), getattr(load_acf_model(REAL), name))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("features", np.full((6, 3), 5120, np.int32)),
        ("features", np.full((6, 3), -1, np.int32)),
        ("features", np.zeros((5, 3), np.int32)),
        ("features", np.int32(0)),
        ("features", np.zeros((6, 7), np.int32)),
        ("leaves", np.zeros((6, 8), np.float32)),
        ("thresholds", np.full((6, 3), np.nan, np.float32)),
        ("leaves", np.full((6, 4), np.nan, np.float32)),
        ("lambdas", (0.0, 0.1)),
        ("lambdas", (0.0, math.inf, 0.1)),
        ("window_height", 130),
        ("window_height", 4000),
        ("cell", 3),
        ("cell", 0),
        ("padding_height", 15),
        ("padding_width", -4),
        ("filters", np.zeros((4, 5, 5, 9), np.float32)),
        ("filters", np.zeros((4, 4, 5, 10), np.float32)),
        ("filters", np.zeros((5, 10), np.float32)),
        ("filters", np.full((1, 5, 5, 10), np.nan, np.float32)),
        ("person_height", 0),
        ("cascade_threshold", math.nan),
        ("score_threshold", math.nan),
    ],
)
def test_a_model_that_makes_no_sense_is_bad_input(name: str, value: object) -> None:
    with pytest.raises(BadInputError, match="ACF model"):
        replace(small_model(), **{name: value})


def test_a_calibration_is_added_to_every_leaf_of_a_model_of_ours(tmp_path: Path) -> None:
    small_model().save(tmp_path / "model.npz")
    model = load_acf_model(tmp_path / "model.npz", calibration=0.25)
    assert model.leaves == pytest.approx(small_model().leaves + 0.25)
    with pytest.raises(BadInputError, match="calibration is nan"):
        load_acf_model(tmp_path / "model.npz", calibration=math.nan)


def test_an_unknown_name_tells_which_models_there_are() -> None:
    with pytest.raises(BadInputError, match=r"'acf_of_dreams' is neither a file nor one of the shipped: acf_inria"):
        load_acf_model("acf_of_dreams")


def test_default_and_the_name_of_the_shipped_model_and_its_path_are_the_same_model() -> None:
    path = Path(__file__).parent.parent / "han_bullet" / "models" / "acf_inria.npz"
    models = [load_acf_model(), load_acf_model("default"), load_acf_model("acf_inria"), load_acf_model(path)]
    assert all(np.array_equal(model.leaves, models[0].leaves) for model in models)


def test_saving_that_fails_leaves_the_old_model_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "model.npz"
    small_model(1).save(path)
    before = path.read_bytes()

    def half(self: Path, content: bytes) -> int:
        with self.open("wb") as file:
            file.write(content[:100])
        raise OSError("disk full")

    monkeypatch.setattr(Path, "write_bytes", half)
    with pytest.raises(OSError, match="disk full"):
        small_model(2).save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_the_shipped_model_is_small_and_has_a_threshold_and_a_card() -> None:
    model = load_acf_model("acf_inria")
    assert model.features.shape == (2048, 7)
    assert math.isfinite(model.score_threshold)
    folder = Path(__file__).parent.parent / "han_bullet" / "models"
    assert (folder / "acf_inria.npz").stat().st_size < 500_000
    card = (folder / "acf_inria.md").read_text(encoding="utf-8")
    assert f"`score_threshold` is {model.score_threshold:.2f}" in card
    assert f"{len(model.features)} depth-{model.depth} trees" in card
    assert f"person {model.person_height} x {model.person_width} px" in card
    assert f"gives up at {model.cascade_threshold}" in card


def test_boxes_come_by_falling_score_with_the_persons_shape() -> None:
    found = AcfDetector(small_model()).detect(noise())
    boxes, scores = found.boxes, found.scores
    assert len(boxes) == len(scores) > 3
    assert found.probabilities.tolist() == [1.0] * len(boxes)
    assert boxes.dtype == scores.dtype == np.float64
    assert np.all(np.diff(scores) <= 0.0)
    assert boxes[:, 2] / boxes[:, 3] == pytest.approx(np.full(len(boxes), 0.41))
    assert boxes[:, 3].min() >= 100.0 - 1e-9


@pytest.mark.parametrize("depth", [1, 3, 5])
def test_trees_of_another_depth_find_boxes_too(depth: int) -> None:
    found = AcfDetector(small_model(depth=depth)).detect(noise())
    assert len(found.boxes) == len(found.scores) > 3


def test_a_model_with_filters_finds_boxes_and_comes_back_from_its_file(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    plain = small_model(depth=3)
    model = replace(
        plain,
        filters=rng.normal(0.0, 0.3, (4, 5, 5, 10)).astype(np.float32),
        features=rng.integers(0, 20480, plain.features.shape).astype(np.int32),
        cell=2,
        padding_height=14,
        rough=True,
    )
    model.save(tmp_path / "model.npz")
    results = [AcfDetector(each).detect(noise(1)) for each in (model, AcfModel.load(tmp_path / "model.npz"))]
    assert len(results[0].boxes) > 3
    assert np.array_equal(results[0].boxes, results[1].boxes)
    assert np.array_equal(results[0].scores, results[1].scores)


def test_the_same_image_gives_the_same_boxes_bit_for_bit() -> None:
    first, second = (AcfDetector(small_model()).detect(noise(3)) for _ in range(2))
    assert np.array_equal(first.boxes, second.boxes)
    assert np.array_equal(first.scores, second.scores)


@pytest.mark.parametrize("shape", [(0, 0), (99, 300), (300, 40), (1, 1)])
def test_an_image_smaller_than_a_person_holds_nobody(shape: tuple[int, int]) -> None:
    found = AcfDetector(small_model()).detect(np.zeros((*shape, 3), np.uint8))
    assert found.boxes.shape == (0, 4)
    assert found.scores.shape == found.probabilities.shape == (0,)


@pytest.mark.parametrize(
    "image", [np.zeros((200, 200), np.uint8), np.zeros((200, 200, 4), np.uint8), np.zeros((9, 9, 3))]
)
def test_an_array_that_is_no_rgb_image_is_bad_input(image: np.ndarray) -> None:
    with pytest.raises(BadInputError, match=r"must be \(h, w, 3\) and uint8"):
        AcfDetector(small_model()).detect(image)


def test_a_mat_file_is_read_as_a_model_of_the_toolbox(tmp_path: Path) -> None:
    (tmp_path / "model.mat").write_bytes(b"MATLAB 5.0 MAT-file, but not really")
    with pytest.raises(BadInputError, match="toolbox"):
        load_acf_model(tmp_path / "model.mat")


@pytest.mark.data
def test_the_toolbox_s_model_is_loaded_by_its_path_with_the_paper_s_threshold(data_folder: Path) -> None:
    model = load_acf_model(str(data_folder / "models" / "AcfInriaDetector.mat"))
    assert model.features.shape == (2048, 3)
    assert model.score_threshold == 40.0


@pytest.mark.data
def test_a_calibration_of_the_reader_s_own_moves_leaves_and_threshold(data_folder: Path) -> None:
    path = data_folder / "models" / "AcfInriaDetector.mat"
    usual, plain = load_acf_model(path), load_acf_model(path, calibration=0.0)
    assert usual.leaves - plain.leaves == pytest.approx(np.full((2048, 4), 0.01), abs=1e-7)
    assert plain.score_threshold == pytest.approx(40.0 - 20.48)


@pytest.mark.data
def test_filtered_channels_are_loaded_without_calibration_and_threshold(data_folder: Path, tmp_path: Path) -> None:
    model = load_acf_model(data_folder / "models" / "LdcfInriaDetector.mat")
    assert (model.depth, model.cell, model.window_cell, model.window_channels) == (3, 2, 4, 40)
    assert (model.padding_height, model.padding_width) == (14, 12)
    assert model.score_threshold == -math.inf
    shifted = load_acf_model(data_folder / "models" / "LdcfInriaDetector.mat", calibration=0.5)
    assert shifted.leaves == pytest.approx(model.leaves + 0.5)
    model.save(tmp_path / "ldcf.npz")
    again = load_acf_model(tmp_path / "ldcf.npz")
    assert np.array_equal(again.filters, model.filters)
    arrays = {name: getattr(model, name) for name in ("features", "thresholds", "leaves", "filters")}
    assert replace(again, **arrays) == model


@pytest.mark.data
@pytest.mark.parametrize("name", ["photo", "rendering"])
def test_the_originals_model_finds_the_originals_boxes(data_folder: Path, name: str) -> None:
    folder = data_folder.parent / "reference" / "acf"
    if not folder.is_dir():
        pytest.skip(f"no reference boxes of the original detector in {folder}")
    expected = np.load(folder / f"{name}.npz")["boxes"]
    detector = AcfDetector(load_acf_model(data_folder / "models" / "AcfInriaDetector.mat"))
    found = detector.detect(read_picture(folder / f"{name}.png"))
    assert len(found.boxes) == len(expected) > 0
    for box in expected:
        nearest = np.abs(found.boxes - box[:4]).max(axis=1).argmin()
        assert found.boxes[nearest] == pytest.approx(box[:4], abs=1e-6)
        assert found.scores[nearest] == pytest.approx(box[4], abs=1.0)  # of 2048 votes of .2


@pytest.mark.data
@pytest.mark.parametrize(
    ("model", "reference", "photographs", "least"),
    [("AcfInriaDetector", "inria_test_boxes", 60, 300), ("LdcfInriaDetector", "inria_test_boxes_ldcf", 20, 40)],
)
def test_boxes_on_photographs_are_those_of_the_original(
    data_folder: Path, model: str, reference: str, photographs: int, least: int
) -> None:
    file = data_folder.parent / "reference" / "acf" / f"{reference}.csv"
    if not file.is_file():
        pytest.skip(f"no reference boxes of the original detector in {file}")
    rows = list(csv.DictReader(file.open(encoding="utf-8")))
    detector = AcfDetector(load_acf_model(data_folder / "models" / f"{model}.mat"))
    differences, boxes_expected = [], 0
    for image in sorted({row["image"] for row in rows})[:photographs]:
        found = detector.detect(read_picture(data_folder / "inria" / "test" / image))
        expected = [
            [float(row[key]) for key in ("x", "y", "width", "height", "score")] for row in rows if row["image"] == image
        ]
        boxes_expected += len(expected)
        for box in expected:
            same = np.abs(found.boxes - box[:4]).max(axis=1) < 0.01
            differences.extend(np.abs(found.scores[same] - box[4]))
    assert boxes_expected >= least
    assert np.count_nonzero(np.array(differences) < 2.0) >= 0.98 * boxes_expected
    assert np.median(differences) < 1e-4
