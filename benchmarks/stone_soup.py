"""Stone Soup's trackers of people, set up as much like ours as its parts allow."""

from collections.abc import Callable
from datetime import datetime, timedelta
from typing import Any

import numpy as np

from benchmarks.crowd import CLUTTER_DENSITY, DETECTION_PROBABILITY, POSITION_DEVIATION, SCAN_PERIOD, Recording
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array
from han_bullet.messages import Posture
from han_bullet.tracking.association import GATE_PROBABILITY, MAHALANOBIS_GATE
from han_bullet.tracking.kalman import ConstantVelocity
from han_bullet.tracking.track import HITS_TO_CONFIRM, LIVES

try:
    from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
    from stonesoup.dataassociator.probability import JPDA, JPDAwithEHM2
    from stonesoup.deleter.time import UpdateTimeDeleter
    from stonesoup.hypothesiser.distance import DistanceHypothesiser
    from stonesoup.hypothesiser.probability import PDAHypothesiser
    from stonesoup.initiator.simple import MultiMeasurementInitiator
    from stonesoup.measures import Mahalanobis
    from stonesoup.models.measurement.linear import LinearGaussian
    from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel
    from stonesoup.models.transition.linear import ConstantVelocity as OneAxis
    from stonesoup.predictor.kalman import KalmanPredictor
    from stonesoup.tracker.simple import MultiTargetMixtureTracker, MultiTargetTracker
    from stonesoup.types.detection import Detection
    from stonesoup.types.state import GaussianState
    from stonesoup.updater.kalman import KalmanUpdater
except ImportError:
    raise BadInputError("Stone Soup, which ours is compared with, is missing: pip install '.[bench]'") from None

START = datetime(2026, 1, 1)
POSITIONS = (0, 2)  # of (x, vx, y, vy)
# Of a track on trial without a measurement [s]: ours takes three within 0.5 s.
TRIAL_LIFE = 0.35
LIFE = LIVES[Posture.WALKING]  # of a confirmed track without a measurement [s]; posture and youth it does not know

Step = Callable[[int], dict[int, Array]]


def gnn(recording: Recording, motion: ConstantVelocity) -> Step:
    """Return a global nearest neighbour tracker that takes the scans of a recording one by one."""
    return _steps(recording, motion, MultiTargetTracker, lambda: GNNWith2DAssignment(_by_distance(motion)))


def jpda(recording: Recording, motion: ConstantVelocity) -> Step:
    """Return a JPDA tracker that adds up the joint events one by one."""
    return _steps(recording, motion, MultiTargetMixtureTracker, lambda: JPDA(_by_probability(motion)))


def jpda_ehm2(recording: Recording, motion: ConstantVelocity) -> Step:
    """Return a JPDA tracker with efficient hypothesis management: the same marginals, without listing the events."""
    return _steps(recording, motion, MultiTargetMixtureTracker, lambda: JPDAwithEHM2(_by_probability(motion)))


def _steps(recording: Recording, motion: ConstantVelocity, tracker: Any, associator: Callable[[], Any]) -> Step:
    """Return a function of the scan's number; Stone Soup's own types are made before any time is taken."""
    scans = [_detections(k, found) for k, found in enumerate(recording.measurements)]
    running = tracker(
        initiator=MultiMeasurementInitiator(
            prior_state=GaussianState(np.zeros(4), np.diag([0.0, motion.initial_speed_deviation**2] * 2)),
            measurement_model=_sensor(),
            deleter=UpdateTimeDeleter(timedelta(seconds=TRIAL_LIFE)),
            data_associator=GNNWith2DAssignment(_by_distance(motion)),
            updater=KalmanUpdater(_sensor()),
            min_points=HITS_TO_CONFIRM,
        ),
        deleter=UpdateTimeDeleter(timedelta(seconds=LIFE)),
        detector=None,
        data_associator=associator(),
        updater=KalmanUpdater(_sensor()),
    )
    numbers: dict[str, int] = {}

    def step(scan: int) -> dict[int, Array]:
        _, tracks = running.update_tracker(*scans[scan])
        return {
            numbers.setdefault(track.id, len(numbers)): np.array(track.state_vector, float).ravel()[list(POSITIONS)]
            for track in tracks
        }

    return step


def _detections(number: int, found: Array) -> tuple[datetime, set[Any]]:
    time = START + timedelta(seconds=number * SCAN_PERIOD)
    sensor = _sensor()
    return time, {Detection(point, timestamp=time, measurement_model=sensor) for point in found}


def _sensor() -> Any:
    return LinearGaussian(ndim_state=4, mapping=POSITIONS, noise_covar=POSITION_DEVIATION**2 * np.eye(2))


def _predictor(motion: ConstantVelocity) -> Any:
    return KalmanPredictor(CombinedLinearGaussianTransitionModel([OneAxis(motion.density)] * 2))


def _by_distance(motion: ConstantVelocity) -> Any:
    most = float(np.sqrt(MAHALANOBIS_GATE))
    return DistanceHypothesiser(_predictor(motion), KalmanUpdater(_sensor()), Mahalanobis(), missed_distance=most)


def _by_probability(motion: ConstantVelocity) -> Any:
    return PDAHypothesiser(
        _predictor(motion),
        KalmanUpdater(_sensor()),
        clutter_spatial_density=CLUTTER_DENSITY,
        prob_detect=DETECTION_PROBABILITY,
        prob_gate=GATE_PROBABILITY,
    )
