"""Training windows and the bootstrapped training, on a small made-up world of bright bars and noise."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.detection.acf import AcfDetector
from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.pictures import list_pictures, read_picture
from han_bullet.detection.training.acf_samples import (
    box_crop,
    collect_negatives,
    estimate_lambdas,
    grid_boxes,
    person_crop,
    window_features,
)
from han_bullet.detection.training.acf_training import AcfTrainingOptions, train_acf
from han_bullet.errors import BadInputError

SMALL = AcfTrainingOptions(depth=2, trees_of_stages=(4, 32), new_negatives=60, all_negatives=90, per_photograph=15)


def blurred_noise(rng: np.random.Generator, height: int, width: int) -> np.ndarray:
    noise = rng.integers(0, 256, (height, width, 3), dtype=np.uint8)
    return np.asarray(cv2.GaussianBlur(noise, (0, 0), 2.0), np.uint8)


def draw_person(image: np.ndarray, x: int, y: int, height: int) -> None:
    """Draw a bright bar, 0.3 times as wide as high, with its upper left corner at (x, y) [px]."""
    image[y : y + height, x : x + round(0.3 * height)] = (250, 240, 120)


@pytest.fixture(scope="module")
def little_world(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("data")
    rng = np.random.default_rng(0)
    for name, count, size in (("train_pos", 40, (160, 96)), ("train_neg", 5, (200, 220))):
        (folder / "inria" / name).mkdir(parents=True)
        for number in range(count):
            image = blurred_noise(rng, *size)
            if name == "train_pos":
                draw_person(image, *rng.integers((31, 30), (38, 35)), 96)
            assert cv2.imwrite(str(folder / "inria" / name / f"{number:02d}.png"), image)
    return folder


def test_training_finds_people_never_seen_and_is_repeatable(little_world: Path, tmp_path: Path) -> None:
    lines: list[tuple[str, float]] = []
    models = [
        train_acf(little_world, tmp_path / f"{name}.npz", 3, lambda text, done: lines.append((text, done)), SMALL)
        for name in ("first", "second")
    ]
    assert np.array_equal(models[0].features, models[1].features)
    assert np.array_equal(models[0].leaves, models[1].leaves)
    assert (tmp_path / "first.npz").read_bytes() == (tmp_path / "second.npz").read_bytes()
    assert AcfModel.load(tmp_path / "first_stage1.npz").features.shape == (4, 3)
    half = [done for _, done in lines[: len(lines) // 2]]
    assert half == sorted(half)
    assert (half[0], half[-1]) == (0.0, pytest.approx(1.0, abs=0.5))
    said = [text for text, _ in lines[: len(lines) // 2] if text]
    assert said[0].startswith("40 people") and len(said) == len(set(said))  # a log without repetitions

    image = blurred_noise(np.random.default_rng(9), 220, 200)
    draw_person(image, 80, 50, 110)
    found = AcfDetector(models[0]).detect(image)
    assert found.scores[0] > 0.0
    x, y, width, height = found.boxes[0]
    assert y + height / 2 == pytest.approx(105, abs=15)  # centre of the bar [px]
    assert x + width / 2 == pytest.approx(80 + 0.15 * 110, abs=15)


def test_missing_photographs_are_bad_input(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match="neither inria/ nor INRIAPerson/Train/neg/"):
        train_acf(tmp_path, tmp_path / "model.npz", 0, lambda text, done: None)
    (tmp_path / "inria").mkdir()
    with pytest.raises(BadInputError, match="train_neg is not a folder"):
        train_acf(tmp_path, tmp_path / "model.npz", 0, lambda text, done: None)


@pytest.mark.parametrize("options", [{"trees_of_stages": ()}, {"new_negatives": 0}, {"trees_of_stages": (8, 0)}])
def test_counts_below_one_are_bad_input(options: dict[str, object]) -> None:
    with pytest.raises(BadInputError, match="at least 1"):
        AcfTrainingOptions(**options)


@pytest.mark.parametrize("depth", [9, 40])
def test_trees_deeper_than_a_model_may_have_are_bad_input(depth: int) -> None:
    with pytest.raises(BadInputError, match=f"depth of the trees is {depth}; 1 to 8 would be right"):
        AcfTrainingOptions(depth=depth)


def test_an_inria_crop_is_taken_as_it_is_and_another_size_is_bad_input(little_world: Path, tmp_path: Path) -> None:
    file = list_pictures(little_world / "inria" / "train_pos")[0]
    assert np.array_equal(person_crop(file), read_picture(file))
    assert cv2.imwrite(str(tmp_path / "other.png"), np.zeros((128, 64, 3), np.uint8))
    with pytest.raises(BadInputError, match="64 x 128 px"):
        person_crop(tmp_path / "other.png")


def test_a_box_of_the_windows_size_is_copied_with_the_border_repeated() -> None:
    image = blurred_noise(np.random.default_rng(1), 300, 300)
    crop = box_crop(image, np.array([100.0, 90.0, 39.0, 96.0]))
    assert np.array_equal(crop, image[42:234, 56:184])
    corner = box_crop(image, np.array([0.0, 0.0, 39.0, 96.0]))
    assert np.array_equal(corner[:48, :44], np.broadcast_to(image[0, 0], (48, 44, 3)))


def test_a_window_cut_at_a_detection_has_the_features_that_the_detector_saw(little_world: Path) -> None:
    rng = np.random.default_rng(2)
    image = blurred_noise(rng, 240, 240)
    # A tree on every feature: leaf 0 or 1 by the value, so that the score is a count over the features.
    features = np.repeat(rng.integers(0, 5120, 200)[:, None], 3, axis=1).astype(np.int32)
    thresholds = np.full((200, 3), 0.05, np.float32)
    leaves = np.tile(np.array([0.0, 0.0, 1.0, 1.0], np.float32), (200, 1))
    model = AcfModel(features, thresholds, leaves, (0.0, 0.1, 0.1), person_height=96, person_width=39)
    found = AcfDetector(model).scan(image)
    boxes, scores = found.boxes, found.scores
    inside = (boxes[:, 3] == 96.0) & (boxes[:, 0] > 60) & (boxes[:, 0] < 130) & (boxes[:, 1] > 60) & (boxes[:, 1] < 80)
    assert inside.sum() >= 20
    for box, score in zip(boxes[inside], scores[inside], strict=True):
        assert np.count_nonzero(window_features(box_crop(image, box))[features[:, 0]] >= 0.05) == score


@given(st.integers(1, 500), st.integers(1, 500), st.integers(1, 40))
def test_grid_boxes_lie_inside_the_image(height: int, width: int, count: int) -> None:
    boxes = grid_boxes(height, width, count)
    assert len(boxes) == (count if height >= 96 and width >= 39 else 0)
    assert np.all(boxes[:, :2] >= 0.0)
    assert np.all(boxes[:, :2] + boxes[:, 2:] <= [width, height])


def test_negatives_come_from_no_more_photographs_than_needed(little_world: Path) -> None:
    files = list_pictures(little_world / "inria" / "train_neg")
    shares: list[float] = []
    windows, used = collect_negatives(files, None, 25, 10, np.random.default_rng(0), shares.append)
    assert windows.shape == (25, 5120)
    assert used == 3 < len(files)
    assert shares == sorted(shares)


def test_colour_does_not_fade_and_directions_fade_as_their_sum_the_magnitude() -> None:
    rng = np.random.default_rng(4)
    colour, magnitude, orientation = estimate_lambdas([blurred_noise(rng, 128, 64) for _ in range(12)])
    assert colour == 0.0
    assert magnitude == pytest.approx(orientation, abs=1e-4)
    assert magnitude > 0.01  # blurred detail grows steeper as it shrinks


@pytest.mark.data
def test_lambdas_of_people_are_near_those_of_the_original(data_folder: Path) -> None:
    files = list_pictures(data_folder / "inria" / "train_pos")[::40]
    crops = [np.ascontiguousarray(person_crop(file)[16:-16, 16:-16]) for file in files]
    assert len(crops) >= 60
    assert estimate_lambdas(crops) == pytest.approx((0.0, 0.11579, 0.11579), abs=0.03)
