"""Walls and furniture at once say what each of them says alone."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.geometry import SolidBox
from han_bullet.tracking.solids import Solids

EYE = np.array([0.0, 0.0, 2.6])


def some_boxes(rng: np.random.Generator) -> list[SolidBox]:
    return [
        SolidBox("box", "object", rng.uniform((-1, -3, 0), (8, 3, 2)), rng.uniform(0.5, 3.0, 3), rng.uniform(-4, 4))
        for _ in range(5)
    ]


@given(st.integers(0, 2**32 - 1))
def test_what_boxes_hide_is_what_each_box_blocks_that_does_not_hold_the_camera(seed: int) -> None:
    rng = np.random.default_rng(seed)
    boxes, targets = some_boxes(rng), rng.uniform((0.0, -4.0, 0.0), (10.0, 4.0, 2.0), (40, 3))
    blocked = [box.blocks(EYE, targets) for box in boxes if not box.contains(EYE[:2])]
    assert Solids(boxes).hide(EYE, targets).tolist() == np.any([np.zeros(40, bool), *blocked], axis=0).tolist()


@given(st.integers(0, 2**32 - 1))
def test_what_boxes_hold_is_what_each_box_contains(seed: int) -> None:
    rng = np.random.default_rng(seed)
    boxes, places = some_boxes(rng), rng.uniform((-1.0, -4.0), (8.0, 4.0), (100, 2))
    for margin in (-0.3, 0.0, 0.4):
        held = Solids(boxes).hold(places, margin)
        assert held.tolist() == np.any([box.contains(places, margin) for box in boxes], axis=0).tolist()
    assert held.any()


def test_no_boxes_neither_hide_nor_hold_anything() -> None:
    assert not Solids().hide(EYE, np.ones((3, 3))).any()
    assert not Solids().hold(np.ones((3, 2)), 0.0).any()
