"""Our marginals beside those of Stone Soup's JPDA, an implementation that shares no line with ours.

Stone Soup's PDAHypothesiser and we define the same weights [BarShalom2001], given the same Pd, Pg and clutter density:
1 - Pd Pg for "no measurement", and Pd N(z; Hx, HPH' + R) / clutter density for a measurement. Neither divides by Pg.
It normalizes each track's weights before it sums over the joint events, which changes nothing, for every event has one
weight of each track. Its gate is the chi-square quantile of Pg, 9.2103; ours is 9.21, and 1 m besides: the scenes here
have nobody as far off, and no pair between the two gates.
"""

from datetime import datetime
from typing import Any

import numpy as np
import pytest
from stonesoup.dataassociator.probability import JPDA, JPDAwithEHM2
from stonesoup.hypothesiser.probability import PDAHypothesiser
from stonesoup.models.measurement.linear import LinearGaussian
from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantVelocity
from stonesoup.predictor.kalman import KalmanPredictor
from stonesoup.types.detection import Detection
from stonesoup.types.state import GaussianState
from stonesoup.types.track import Track
from stonesoup.updater.kalman import KalmanUpdater

from han_bullet.tracking.association import GATE_PROBABILITY, Gating, gate
from han_bullet.tracking.nnjpda import Nnjpda, clusters

NOW = datetime(2026, 1, 1)


def random_covariances(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return covariances (count, 2, 2) with deviations of 0.1 to 0.3 m along any two axes."""
    axes = np.linalg.qr(rng.normal(size=(count, 2, 2)))[0]
    return axes @ (rng.uniform(0.1, 0.3, (count, 2, 1)) ** 2 * np.swapaxes(axes, 1, 2))


class Room:
    """Some tracks and measurements within a square with sides [m] from 0 on, each with its own covariance."""

    def __init__(self, seed: int, tracks: int, measurements: int, side: float) -> None:
        rng = np.random.default_rng(seed)
        self.tracks, self.measurements = rng.uniform(0.0, side, (tracks, 2)), rng.uniform(0.0, side, (measurements, 2))
        self.track_covariances = random_covariances(rng, tracks)
        self.covariances = random_covariances(rng, measurements)

    def gating(self) -> Gating:
        return gate(self.tracks, self.track_covariances, self.measurements, self.covariances)

    def stone_soup(self, kind: type[Any], detection_probability: float, clutter_density: float) -> np.ndarray:
        """Return Stone Soup's marginals, shape (n, m + 1), column 0 "no measurement"."""
        still = CombinedLinearGaussianTransitionModel([ConstantVelocity(0.0)] * 2)
        detections = [
            Detection(place, timestamp=NOW, measurement_model=LinearGaussian(4, (0, 2), covariance))
            for place, covariance in zip(self.measurements, self.covariances, strict=True)
        ]
        hypothesiser = PDAHypothesiser(
            KalmanPredictor(still),
            KalmanUpdater(None),
            clutter_spatial_density=clutter_density,
            prob_detect=detection_probability,
            prob_gate=GATE_PROBABILITY,
        )
        tracks = [_track(*one) for one in zip(self.tracks, self.track_covariances, strict=True)]
        hypotheses = kind(hypothesiser).associate(tracks, set(detections), NOW)
        beta = np.zeros((len(tracks), len(detections) + 1))
        for row, track in enumerate(tracks):
            for hypothesis in hypotheses[track]:
                column = 1 + next((j for j, one in enumerate(detections) if one is hypothesis.measurement), -1)
                beta[row, column] += float(hypothesis.probability)
        return beta


def _track(place: np.ndarray, covariance: np.ndarray) -> Track:
    whole = np.zeros((4, 4))
    whole[np.ix_([0, 2], [0, 2])] = covariance
    return Track([GaussianState([place[0], 0.0, place[1], 0.0], whole, timestamp=NOW)])


@pytest.mark.parametrize(("detection_probability", "clutter_density"), [(0.9, 0.005), (0.6, 0.5)])
@pytest.mark.parametrize("seed", range(12))
def test_marginals_equal_those_of_stone_soups_jpda(
    seed: int, detection_probability: float, clutter_density: float
) -> None:
    room = Room(seed, tracks=2 + seed % 3, measurements=1 + seed % 4, side=0.7)
    ours = Nnjpda(detection_probability=detection_probability, clutter_density=clutter_density)
    beta = ours.marginals(room.gating())
    assert beta == pytest.approx(room.stone_soup(JPDA, detection_probability, clutter_density), abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_marginals_of_eight_and_nine_who_share_gates_equal_those_of_its_efficient_jpda(seed: int) -> None:
    room = Room(seed, tracks=8, measurements=9, side=0.7)
    gating = room.gating()
    assert max(len(tracks) for tracks, _ in clusters(gating.inside)) >= 7
    assert Nnjpda().marginals(gating) == pytest.approx(room.stone_soup(JPDAwithEHM2, 0.9, 0.005), abs=1e-9)
