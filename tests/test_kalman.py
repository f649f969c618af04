"""Constant velocity filter: exact algebra, consistency, independence of the tick length."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from han_bullet.tracking.kalman import ACCELERATION_DEVIATION, ACCELERATION_INTERVAL, ConstantVelocity, MotionState

MOTION = ConstantVelocity()
MEASURED = np.diag([0.15**2, 0.05**2])  # [m^2]


def seen_at(x: float, y: float) -> MotionState:
    return MOTION.start(np.array([x, y]), MEASURED)


def test_a_new_state_has_the_measured_place_and_an_unknown_speed_of_half_a_metre_per_second() -> None:
    state = seen_at(3.0, -0.4)
    assert state.mean.shape == (4,)
    assert state.mean.tolist() == [3.0, -0.4, 0.0, 0.0]
    assert np.sqrt(np.diag(state.covariance)) == pytest.approx([0.15, 0.05, 0.5, 0.5])


def test_someone_with_a_known_velocity_is_predicted_along_it() -> None:
    state = MotionState(np.array([1.0, 2.0, 0.4, -0.2]), np.eye(4))
    assert MOTION.predict(state, 0.5).mean == pytest.approx([1.2, 1.9, 0.4, -0.2])


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
        error = state.mean - truth
        nees.append(error @ np.linalg.solve(state.covariance, error))
    low, high = chi2.ppf([0.005, 0.995], 4 * walks)
    assert low < sum(nees) < high
