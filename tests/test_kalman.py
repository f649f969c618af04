"""Constant velocity filter: exact algebra, consistency, independence of the tick length."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from han_bullet.errors import BadInputError
from han_bullet.tracking.kalman import (
    ACCELERATION_DEVIATION,
    ACCELERATION_INTERVAL,
    HEIGHT_DEVIATION,
    HEIGHT_TIME,
    ConstantVelocity,
    MotionState,
)

MOTION = ConstantVelocity()
MEASURED = np.diag([0.15**2, 0.05**2])  # [m^2]


# Of a head seen from above along y, 5 m away and 0.9 m lower: a metre of height is 5.6 m of floor.
PER_HEIGHT = np.array([0.0, 5.6])
BY_HEAD = MEASURED + HEIGHT_DEVIATION**2 * np.outer(PER_HEIGHT, PER_HEIGHT)


def seen_at(x: float, y: float) -> MotionState:
    return MOTION.start(np.array([x, y]), MEASURED)


def test_a_new_state_has_the_measured_place_and_an_unknown_speed_of_half_a_metre_per_second() -> None:
    state = seen_at(3.0, -0.4)
    assert state.mean.shape == (5,)
    assert state.mean.tolist() == [3.0, -0.4, 0.0, 0.0, 0.0]
    assert np.sqrt(np.diag(state.covariance)) == pytest.approx([0.15, 0.05, 0.5, 0.5, HEIGHT_DEVIATION])


def test_someone_with_a_known_velocity_is_predicted_along_it() -> None:
    state = MotionState(np.array([1.0, 2.0, 0.4, -0.2, 0.0]), np.eye(5))
    assert MOTION.predict(state, 0.5).mean == pytest.approx([1.2, 1.9, 0.4, -0.2, 0.0])


@given(st.floats(0.01, 2.0), st.floats(0.01, 2.0))
def test_two_short_predictions_equal_one_long_one(first: float, second: float) -> None:
    state = seen_at(1.0, 1.0)
    twice = MOTION.predict(MOTION.predict(state, first), second)
    once = MOTION.predict(state, first + second)
    assert twice.mean == pytest.approx(once.mean, abs=1e-12)
    assert twice.covariance == pytest.approx(once.covariance, abs=1e-12)


def test_going_back_in_time_changes_nothing() -> None:
    state = seen_at(1.0, 1.0)
    assert MOTION.predict(state, -0.1) is state


def test_a_correction_equals_the_weighting_of_two_gaussians() -> None:
    state = MOTION.predict(seen_at(1.0, 1.0), 0.1)
    corrected = MOTION.correct(state, np.array([1.2, 1.1]), MEASURED)
    information = np.linalg.inv(state.position_covariance) + np.linalg.inv(MEASURED)
    vector = np.linalg.solve(state.position_covariance, state.position) + np.linalg.solve(MEASURED, [1.2, 1.1])
    assert corrected.position_covariance == pytest.approx(np.linalg.inv(information), abs=1e-12)
    assert corrected.position == pytest.approx(np.linalg.solve(information, vector), abs=1e-12)


def test_covariances_stay_symmetric_and_positive_over_ten_minutes_of_hits() -> None:
    state = seen_at(0.0, 0.0)
    for _ in range(600):
        state = MOTION.correct(MOTION.predict(state, 1.0), np.zeros(2), 1e-4 * np.eye(2))
    assert np.array_equal(state.covariance, state.covariance.T)
    assert np.linalg.eigvalsh(state.covariance).min() > 0.0


def test_the_filter_knows_its_own_error() -> None:
    """The mean squared error, normalized by the covariance (NEES), of 40 walks lies in its 99 % chi-square band."""
    rng = np.random.default_rng(7)
    walks, nees = 40, []
    density, period = ACCELERATION_DEVIATION**2 * ACCELERATION_INTERVAL, 0.1
    noise = np.kron([[period**3 / 3, period**2 / 2], [period**2 / 2, period]], np.eye(2)) * density
    for _ in range(walks):
        truth = np.array([0.0, 0.0, *rng.normal(0.0, 0.5, 2)])
        state = MOTION.start(rng.multivariate_normal(truth[:2], MEASURED), MEASURED)
        for _ in range(40):
            truth[:2] += period * truth[2:]
            truth = rng.multivariate_normal(truth, noise)
            state = MOTION.predict(state, period)
            state = MOTION.correct(state, rng.multivariate_normal(truth[:2], MEASURED), MEASURED)
        error = state.mean[:4] - truth
        nees.append(error @ np.linalg.solve(state.motion_covariance, error))
    low, high = chi2.ppf([0.005, 0.995], 4 * walks)
    assert low < sum(nees) < high


def by_heads(state: MotionState, places: list[float], taller: float) -> MotionState:
    """Return the state after heads at (0, y), a frame each, of somebody who is taller than assumed [m]."""
    for y in places:
        head = np.array([0.0, y]) + taller * PER_HEIGHT
        state = MOTION.correct(MOTION.predict(state, 0.1), head, BY_HEAD, PER_HEIGHT)
    return state


def test_a_head_of_known_height_tells_as_much_as_feet() -> None:
    known = MotionState(np.zeros(5), np.diag([0.04, 0.09, 0.01, 0.01, 0.0]))
    by_head = MOTION.correct(known, np.array([0.2, 0.1]), BY_HEAD, PER_HEIGHT)
    by_feet = MOTION.correct(known, np.array([0.2, 0.1]), MEASURED)
    assert by_head.mean == pytest.approx(by_feet.mean, abs=1e-12)
    assert by_head.covariance == pytest.approx(by_feet.covariance, abs=1e-12)


def test_the_feet_of_who_began_by_the_head_tell_their_height() -> None:
    taller = 0.08
    began = MOTION.start(taller * PER_HEIGHT, BY_HEAD, PER_HEIGHT)
    seen = MOTION.correct(began, np.zeros(2), 1e-6 * np.eye(2))
    assert seen.position == pytest.approx([0.0, 0.0], abs=1e-3)
    assert seen.mean[4] == pytest.approx(taller, rel=0.05)


def test_a_hundred_places_by_the_head_know_no_more_of_the_distance_than_their_common_height() -> None:
    once = MOTION.start(np.zeros(2), BY_HEAD, PER_HEIGHT)
    assert math.sqrt(once.position_covariance[1, 1]) == pytest.approx(0.56, abs=0.01)
    often = by_heads(once, [0.0] * 100, taller=0.0)
    white = once
    for _ in range(100):
        white = MOTION.correct(MOTION.predict(white, 0.1), np.zeros(2), BY_HEAD)
    assert math.sqrt(often.position_covariance[1, 1]) > 0.3 > 0.2 > math.sqrt(white.position_covariance[1, 1])
    assert math.sqrt(often.position_covariance[0, 0]) < 0.07


@pytest.mark.parametrize("taller", [-0.08, 0.08])
def test_who_is_known_by_their_feet_stays_where_they_are_when_their_head_seems_elsewhere(taller: float) -> None:
    """Heads of the tall seem 0.45 m farther and those of the short nearer: that tells the height, and not a step."""
    standing = seen_at(0.0, 0.0)
    for _ in range(30):
        standing = MOTION.correct(MOTION.predict(standing, 0.1), np.zeros(2), MEASURED)
    hidden = by_heads(standing, [0.0] * 20, taller)
    assert np.abs(hidden.position) == pytest.approx([0.0, 0.0], abs=0.05)
    assert hidden.mean[4] == pytest.approx(taller, abs=0.02)


def test_steps_of_a_head_are_steps_of_its_person_whatever_their_height() -> None:
    standing = MOTION.start(np.zeros(2), MEASURED)
    walked = by_heads(standing, [0.035 * k for k in range(30)], taller=0.08)
    assert walked.position[1] == pytest.approx(0.035 * 29, abs=0.2)
    assert walked.velocity[1] == pytest.approx(0.35, abs=0.06)


def test_heights_are_forgotten_with_time() -> None:
    known = MotionState(np.array([0.0, 0.0, 0.0, 0.0, 0.08]), np.diag([0.01, 0.01, 0.01, 0.01, 0.0]))
    later = MOTION.predict(known, HEIGHT_TIME)
    assert later.mean[4] == pytest.approx(0.08 / math.e)
    assert math.sqrt(later.covariance[4, 4]) == pytest.approx(HEIGHT_DEVIATION * math.sqrt(1.0 - math.exp(-2.0)))


@pytest.mark.parametrize("name", ["acceleration_deviation", "initial_speed_deviation"])
@pytest.mark.parametrize("value", [0.0, -0.3, math.inf, math.nan])
def test_a_deviation_that_is_no_positive_number_is_refused(name: str, value: float) -> None:
    with pytest.raises(BadInputError, match=f"motion model: {name} is {value}; it must be a positive number"):
        ConstantVelocity(**{name: value})
