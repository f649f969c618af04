"""The detector on rendered sequences that it was never trained on: the paper's Table 2 [Mateus2019] in our building.

Miss rates and speed, stage by stage, on images alone. Which people are missed, and what the still scene of fixed
cameras changes, is what `benchmarks/rendered_people.py` tells.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from han_bullet.detection.pictures import Image
from han_bullet.detection.stages import Stages
from han_bullet.detection.threads import use_one_thread
from han_bullet.detector_figures import FiguresRow, figures
from han_bullet.geometry import Array
from han_bullet.rendered_sequences import RenderedFrame, Report, corridor, mbot

SEED = 0
SEQUENCES = {"corridor": corridor, "MBOT": mbot}  # as the paper calls a ceiling camera's and the robot's


def evaluate_rendered(frames: int, detectors: Sequence[Stages], report: Report = lambda done: None) -> list[FiguresRow]:
    """Return the table: every sequence, every detector.

    Args:
        frames: Of each sequence.
        detectors: Each gives several lines per sequence.
        report: Called after each frame with how many of all sequences are done.

    Raises:
        BadInputError: Nobody shows in that many frames.
    """
    use_one_thread()
    rows = []
    for number, (name, sequence) in enumerate(SEQUENCES.items()):
        rendered = sequence(frames, SEED, partial(_report_on, report, number * frames))
        rows += figures(name, map(_labelled, rendered), detectors)
    return rows


def _report_on(report: Report, before: int, done: int) -> None:
    report(before + done)


def _labelled(frame: RenderedFrame) -> tuple[Image, Array, Array]:
    return frame.image, frame.boxes, frame.ignored
