"""Reciprocals to twelve bits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.detection.rough_reciprocals import invert, invert_root, reciprocal_table, root_table

# What an Intel processor's rcpss and rsqrtss give.
RECIPROCALS = {1.0: 0.999755859375, 4.0: 0.24993896484375, 1e10: 9.9987574e-11}
ROOTS = {1.0: 0.999755859375, 4.0: 0.4998779296875, 1e-30: 9.9986839e14}


def rough(values: list[float], root: bool = False) -> np.ndarray:
    line = np.array(values, np.float32)
    if root:
        invert_root(line, root_table())
    else:
        invert(line, reciprocal_table())
    return line


def test_they_are_those_of_the_processor() -> None:
    assert rough(list(RECIPROCALS)) == pytest.approx(list(RECIPROCALS.values()), rel=1e-7)
    assert rough(list(ROOTS), root=True) == pytest.approx(list(ROOTS.values()), rel=1e-7)


@given(st.integers(-100, 100), st.floats(1.0, 2.0, exclude_max=True, width=32))
def test_they_are_within_their_error_of_the_truth(exponent: int, mantissa: float) -> None:
    value = mantissa * 2.0**exponent
    assert rough([value])[0] == pytest.approx(1.0 / value, rel=1.5 * 2.0**-12)
    assert rough([value], root=True)[0] == pytest.approx(value**-0.5, rel=1.5 * 2.0**-12)
