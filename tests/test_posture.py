"""Standing, walking, seated; and which way people face."""

import math

import numpy as np
import pytest

from han_bullet.messages import Posture, Seat
from han_bullet.tracking.kalman import MotionState
from han_bullet.tracking.posture import PostureEstimator, Stance, speed_deviation
from han_bullet.tracking.seats import in_sitting_area

COUCH = Seat("couch", np.array([5.0, 1.0]), -0.5 * math.pi, 0.8, 1.9, "tv")
TICK = 0.1  # [s]


class Walk:
    """Feed an estimator with a body that moves as told."""

    def __init__(self, start: tuple[float, float] = (0.0, 0.0), seats: tuple[Seat, ...] = ()) -> None:
        self.estimator = PostureEstimator(seats)
        self.position = np.array(start)
        self.time = 0.0

    def go(self, velocity: tuple[float, float], duration: float, deviation: float = 0.05) -> list[Stance]:
        """Move for a time [s] at a velocity that the track knows with a deviation [m/s]; return the stances."""
        stances = []
        for _ in range(round(duration / TICK)):
            self.time += TICK
            self.position = self.position + TICK * np.array(velocity)
            covariance = np.diag([0.01, 0.01, deviation**2, deviation**2, 0.01])
            state = MotionState(np.array([*self.position, *velocity, 0.0]), covariance)
            stances.append(self.estimator.update(self.time, state))
        return stances


def test_somebody_new_stands_and_their_heading_is_not_known() -> None:
    assert Walk().go((0.0, 0.0), 0.1) == [Stance(Posture.STANDING, None, None)]


def test_a_walker_is_noticed_once_the_way_of_a_second_exceeds_twenty_centimetres() -> None:
    stances = Walk().go((0.4, 0.0), 3.0)
    first = next(k for k, stance in enumerate(stances) if stance.posture is Posture.WALKING)
    # 0.2 m at 0.4 m/s from the first update on.
    assert first * TICK == pytest.approx(0.6, abs=0.11)
    assert all(stance.posture is Posture.WALKING for stance in stances[first:])


@pytest.mark.parametrize(("speed", "deviation"), [(0.19, 0.01), (0.4, 0.14)])
def test_a_slow_or_an_uncertain_speed_is_no_walk(speed: float, deviation: float) -> None:
    assert {s.posture for s in Walk().go((speed, 0.0), 5.0, deviation)} == {Posture.STANDING}


def test_a_quarter_of_a_metre_per_second_is_a_walk() -> None:
    assert Walk().go((0.25, 0.0), 3.0)[-1].posture is Posture.WALKING


def test_who_is_slow_does_not_set_off_though_the_track_has_shifted() -> None:
    """The shift of the last second, 0.2 m and more, may be that of a speed that nobody could be sure of."""
    walk = Walk()
    assert {s.posture for s in walk.go((0.4, 0.0), 1.0, deviation=0.14)} == {Posture.STANDING}
    assert {s.posture for s in walk.go((0.15, 0.0), 0.5, deviation=0.01)} == {Posture.STANDING}


def test_a_body_that_sways_without_getting_anywhere_stands() -> None:
    walk = Walk()
    postures = {s.posture for k in range(10) for s in walk.go((0.35 * (-1) ** k, 0.0), 0.4)}
    assert postures == {Posture.STANDING}


def test_between_the_two_speeds_the_posture_is_held() -> None:
    walk = Walk()
    assert walk.go((0.4, 0.0), 2.0)[-1].posture is Posture.WALKING
    assert {s.posture for s in walk.go((0.15, 0.0), 5.0)} == {Posture.WALKING}
    assert {s.posture for s in walk.go((0.05, 0.0), 0.5)} == {Posture.WALKING}
    assert walk.go((0.05, 0.0), 0.1)[-1].posture is Posture.STANDING
    assert {s.posture for s in walk.go((0.15, 0.0), 5.0)} == {Posture.STANDING}


def test_a_track_that_overshoots_and_comes_back_after_a_stop_soon_stands() -> None:
    walk = Walk()
    walk.go((0.8, 0.0), 3.0)
    walk.go((0.4, 0.0), 0.5)
    assert walk.go((-0.2, 0.0), 0.5)[-1].posture is Posture.WALKING
    stances = walk.go((0.11, 0.0), 1.0)
    assert Posture.STANDING in {s.posture for s in stances}
    assert stances[-1].heading == pytest.approx(0.0)


def test_a_heading_is_held_after_a_second_of_walking_and_not_before() -> None:
    long, short = Walk(), Walk()
    long.go((0.0, 0.5), 3.0)
    assert long.go((0.0, 0.0), 2.0)[-1].heading == pytest.approx(0.5 * math.pi)
    walking = [s for s in short.go((0.0, 0.5), 1.0) if s.posture is Posture.WALKING]
    assert 0 < len(walking) < 10
    assert walking[-1].heading == pytest.approx(0.5 * math.pi)
    assert short.go((0.0, 0.0), 2.0)[-1] == Stance(Posture.STANDING, None, None)


@pytest.mark.parametrize(("lasted", "remembered"), [(0.9, False), (1.1, True)])
def test_that_second_counts_from_when_they_were_seen_to_walk(lasted: float, remembered: bool) -> None:
    walk = Walk()
    ticks = next(n for n in range(1, 40) if walk.go((0.0, 0.5), TICK)[-1].posture is Posture.WALKING)
    assert ticks * TICK < 1.0
    walk.go((0.0, 0.5), lasted)
    stance = walk.go((0.0, 0.0), 2.0)[-1]
    assert stance.posture is Posture.STANDING
    assert (stance.heading is not None) is remembered


def test_who_stands_in_a_sitting_area_sits_and_faces_as_declared() -> None:
    stance = Walk((5.3, 0.5), (COUCH,)).go((0.0, 0.0), 0.1)[-1]
    assert stance == Stance(Posture.SEATED, pytest.approx(-0.5 * math.pi), COUCH)


def test_who_walks_through_a_sitting_area_does_not_sit() -> None:
    walk = Walk((2.0, 0.5), (COUCH,))
    walk.go((0.5, 0.0), 3.0)
    assert in_sitting_area(COUCH, walk.position - [-0.6, 0.0])
    assert {s.posture for s in walk.go((0.5, 0.0), 6.0)} == {Posture.WALKING}


def test_a_seated_person_whose_foot_point_strays_stays_seated_until_it_leaves_the_margin() -> None:
    walk = Walk((5.9, 0.5), (COUCH,))
    assert walk.go((0.0, 0.0), 0.2)[-1].posture is Posture.SEATED
    assert walk.go((0.15, 0.0), 1.0)[-1].posture is Posture.SEATED
    assert not in_sitting_area(COUCH, walk.position)
    assert walk.go((0.15, 0.0), 1.0)[-1].posture is Posture.STANDING
    assert walk.go((-0.15, 0.0), 1.0)[-1].posture is Posture.STANDING


def test_a_sitting_area_is_the_seat_and_the_floor_before_it() -> None:
    # Faces -y: 0.8 m before the seat, 0.4 m behind it, 0.95 m to either side.
    inside = in_sitting_area(
        COUCH, np.array([[5.0, 0.25], [5.0, 0.15], [5.0, 1.35], [5.0, 1.45], [5.9, 1.0], [6.0, 1.0]])
    )
    assert inside.tolist() == [True, False, True, False, True, False]


def test_the_speed_is_as_uncertain_as_the_velocity_along_itself() -> None:
    covariance = np.diag([0.0, 0.0, 0.3**2, 0.1**2, 0.0])
    assert speed_deviation(MotionState(np.array([0.0, 0.0, 0.0, 2.0, 0.0]), covariance)) == pytest.approx(0.1)
    assert speed_deviation(MotionState(np.array([0.0, 0.0, 3.0, 0.0, 0.0]), covariance)) == pytest.approx(0.3)
    assert speed_deviation(MotionState(np.zeros(5), covariance)) == pytest.approx(0.3)
