"""A detector taken apart into its two stages, so that each can be measured."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from han_bullet.detection.acf import AcfDetector, load_acf_model
from han_bullet.detection.cnn import Classifier, load_classifier
from han_bullet.detection.evaluation import Detect
from han_bullet.detection.loading import load_detector
from han_bullet.detection.model_files import HOG, is_hog, is_network, model_name

LEAST_HOG_SCORE, LEAST_NETWORK_PROBABILITY = -0.5, 0.01  # low, so that curves reach one false positive per image


@dataclass(frozen=True)
class Stages:
    """A first stage that proposes and a second that decides.

    Attributes:
        kind: Of the first stage, such as "ACF".
        model: Of the first stage: its name, or what was given where names repeat.
        propose: The first stage, without a threshold.
        threshold: Least score of a proposal that it recommends; None if it has none.
        classifier: The second stage; None for a detector without one.
    """

    kind: str
    model: str
    propose: Detect
    threshold: float | None = None
    classifier: Classifier | None = None

    @property
    def thresholds(self) -> tuple[float | None, ...]:
        """Return those that figures are given for: None, all proposals, and the recommended one where there is one."""
        return (None,) if self.threshold is None else (None, self.threshold)


def load_stages(models: Sequence[str], classifier: str) -> list[Stages]:
    """Return the detectors to measure.

    Args:
        models: Of the first stage, as `load_acf_model` takes them; or detectors of one stage, which get no classifier:
            "hog", OpenCV's, or networks as `load_detector` takes them.
        classifier: Of the second, as `load_classifier` takes it.

    Raises:
        BadInputError: One of them cannot be used.
    """
    second = functools.cache(functools.partial(load_classifier, classifier))  # none of one stage needs it
    names = [model_name(model) for model in models]
    shown = [model if names.count(name) > 1 else name for model, name in zip(models, names, strict=True)]
    return [_stages(model, name, second) for model, name in zip(models, shown, strict=True)]


def _stages(name_or_path: str, name: str, classifier: Callable[[], Classifier]) -> Stages:
    if is_hog(name_or_path):
        return Stages("HOG", "OpenCV", load_detector(HOG, LEAST_HOG_SCORE).detect)
    if is_network(name_or_path):
        network = load_detector(name_or_path, LEAST_NETWORK_PROBABILITY)
        return Stages("network", name, network.detect)
    model = load_acf_model(name_or_path)
    threshold = model.score_threshold if math.isfinite(model.score_threshold) else None
    return Stages("ACF", name, AcfDetector(model).detect, threshold, classifier())
