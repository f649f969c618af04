"""One track by itself: confirmation, lives, duplicates, and who goes on as somebody who was lost."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from han_bullet.geometry import Intrinsics
from han_bullet.messages import Frame, Posture, Scan, Seat
from han_bullet.tracking.kalman import ConstantVelocity, MotionState
from han_bullet.tracking.posture import Stance
from han_bullet.tracking.track import Track

MOTION = ConstantVelocity()
COUCH = Seat("couch", np.array([5.0, 1.0]), -0.5 * math.pi, 0.8, 1.9, "tv")
STANCES = {
    Posture.WALKING: Stance(Posture.WALKING, 0.0),
    Posture.STANDING: Stance(Posture.STANDING),
    Posture.SEATED: Stance(Posture.SEATED, COUCH.facing, COUCH),
}


def scan(time: float, place: tuple[float, float] = (0.0, 0.0), camera: str = "east") -> Scan:
    """Return a scan of one measurement with a deviation of 0.1 m."""
    frame = Frame(camera, time, np.zeros((1, 1, 3), np.uint8), Intrinsics(1, 1, 1.0, 1.0, 0.5, 0.5), np.eye(4), True)
    return Scan(camera, time, np.array([place]), 0.01 * np.eye(2)[None], np.zeros(1, np.int64), frame)


def seen(
    since: float, until: float, place: tuple[float, float] = (0.0, 0.0), camera: str = "east", period: float = 0.1
) -> Track:
    """Return a track with a hit in every frame of a camera from one time to another [s], at one place."""
    times = np.arange(round((until - since) / period) + 1) * period + since
    track = Track(scan(times[0], place, camera), 0, MOTION, [COUCH])
    for time in times[1:].tolist():
        track.advance(time)
        track.hit(scan(time, place, camera), 0)
    return track


def moving(track: Track, position: tuple[float, float], velocity: tuple[float, float] = (0.0, 0.0)) -> Track:
    """Put a track somewhere, at a velocity [m/s] that is known to 0.1 m/s."""
    track.state = MotionState(np.array([*position, *velocity, 0.0]), 0.01 * np.eye(5))
    return track


@pytest.mark.parametrize(
    ("period", "hits", "confirmed"), [(0.25, 3, True), (0.26, 3, False), (0.1, 2, False), (0.26, 9, False)]
)
def test_three_hits_within_half_a_second_confirm(period: float, hits: int, confirmed: bool) -> None:
    assert seen(0.0, (hits - 1) * period, period=period).confirmed is confirmed


def missed_until_its_end(track: Track, period: float = 0.1) -> float:
    """Let frames in which the track should be pass without a hit, and return how long it was believed in [s]."""
    last, time = track.last_hit, track.last_hit
    while track.reason_to_end(time) is None:
        time += period
        track.advance(time)
        track.miss(scan(time))
    assert "in view without a hit" in (track.reason_to_end(time) or "")
    return time - last


@pytest.mark.parametrize(("posture", "life"), [(Posture.WALKING, 1.5), (Posture.STANDING, 3.0), (Posture.SEATED, 10.0)])
def test_in_view_without_a_hit_a_track_lives_as_long_as_its_posture_allows(posture: Posture, life: float) -> None:
    track = seen(0.0, 2.0)
    track.posture.stance = STANCES[posture]
    assert missed_until_its_end(track) == pytest.approx(life + 0.1, abs=1e-6)


@pytest.mark.parametrize("posture", list(Posture))
def test_a_track_of_less_than_two_seconds_lives_for_0_6_seconds_whatever_its_posture(posture: Posture) -> None:
    track = seen(0.0, 1.9)
    track.posture.stance = STANCES[posture]
    assert missed_until_its_end(track) == pytest.approx(0.7, abs=1e-6)


@pytest.mark.parametrize(("posture", "life"), [(Posture.WALKING, 3.0), (Posture.STANDING, 3.0), (Posture.SEATED, 10.0)])
def test_outside_every_view_a_track_lives_three_seconds_and_a_seated_one_ten(posture: Posture, life: float) -> None:
    track = seen(0.0, 2.0)
    track.posture.stance = STANCES[posture]
    spread = []
    for tenth in range(1, round(10.0 * life) + 1):
        track.advance(2.0 + 0.1 * tenth)
        spread.append(float(np.trace(track.state.position_covariance)))
        assert track.reason_to_end(track.time) is None
    assert np.all(np.diff(spread) > 0.0)
    assert "outside every view" in (track.reason_to_end(2.1 + life) or "")


def seated() -> Track:
    """Return a track of somebody on the couch, last hit at 2 s."""
    track = seen(0.0, 2.0)
    track.posture.stance = STANCES[Posture.SEATED]
    return track


def look(track: Track, times: Sequence[float], *seats: str, camera: str = "ceiling") -> list[float]:
    """Let frames of a camera pass that hit nobody and show seats to be empty; return the times before its end [s]."""
    lived = []
    for time in times:
        track.advance(time)
        track.note_seat(replace(scan(time, camera=camera), empty_seats=seats))
        if track.reason_to_end(time) is None:
            lived.append(time)
    return lived


def tenths(since: float, until: float) -> list[float]:
    return [0.1 * k for k in range(round(10.0 * since), round(10.0 * until) + 1)]


def test_who_sits_on_a_seat_that_a_camera_shows_to_be_empty_for_a_second_is_gone() -> None:
    track = seated()
    assert look(track, tenths(2.1, 4.0), "couch")[-1] == pytest.approx(3.0)
    assert track.reason_to_end(4.0) == "its seat was seen to be empty for 1.90 s by ceiling"
    assert look(seated(), tenths(2.1, 4.0), "chair") == tenths(2.1, 4.0)
    assert look(seated(), tenths(2.1, 4.0)) == tenths(2.1, 4.0)


def test_an_empty_seat_ends_nobody_who_stands() -> None:
    track = seated()
    track.posture.stance = STANCES[Posture.STANDING]
    assert look(track, tenths(2.1, 4.0), "couch") == tenths(2.1, 4.0)


def test_one_frame_that_does_not_show_the_seat_empty_begins_the_second_anew_and_another_camera_does_not() -> None:
    track = seated()
    assert look(track, tenths(2.1, 3.0), "couch")[-1] == pytest.approx(3.0)
    assert look(track, [3.05], camera="door") and look(track, [3.1], "couch") == []
    track = seated()
    look(track, tenths(2.1, 3.0), "couch")
    look(track, [3.1])
    assert look(track, tenths(3.2, 5.0), "couch")[-1] == pytest.approx(4.1)


def test_the_second_begins_anew_after_a_hit_and_after_a_pause_of_the_camera() -> None:
    track = seated()
    look(track, tenths(2.1, 3.0), "couch")
    track.hit(scan(3.05, camera="onboard"), 0)
    assert look(track, tenths(3.1, 5.0), "couch")[-1] == pytest.approx(4.0)
    track = seated()
    look(track, tenths(2.1, 3.0), "couch")
    assert look(track, tenths(3.4, 5.0), "couch")[-1] == pytest.approx(4.3)
    assert look(seated(), [2.25 + 0.25 * k for k in range(8)], "couch")[-1] == pytest.approx(3.0)


def test_a_younger_track_with_a_later_hit_takes_back_that_the_seat_is_empty() -> None:
    older, younger = seated(), seen(2.6, 2.8, camera="onboard")
    look(older, tenths(2.1, 2.9), "couch")
    older.absorb(younger)
    assert look(older, tenths(3.0, 5.0), "couch")[-1] == pytest.approx(3.9)


def test_what_was_between_two_frames_far_apart_is_not_counted_as_missed() -> None:
    """A camera that comes back after two seconds has not looked for two seconds."""
    track = seen(0.0, 2.0)
    track.posture.stance = STANCES[Posture.WALKING]
    track.advance(4.0)
    track.miss(scan(4.0))
    assert track.missed_for == 0.25
    assert track.reason_to_end(4.0) is None


def test_a_hit_starts_the_count_of_misses_anew() -> None:
    track = seen(0.0, 2.0)
    for time in (2.1, 2.2, 2.3):
        track.advance(time)
        track.miss(scan(time))
    assert track.missed_for == pytest.approx(0.3)
    track.hit(scan(2.3), 0)
    assert track.missed_for == 0.0


@pytest.mark.parametrize(("distance", "same"), [(0.39, True), (0.41, False)])
def test_two_tracks_of_one_velocity_are_one_person_if_closer_than_0_4_metres(distance: float, same: bool) -> None:
    older, younger = seen(0.0, 2.0, camera="east"), seen(0.05, 2.05, camera="west")
    moving(older, (0.0, 0.0), (0.5, 0.0))
    assert moving(younger, (0.0, distance), (0.5, 0.0)).is_duplicate_of(older) is same


@pytest.mark.parametrize(("speed", "same"), [(0.3, True), (0.5, False), (-0.5, False)])
def test_two_who_pass_each_other_closely_are_two_people(speed: float, same: bool) -> None:
    """The difference of the velocities is known to 0.14 m/s on each axis; 3 deviations are 0.43 m/s."""
    older, younger = seen(0.0, 2.0, camera="east"), seen(0.05, 2.05, camera="west")
    moving(older, (0.0, 0.0))
    assert moving(younger, (0.0, 0.2), (speed, 0.0)).is_duplicate_of(older) is same


def test_two_whom_one_image_showed_are_two_people_once_both_are_confirmed() -> None:
    older = moving(seen(0.0, 2.0), (0.0, 0.0))
    confirmed, on_trial = seen(1.5, 2.0, (0.3, 0.0)), seen(1.9, 2.0, (0.3, 0.0))
    assert confirmed.confirmed and not on_trial.confirmed
    assert not moving(confirmed, (0.3, 0.0)).is_duplicate_of(older)
    assert moving(on_trial, (0.3, 0.0)).is_duplicate_of(older)
    assert moving(seen(1.55, 2.05, camera="west"), (0.3, 0.0)).is_duplicate_of(older)


def test_two_on_one_seat_are_one_person_unless_an_image_showed_both() -> None:
    older = moving(seen(0.0, 2.0, camera="east"), (4.3, 0.8))
    elsewhere, beside = (seen(1.0, 2.0, camera=camera) for camera in ("west", "east"))
    for track in (older, elsewhere, beside):
        track.posture.stance = STANCES[Posture.SEATED]
    assert moving(elsewhere, (5.7, 0.8)).is_duplicate_of(older)
    assert not moving(beside, (5.7, 0.8)).is_duplicate_of(older)
    elsewhere.posture.stance = STANCES[Posture.STANDING]
    assert not elsewhere.is_duplicate_of(older)


@pytest.mark.parametrize(("apart", "before", "same"), [(0.43, 0.0, True), (0.47, 0.0, False), (0.1, 0.6, True)])
def test_two_whom_an_image_showed_on_one_seat_are_two_people_if_they_have_room_beside_one_another(
    apart: float, before: float, same: bool
) -> None:
    """The last pair are feet before the seat, and a body on it that another camera sees along the seat."""
    older, younger = seen(0.0, 2.0), seen(0.05, 2.0)
    for track in (older, younger):
        track.posture.stance = STANCES[Posture.SEATED]
        track.hit(scan(2.1), 0)
    moving(older, (5.0, 0.9 - before))
    assert moving(younger, (5.0 + apart, 0.9)).is_duplicate_of(older) is same


def lost(track: Track, duration: float) -> Track:
    """Let frames pass in which the track should be and is not."""
    for tenth in range(1, round(10.0 * duration) + 1):
        track.advance(2.0 + 0.1 * tenth)
        track.miss(scan(track.time))
    return track


@pytest.mark.parametrize(("distance", "same"), [(0.95, True), (1.05, False)])
def test_who_appears_within_a_metre_of_somebody_just_lost_is_that_person(distance: float, same: bool) -> None:
    older = moving(lost(seen(0.0, 2.0), 0.5), (0.0, 0.0))
    assert seen(2.1, 2.5, (distance, 0.0)).continues(older) is same


def test_nobody_goes_on_as_somebody_who_is_still_seen_or_was_seen_beside_them_or_came_long_ago() -> None:
    assert seen(2.1, 2.5, (0.9, 0.0)).continues(lost(seen(0.0, 2.0), 0.3))
    assert not seen(2.1, 2.5, (0.9, 0.0)).continues(lost(seen(0.0, 2.0), 0.2))
    assert not seen(1.9, 2.5, (0.9, 0.0)).continues(lost(seen(0.0, 2.0), 0.5))  # the frame at 1.9 s showed both
    assert seen(1.9, 2.5, (0.9, 0.0), camera="west").continues(lost(seen(0.0, 2.0), 0.5))
    assert not seen(0.4, 2.5, (0.9, 0.0), camera="west").continues(lost(seen(0.0, 2.0), 0.5))
    assert not seen(2.4, 2.5, (0.9, 0.0)).continues(lost(seen(0.0, 2.0), 0.5))  # on trial


def test_who_appears_anywhere_at_a_seat_whose_sitter_was_lost_is_the_sitter() -> None:
    older = moving(lost(seen(0.0, 2.0), 0.5), (4.3, 0.8))
    up = seen(2.1, 2.5, (6.5, 0.5))
    assert not up.continues(older)
    older.posture.stance = STANCES[Posture.SEATED]
    assert up.continues(older)
