"""Variants of a sweep: what their words stand for, and what is refused."""

import pytest

from han_bullet.assumptions import ASSUMPTIONS, Scaled
from han_bullet.commands.sweep import WORDS as HELP
from han_bullet.costmap.layers import STANDARD
from han_bullet.detection.acf import load_acf_model
from han_bullet.errors import BadInputError
from han_bullet.runner import RunOptions
from han_bullet.sweep.variants import EVERY_SCORE, parse_variant, scaled_variants, spellings

PLAIN = RunOptions(workers=1, video=False)


def test_a_plain_variant_sees_with_all_cameras_in_one_process_without_a_video() -> None:
    assert parse_variant("cameras") == parse_variant("nnjpda") == PLAIN
    assert PLAIN.perception == "cameras" and PLAIN.cameras is None


@pytest.mark.parametrize(
    ("text", "field", "value"),
    [
        ("truth", "perception", "truth"),
        ("cameras+nn", "association", "nn"),
        ("gnn", "association", "gnn"),
        ("camera:onboard", "cameras", ("onboard",)),
        ("camera:camera1+camera:onboard", "cameras", ("camera1", "onboard")),
        ("truth+without:overtake", "without", ("overtake",)),
        ("without:overtake+without:visibility", "without", ("overtake", "visibility")),
        ("pass:right", "pass_side", "right"),
        ("truth+mirrored", "mirrored", True),
        ("scale:interaction.gamma*0.5", "scaled", (Scaled("interaction.gamma", 0.5),)),
    ],
)
def test_a_word_sets_its_option(text: str, field: str, value: object) -> None:
    assert getattr(parse_variant(text), field) == value


def test_a_sensitivity_halves_and_doubles_every_assumption() -> None:
    found = [parse_variant(variant).scaled for variant in scaled_variants("truth")]
    assert found == [(Scaled(name, factor),) for name in ASSUMPTIONS for factor in (0.5, 2.0)]


def test_without_social_leaves_what_any_robot_needs() -> None:
    left = {layer.name for layer in STANDARD} - set(parse_variant("without:social").without)
    assert left == {"static", "obstacle", "inflation", "body"}


def test_a_threshold_is_a_score_or_none_at_all() -> None:
    assert parse_variant("threshold:40").detector.threshold == 40.0
    assert parse_variant("threshold:-2.5").detector.threshold == -2.5
    assert parse_variant("threshold:none").detector.threshold == EVERY_SCORE
    assert parse_variant("cameras").detector.threshold is None
    assert load_acf_model("default").cascade_threshold > EVERY_SCORE  # at which the scan gives up by itself


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("turth", "'turth' is no word of a variant; there are cameras, truth"),
        ("", "'' is no word"),
        ("truth+", "'' is no word"),
        ("camera", "'camera' is no word of a variant; there are .*camera:NAME"),
        ("truth:yes", "'truth:yes' is no word"),
        ("without:overtke", "layer 'overtke' is not known; there are static, .*overtake"),
        ("scale:interaction.gama*2", "'interaction.gama' is no assumption; there are personal_still"),
        ("scale:interaction.gamma*much", "scale is .*; NAME.FACTOR, like personal_still.deviation.2, would be right"),
        ("scale:interaction.gamma", "scaled by nan; a finite factor above 0"),
        ("scale:interaction.gamma*0", "scaled by 0.0; a finite factor above 0"),
        ("pass:up", "pass is 'up'; left or right"),
        ("threshold:high", "threshold is 'high'; a finite score, or none"),
        ("threshold:inf", "threshold is 'inf'"),
        ("cameras+truth", "'truth' sets perception a second time"),
        ("nn+gnn", "'gnn' sets association a second time"),
        ("threshold:40+threshold:none", "'threshold:none' sets detector a second time"),
        ("camera:a+camera:a", "each once"),
        ("truth+nn", "true perception has no association"),
        ("camera:a+truth", "true perception has no cameras"),
    ],
)
def test_what_cannot_be_meant_is_refused_in_a_sentence(text: str, complaint: str) -> None:
    with pytest.raises(BadInputError, match=complaint) as refusal:
        parse_variant(text)
    assert str(refusal.value).startswith(f"variant {text!r}: ")


def test_the_help_has_every_word() -> None:
    words = [spelling.partition(":")[0] for spelling in spellings()]
    assert [word for word in words if word not in HELP.replace(":", " ").split()] == []
