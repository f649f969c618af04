"""The layers' effects in words."""

import math

import numpy as np

from han_bullet.explain.explanation import LayerEffect, Shift, WayExplained
from han_bullet.explain.sentences import details, has_effect, movers, verdict
from han_bullet.messages import Status

WAY = np.array([[0.0, 0.0], [4.0, 0.0]])


def layer(name: str, largest: float | None = 0.0, cost_of_way: float = 4.5, **changes: object) -> LayerEffect:
    shift = None if largest is None else Shift(largest, 0.1, (2.0, 0.5))
    values: dict[str, object] = {
        "layer": name,
        "way": WAY,
        "length": 4.0,
        "cost_of_way": cost_of_way,
        "cost_without": 4.2,
        "cost_if_ignored": 6.0,
        "shift": shift,
        "dearest": None,
        "causes": (),
        "sides": {},
    }
    return LayerEffect(**(values | changes))  # type: ignore[arg-type]


def way(*layers: LayerEffect, best: bool = True) -> WayExplained:
    cost = 4.5 if best else math.inf
    return WayExplained(Status.MOVING, None, cost, WAY if best else None, cost, 4.0, None, {}, layers)


def test_the_layer_that_moves_the_way_most_is_named_with_side_and_cause() -> None:
    layers = layer("body", 0.2), layer("overtake", -0.62, causes=("track 3 (anna)",)), layer("static")
    assert [one.layer for one in movers(way(*layers))] == ["overtake", "body"]
    assert verdict(way(*layers)) == [
        "overtake moved the way by 0.62 m to the right near (2.0, 0.5), because of track 3 (anna)"
    ]


def test_where_the_building_moves_it_most_the_strongest_other_layer_is_named_too() -> None:
    told = verdict(way(layer("inflation", 0.9), layer("body", 0.2), layer("visibility", 0.3)))
    assert [line.split()[0] for line in told] == ["inflation", "visibility"]


def test_less_than_a_cell_is_nothing() -> None:
    explained = way(layer("body", 0.04))
    assert verdict(explained) == ["no layer moved the way"]
    assert not has_effect(explained.layers[0], explained)


def test_a_layer_that_makes_the_way_dearer_without_moving_it_has_an_effect() -> None:
    effect = layer("visibility", cost_of_way=4.0, dearest=((1.0, 0.0), 30), causes=("track 0 (bob)", "tv"))
    assert has_effect(effect, way(effect))
    assert details(effect, way(effect)) == (
        "does not move the way; without it this way costs 4.00; it adds most, 30, at (1.0, 0.0), "
        "because of track 0 (bob) and tv"
    )


def test_a_layer_that_leaves_no_way_closes_it() -> None:
    effect = layer("body", None, cost_of_way=math.inf, cost_if_ignored=404.0, causes=("track 0 (bob)",))
    explained = way(effect, best=False)
    assert verdict(explained) == ["body closed the way, because of track 0 (bob): without it there is one of 4.0 m"]
    assert details(effect, explained).startswith(
        "there is a way only without it; the best way without it is 4.00 m long"
    )
