"""From the name or file of a model to a detector that is ready for use."""

from __future__ import annotations

import math
from pathlib import Path

from han_bullet.detection.acf import AcfDetector, load_acf_model
from han_bullet.detection.hog_detector import HogDetector
from han_bullet.detection.model_files import DEFAULT, has_one_stage, is_hog, is_network, proposer_file
from han_bullet.detection.network_detector import NetworkDetector
from han_bullet.detection.onnx_detector import load_darknet, load_onnx
from han_bullet.detection.pedestrian_detector import PedestrianDetector
from han_bullet.errors import BadInputError

LoadedDetector = PedestrianDetector | NetworkDetector | HogDetector
"""A detector with the `threshold` that its boxes reach."""


def load_detector(
    name_or_path: str | Path = DEFAULT, threshold: float | None = None, classifier: str | Path | None = DEFAULT
) -> LoadedDetector:
    """Build a detector from shipped models or a file.

    Args:
        name_or_path: ACF model as `load_acf_model` takes it: "default", the name of a shipped one, or a file; or what
            finds people by itself: an .onnx file, Darknet's .cfg with its .weights beside it, or "hog", OpenCV's.
        threshold: Least score, of a network least probability; None takes the model's own.
        classifier: CNN that decides about ACF's proposals, as `load_classifier` takes it; None leaves ACF alone.

    Raises:
        BadInputError: No such model, it is not one, no threshold is given and it has none, or a classifier is given for
            what finds people by itself.
    """
    if threshold is not None and not math.isfinite(threshold):
        raise BadInputError(f"detector threshold is {threshold}; a finite score would be right")
    if has_one_stage(name_or_path) and classifier not in (DEFAULT, None):
        raise BadInputError(
            f"detector {str(name_or_path)!r} finds people in one stage; a classifier, {str(classifier)!r}, is for ACF"
        )
    if is_hog(name_or_path):
        return HogDetector() if threshold is None else HogDetector(threshold)
    if is_network(name_or_path):
        file = proposer_file(name_or_path)
        return load_onnx(file, threshold) if file.suffix.lower() == ".onnx" else load_darknet(file, threshold)
    model = load_acf_model(name_or_path)
    if threshold is None:
        threshold = model.score_threshold
        if not math.isfinite(threshold):
            raise BadInputError(
                f"model {str(name_or_path)!r} has no score threshold; give --threshold or choose one with "
                "`han-bullet evaluate --choose-threshold`"
            )
    network = None
    if classifier is not None:
        from han_bullet.detection.cnn import load_classifier

        network = load_classifier(classifier)
    return PedestrianDetector(AcfDetector(model), network, threshold)
