"""The figures of the stages and the choice of a threshold, on a few drawn pictures of upright bars."""

import json
import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from han_bullet.detection import staged_image
from han_bullet.detection.acf import load_acf_model
from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.cnn import Classifier
from han_bullet.detection.evaluation import Counts
from han_bullet.detection.inria import load_test_photographs
from han_bullet.detection.loading import load_detector
from han_bullet.detection.stages import Stages, load_stages
from han_bullet.detector_figures import FiguresRow
from han_bullet.errors import BadInputError
from han_bullet.inria_table import choose_threshold, evaluate_photographs
from han_bullet.messages import Detections

BAR = (24, 92)  # width and height [px]
BRIGHT, GREY = 240, 75
PICTURES = 4
LEFT, TOP = 60, 70  # of the person in each picture [px]


def bar_model() -> AcfModel:
    """Return a hand-made model without a score threshold, which finds upright bars, bright ones with a higher score.

    Each tree asks whether a place in the middle of the window is light and one beside, above or below it dark: +5 each,
    and 5 trees more ask the same of a very light middle. L is the first channel.
    """
    places = [(16, 8), (6, 8), (26, 8), (11, 8), (21, 8)]
    margins = [(16, 2), (16, 13), (1, 8), (30, 8), (8, 2)]
    index = np.array([[(row * 16 + column) * 10 for row, column in pair] for pair in zip(places, margins, strict=True)])
    features = np.stack([index[:, 0], index[:, 1], index[:, 1]], axis=1).astype(np.int32)
    features = np.concatenate([features, features])
    light, very_light = (np.tile(np.float32([middle, 0.1, 0.1]), (5, 1)) for middle in (0.12, 0.25))
    leaves = [np.tile(np.float32([other, other, 5.0, -10.0]), (5, 1)) for other in (-10.0, 0.0)]
    return AcfModel(features, np.concatenate([light, very_light]), np.concatenate(leaves), lambdas=(0.0, 0.1, 0.1))


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with pictures of a bright bar, the person, and a grey one, which is nobody."""
    folder = tmp_path_factory.mktemp("data")
    (folder / "inria" / "test").mkdir(parents=True)
    labels = {}
    for number in range(PICTURES):
        image = np.full((240, 320, 3), 10, np.uint8)
        for left, level in ((LEFT, BRIGHT), (LEFT + 144, GREY)):
            image[TOP : TOP + BAR[1], left : left + BAR[0]] = level
        assert cv2.imwrite(str(folder / "inria" / "test" / f"{number}.png"), image)
        labels[f"{number}.png"] = {"boxes_xyxy": [[LEFT, TOP, LEFT + BAR[0], TOP + BAR[1]]]}
    (folder / "inria" / "gt.json").write_text(json.dumps(labels), encoding="utf-8")
    return folder


@pytest.fixture
def fresh(tmp_path: Path) -> str:
    """Return the file of a model without a score threshold, as `train acf` leaves it."""
    model = bar_model()
    assert model.score_threshold == -math.inf
    model.save(tmp_path / "fresh.npz")
    return str(tmp_path / "fresh.npz")


def table(data: Path, model: str) -> list[FiguresRow]:
    return evaluate_photographs(load_test_photographs(data), load_stages([model], "default"))


def test_a_fresh_model_gets_a_threshold_that_leaves_the_false_positives_allowed_and_is_usable(
    data: Path, fresh: str, tmp_path: Path
) -> None:
    chosen = choose_threshold(load_test_photographs(data), fresh)
    assert chosen.score_threshold == 50.0  # that of bright bars; grey ones have less
    assert np.array_equal(chosen.leaves, load_acf_model(fresh).leaves)
    chosen.save(tmp_path / "chosen.npz")
    assert load_detector(tmp_path / "chosen.npz", classifier=None).threshold == chosen.score_threshold
    above = table(data, str(tmp_path / "chosen.npz"))[1]
    assert (above.threshold, above.evaluation.counts()) == (50.0, Counts(PICTURES, 0, 0))


def test_a_threshold_can_be_chosen_anew_for_a_model_that_has_one(data: Path, fresh: str, tmp_path: Path) -> None:
    load_acf_model(fresh).with_score_threshold(49.5).save(tmp_path / "high.npz")
    path = str(tmp_path / "high.npz")
    assert (
        choose_threshold(load_test_photographs(data), path).score_threshold
        == choose_threshold(load_test_photographs(data), fresh).score_threshold
    )


def test_a_model_without_a_threshold_is_evaluated_on_all_proposals(data: Path, fresh: str) -> None:
    done: list[int] = []
    photographs = load_test_photographs(data)
    (stages,) = load_stages([fresh], "default")
    made_up = replace(stages, classifier=LeftClassifier(Clock()))
    alone, both, mixed = evaluate_photographs(photographs, [made_up], done.append)
    assert (alone.detector, alone.model, alone.rule, alone.threshold) == ("ACF", "fresh", "-", None)
    assert (both.detector, both.model, both.rule, both.threshold) == ("ACF + CNN", "fresh", "paper rule", None)
    assert (mixed.detector, mixed.model, mixed.rule, mixed.threshold) == ("ACF + CNN", "fresh", "both scores", None)
    assert mixed.evaluation.counts() == alone.evaluation.counts()  # it drops nothing
    assert alone.evaluation.counts() == Counts(PICTURES, 3 * PICTURES, 0)  # a second box of each bar
    assert both.evaluation.counts() == Counts(PICTURES, PICTURES, 0)  # grey bars are on the right
    assert done == [1, 2, 3, 4]


def test_a_model_with_a_threshold_is_evaluated_on_all_proposals_and_on_those_above_it(
    data: Path, fresh: str, tmp_path: Path
) -> None:
    load_acf_model(fresh).with_score_threshold(45.0).save(tmp_path / "model.npz")
    rows = table(data, str(tmp_path / "model.npz"))
    assert [(row.detector, row.rule, row.threshold) for row in rows] == [
        ("ACF", "-", None),
        ("ACF", "-", 45.0),
        ("ACF + CNN", "paper rule", None),
        ("ACF + CNN", "paper rule", 45.0),
        ("ACF + CNN", "both scores", None),
        ("ACF + CNN", "both scores", 45.0),
    ]
    assert [row.evaluation.counts().false_positives for row in rows[:2]] == [3 * PICTURES, 0]


def test_several_models_stand_in_one_table_with_the_same_figures_as_alone(
    data: Path, fresh: str, tmp_path: Path
) -> None:
    load_acf_model(fresh).with_score_threshold(45.0).save(tmp_path / "other.npz")
    other = str(tmp_path / "other.npz")
    together = evaluate_photographs(load_test_photographs(data), load_stages([fresh, other], "default"))
    assert [row.model for row in together] == ["fresh"] * 3 + ["other"] * 6
    alone = [*table(data, fresh), *table(data, other)]
    assert [row.evaluation.counts() for row in together] == [row.evaluation.counts() for row in alone]


class Clock:
    """Time that passes only when a stage works [s]."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


class MadeUpClassifier(Classifier):
    """Takes 4 s per proposal, keeps those in the upper half of the picture."""

    def __init__(self, clock: Clock) -> None:
        self.least_probability = 0.5
        self.clock = clock

    def probabilities(self, image: np.ndarray, boxes: np.ndarray) -> np.ndarray:
        self.clock.now += 4.0 * len(boxes)
        return (boxes[:, 1] < 0.5 * image.shape[0]).astype(float)


class LeftClassifier(MadeUpClassifier):
    """Keeps those in the left half of the picture, where the people are."""

    def probabilities(self, image: np.ndarray, boxes: np.ndarray) -> np.ndarray:
        return (boxes[:, 0] < 0.5 * image.shape[1]).astype(float)


def test_rows_derive_from_one_look_with_the_time_of_the_proposals_that_reach_the_network(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = Clock()
    monkeypatch.setattr(staged_image, "perf_counter", clock)

    def propose(image: np.ndarray) -> Detections:
        """Return the person and nine boxes elsewhere, one of them with a high score and in the lower half."""
        clock.now += 10.0
        boxes = np.tile([LEFT + 200.0, 100.0, 40.0, 100.0], (10, 1))
        boxes[0] = (LEFT - 6.0, TOP, 36.0, BAR[1])
        boxes[1, 1] = 130.0
        return Detections(boxes, np.array([90.0, 80.0, *range(7, -1, -1)]), np.ones(10))

    stages = Stages("ACF", "made up", propose, 50.0, MadeUpClassifier(clock))
    rows = evaluate_photographs(load_test_photographs(data), [stages])
    counts = [row.evaluation.counts() for row in rows]
    assert counts == [Counts(PICTURES, false * PICTURES, 0) for false in (9, 1, 8, 0, 9, 1)]
    seconds = [1.0 / row.frames_per_second for row in rows]
    assert seconds == pytest.approx([10.0, 10.0, *2 * [10.0 + 10 * 4.0, 10.0 + 2 * 4.0]])


def test_an_unknown_model_and_missing_data_are_bad_input(data: Path, fresh: str, tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match="acf_nowhere"):
        choose_threshold(load_test_photographs(data), "acf_nowhere")
    with pytest.raises(BadInputError, match="cnn_nowhere"):
        load_stages([fresh], "cnn_nowhere")
    with pytest.raises(BadInputError, match="neither inria/"):
        load_test_photographs(tmp_path / "..")


def test_detectors_of_one_stage_load_no_classifier() -> None:
    (stages,) = load_stages(["hog"], "cnn_nowhere")
    assert (stages.kind, stages.classifier) == ("HOG", None)


@pytest.mark.data
def test_the_toolbox_s_model_can_be_evaluated_by_its_path(data_folder: Path, data: Path) -> None:
    rows = table(data, str(data_folder / "models" / "AcfInriaDetector.mat"))
    assert [row.threshold for row in rows] == 3 * [None, 40.0]
