"""Where feet end in the image of a fixed camera, and when nobody can tell."""

import math

import numpy as np
import pytest

from han_bullet.detection.foot_edge import ABOVE, FURTHER, foot_rows

SOLES = 200  # row where the body ends [px]


def noisy(image: np.ndarray, seed: int, deviation: float = 6.0) -> np.ndarray:
    noise = np.random.default_rng(seed).normal(0.0, deviation, image.shape)
    return np.clip(np.round(image + noise), 0, 255).astype(np.uint8)


def floor() -> np.ndarray:
    return np.full((240, 320, 3), 130, np.uint8)


def with_body(soles: int = SOLES, *, legs: tuple[slice, ...] = (slice(140, 146), slice(154, 160))) -> np.ndarray:
    image = floor()
    image[60:150, 138:162] = (40, 60, 120)
    for leg in legs:
        image[150:soles, leg] = (70, 50, 40)
    return image


def box(bottom: float, height: float = 142.0) -> np.ndarray:
    return np.array([[150.0 - 0.2 * height, bottom - height, 0.4 * height, height]])


def beside(right: float) -> np.ndarray:
    return box(SOLES + 2.0) + np.array([right, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("off", [-20.0, -8.0, -4.0, 0.0, 3.0, 9.0, 12.0])
def test_the_row_does_not_depend_on_the_box(off: float) -> None:
    for seed in range(5):
        row = foot_rows(noisy(with_body(), seed), noisy(floor(), 100 + seed), box(SOLES + off))[0]
        assert row == pytest.approx(SOLES, abs=1.0)


def test_the_row_is_exact_to_the_pixel_without_noise() -> None:
    for soles in range(194, 207):
        assert foot_rows(with_body(soles), floor(), box(SOLES + 2.0))[0] == soles


def test_the_lower_of_two_feet_counts() -> None:
    image = with_body(SOLES - 6)
    image[SOLES - 6 : SOLES, 154:160] = (70, 50, 40)
    assert foot_rows(image, floor(), box(SOLES + 2.0))[0] == SOLES


@pytest.mark.parametrize("share", [0.65, 0.8, 0.9])
def test_under_a_box_around_the_upper_part_of_somebody_the_legs_are_followed(share: float) -> None:
    height = share * 140.0
    upper = np.array([[150.0 - 0.2 * height, SOLES - 140.0, 0.4 * height, height]])
    for seed in range(5):
        row = foot_rows(noisy(with_body(), seed), noisy(floor(), 100 + seed), upper)[0]
        assert row == pytest.approx(SOLES, abs=1.0)


def test_nobody_can_tell_where_the_edge_is_far_from_that_of_the_box() -> None:
    too_long, too_high = box(SOLES + (ABOVE + 0.03) * 142.0), box(SOLES - (FURTHER + 0.03) * 60.0, 60.0)
    assert np.isnan(foot_rows(with_body(), floor(), np.vstack([too_long, too_high]))).all()


@pytest.mark.parametrize(("width", "known"), [(20, True), (60, False)])
def test_nobody_can_tell_where_something_wider_than_legs_is_before_the_feet(width: int, known: bool) -> None:
    image = with_body()
    image[180:225, 150 - width // 2 : 150 + width // 2] = 240
    assert math.isnan(foot_rows(image, floor(), box(SOLES + 2.0))[0]) != known


def test_nobody_can_tell_under_other_light_or_where_nothing_has_changed() -> None:
    brighter = (with_body() + 40).astype(np.uint8)
    assert math.isnan(foot_rows(brighter, floor(), box(SOLES + 2.0))[0])
    assert math.isnan(foot_rows(floor(), floor(), box(SOLES + 2.0))[0])


def test_nobody_can_tell_at_the_edges_of_the_image() -> None:
    image, boxes = with_body(235), np.vstack([box(236.0), box(-5.0), beside(300.0)])
    assert np.isnan(foot_rows(image, floor(), boxes)).all()


def test_noise_alone_is_no_foot() -> None:
    """A leg ends, and below it there is only the noise of two images."""
    for seed in range(20):
        rows = foot_rows(noisy(with_body(), seed), noisy(floor(), 50 + seed), box(SOLES + 2.0))
        assert rows[0] <= SOLES + 1.0


def test_there_is_one_row_for_each_box() -> None:
    assert foot_rows(with_body(), floor(), np.zeros((0, 4))).shape == (0,)
    rows = foot_rows(with_body(), floor(), np.vstack([box(SOLES + 2.0), beside(90.0)]))
    assert rows[0] == SOLES and math.isnan(rows[1])
