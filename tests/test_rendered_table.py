"""The detector on rendered sequences."""

import numpy as np
import pytest

from han_bullet.detection.evaluation import Counts
from han_bullet.detection.stages import Stages
from han_bullet.messages import Detections
from han_bullet.rendered_sequences import RenderedFrame, corridor, mbot
from han_bullet.rendered_table import SEED, evaluate_rendered

FRAMES = 20


@pytest.fixture(scope="module")
def truth() -> dict[str, list[RenderedFrame]]:
    return {name: list(sequence(FRAMES, SEED)) for name, sequence in (("corridor", corridor), ("MBOT", mbot))}


def test_a_detector_that_knows_the_truth_misses_nobody_and_one_that_knows_nothing_everybody(
    truth: dict[str, list[RenderedFrame]],
) -> None:
    answers = iter([frame for frames in truth.values() for frame in (frames[0], *frames)])  # the first one twice

    def oracle(image: np.ndarray) -> Detections:
        frame = next(answers)
        assert np.array_equal(image, frame.image)
        everybody = np.concatenate([frame.boxes, frame.ignored])
        return Detections(everybody, np.ones(len(everybody)), np.ones(len(everybody)))

    def blind(image: np.ndarray) -> Detections:
        return Detections.none()

    done: list[int] = []
    detectors = [Stages("oracle", "truth", oracle), Stages("blind", "none", blind)]
    rows = evaluate_rendered(FRAMES, detectors, done.append)
    assert [(row.images, row.detector) for row in rows] == [
        ("corridor", "oracle"),
        ("corridor", "blind"),
        ("MBOT", "oracle"),
        ("MBOT", "blind"),
    ]
    assert done == list(range(1, 2 * FRAMES + 1))
    for row in rows:
        people = sum(len(frame.boxes) for frame in truth[row.images])
        ignored = sum(len(frame.ignored) for frame in truth[row.images])
        assert people > 0
        seeing = row.detector == "oracle"
        assert row.evaluation.counts() == (Counts(people, 0, 0) if seeing else Counts(0, 0, people))
        assert row.proposals == pytest.approx((people + ignored) / FRAMES if seeing else 0.0)
