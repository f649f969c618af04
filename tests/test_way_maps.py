"""Maps with ways as SVG: what is drawn where, and how little it takes."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from ticks import make_world

from han_bullet.report.way_maps import Stroke, draw_way_map

SVG = "{http://www.w3.org/2000/svg}"


def paths(picture: bytes, colour: str) -> list[dict[str, str]]:
    return [path.attrib for path in ElementTree.fromstring(picture).iter(f"{SVG}path") if path.get("stroke") == colour]


def places(path: dict[str, str]) -> np.ndarray:
    """Return a path's points, (n, 2) [m]."""
    begin, steps = re.fullmatch(r"M(.*?)l(.*)", path["d"]).groups()  # type: ignore[union-attr]
    numbers = [[int(number) for number in point.split(",")] for point in (begin, *steps.split())]
    return 0.01 * np.cumsum(numbers, axis=0) * [1.0, -1.0]


def test_a_straight_way_is_drawn_by_its_ends_where_it_is() -> None:
    way = np.column_stack([np.linspace(1.0, 9.0, 161), np.linspace(-0.5, 1.5, 161)])
    (path,) = paths(draw_way_map(make_world(), [Stroke(way, "red", 5.0)]), "red")
    assert places(path) == pytest.approx(way[[0, -1]], abs=0.006)
    assert "stroke-dasharray" not in path


def test_a_bent_way_is_drawn_to_two_centimetres() -> None:
    x = np.linspace(0.0, 10.0, 201)
    way = np.column_stack([x, 0.8 * np.exp(-((x - 5.0) ** 2))])
    (path,) = paths(draw_way_map(make_world(), [Stroke(way, "red", 5.0)]), "red")
    drawn = places(path)
    assert len(drawn) < 40
    assert np.abs(np.interp(x, *drawn.T) - way[:, 1]).max() < 0.05


def test_a_dashed_way_is_dashed_and_its_dot_is_at_the_end_that_was_asked_for() -> None:
    way = np.array([[1.0, 0.0], [4.0, 1.0]])
    for dot, x in ((16.0, "100"), (-16.0, "400")):
        picture = draw_way_map(None, [Stroke(way, "red", 5.0, dot, dashed=True)])
        assert "stroke-dasharray" in paths(picture, "red")[0]
        (circle,) = ElementTree.fromstring(picture).iter(f"{SVG}circle")
        assert circle.get("cx") == x and circle.get("r") == "16"


def test_who_stands_is_a_way_too() -> None:
    (path,) = paths(draw_way_map(None, [Stroke(np.tile([2.0, 1.0], (40, 1)), "red", 5.0)]), "red")
    assert path["d"].startswith("M200,-100")
