"""The detector on the INRIA test photographs, the paper's Table 1 [Mateus2019], and the threshold chosen there."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from han_bullet.detection.acf import AcfDetector, load_acf_model
from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.evaluation import LabelledImage, evaluate
from han_bullet.detection.pictures import Image, read_picture
from han_bullet.detection.stages import Stages
from han_bullet.detection.threads import use_one_thread
from han_bullet.detector_figures import FiguresRow, figures
from han_bullet.geometry import Array

FALSE_POSITIVES_PER_IMAGE = 0.45  # what the paper's threshold of 40 leaves with the original's model [Mateus2019]

Report = Callable[[int], None]
"""Called after each photograph with how many are done."""


def choose_threshold(images: Sequence[LabelledImage], model: str, report: Report = lambda done: None) -> AcfModel:
    """Return an ACF model with the score threshold that leaves FALSE_POSITIVES_PER_IMAGE on the test photographs.

    Args:
        images: At least one, with at least one person among them.
        model: As `load_acf_model` takes it; it may have a threshold or none, as a freshly trained one.
        report: Called after each photograph with how many are done.

    Raises:
        BadInputError: They or the model cannot be used, or even its best detections leave more false positives.
    """
    proposer = AcfDetector(load_acf_model(model))
    result = evaluate(images, proposer.detect, report)
    return proposer.model.with_score_threshold(result.threshold_at_fppi(FALSE_POSITIVES_PER_IMAGE))


def evaluate_photographs(
    images: Sequence[LabelledImage], detectors: Sequence[Stages], report: Report = lambda done: None
) -> list[FiguresRow]:
    """Return the table.

    Args:
        images: At least one, with at least one person among them.
        detectors: Each gives several lines.
        report: Called after each photograph with how many are done.

    Raises:
        BadInputError: There is nobody to find or a photograph cannot be read.
    """
    use_one_thread()
    return figures("INRIA", _read(images, report), detectors)


def _read(images: Sequence[LabelledImage], report: Report) -> Iterator[tuple[Image, Array, Array]]:
    for done, image in enumerate(images, start=1):
        yield read_picture(image.path), image.boxes, image.ignored
        report(done)
