"""Variants: how the runs of a sweep differ, written as words joined by `+`, like `truth+without:overtake`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from han_bullet.assumptions import ASSUMPTIONS, JOINT, Scaled
from han_bullet.costmap.layers import layers_meant
from han_bullet.detector_choice import DetectorChoice
from han_bullet.errors import BadInputError
from han_bullet.runner import RunOptions

EVERY_SCORE = -1e6  # below every score of ACF, whose scan gives a window up much sooner


@dataclass(frozen=True)
class Word:
    """One word of a variant.

    Attributes:
        field: Of `RunOptions`, which the word sets; a tuple of several words grows.
        value: What it is set to, by what stands behind the colon.
        argument: What stands behind the colon, for messages; empty for a word without one.
    """

    field: str
    value: Callable[[str], Any]
    argument: str = ""


def _always(value: Any) -> Callable[[str], Any]:
    return lambda _: value


def _threshold(text: str) -> DetectorChoice:
    if text == "none":
        return DetectorChoice(threshold=EVERY_SCORE)
    try:
        score = float(text)
    except ValueError:
        score = math.nan
    if not math.isfinite(score):
        raise BadInputError(f"threshold is {text!r}; a finite score, or none, would be right")
    return DetectorChoice(threshold=score)


def _side(text: str) -> str:
    if text not in ("left", "right"):
        raise BadInputError(f"pass is {text!r}; left or right would be right")
    return text


def _scaled(text: str) -> tuple[Scaled, ...]:
    name, times, factor = text.partition("*")
    try:
        return (Scaled(name, float(factor if times else "nan")),)
    except ValueError as error:
        raise BadInputError(
            f"scale is {text!r}; NAME*FACTOR, like {next(iter(ASSUMPTIONS))}*2, would be right"
        ) from error


WORDS: dict[str, Word] = {
    "cameras": Word("perception", _always("cameras")),
    "truth": Word("perception", _always("truth")),
    "told-pose": Word("localization", _always("truth")),
    "nnjpda": Word("association", _always("nnjpda")),
    "nn": Word("association", _always("nn")),
    "gnn": Word("association", _always("gnn")),
    "camera": Word("cameras", lambda name: (name,), "NAME"),
    "without": Word("without", lambda name: layers_meant((name,)), "LAYER"),
    "threshold": Word("detector", _threshold, "SCORE"),
    "pass": Word("pass_side", _side, "SIDE"),
    "mirrored": Word("mirrored", _always(True)),
    "scale": Word("scaled", _scaled, "NAME*FACTOR"),
}
OF_CAMERAS = ("association", "cameras", "detector")  # fields that mean nothing where nothing is seen


def spellings() -> list[str]:
    """Return every word with what stands behind its colon."""
    return [f"{name}:{word.argument}" if word.argument else name for name, word in WORDS.items()]


def scaled_variants(variant: str) -> list[str]:
    """Return a variant with each assumption halved, and doubled."""
    return [f"{variant}+scale:{Scaled(name, factor)}" for name in ASSUMPTIONS for factor in (0.5, 2.0)]


def parse_variant(text: str) -> RunOptions:
    """Return what a variant's words stand for, with one process per run and no video.

    Raises:
        BadInputError: A word, layer or value that does not exist, two that contradict each other, or one without a
            meaning beside true perception.
    """
    fields: dict[str, Any] = {}
    try:
        for part in JOINT.split(text):
            _add(fields, part)
        idle = [field for field in OF_CAMERAS if field in fields]
        if fields.get("perception") == "truth" and idle:
            raise BadInputError(f"true perception has no {idle[0]}; truth or what goes with it must go")
        return RunOptions(workers=1, video=False, **fields)
    except BadInputError as error:
        raise BadInputError(f"variant {text!r}: {error}") from error


def _add(fields: dict[str, Any], part: str) -> None:
    """Set the field that a word is for."""
    name, _, argument = part.strip().partition(":")
    word = WORDS.get(name)
    if word is None or bool(argument) != bool(word.argument):
        raise BadInputError(f"{part!r} is no word of a variant; there are {', '.join(spellings())}")
    value = word.value(argument)
    if isinstance(value, tuple):
        value = (*fields.get(word.field, ()), *value)
    elif word.field in fields:
        raise BadInputError(f"{part!r} sets {word.field} a second time; one word for it would be right")
    fields[word.field] = value
