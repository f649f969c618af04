"""OSPA and ID switches on cases computed by hand."""

import math

import numpy as np
import pytest

from benchmarks.track_quality import TrackQuality, ospa

NOBODY = np.zeros((0, 2))


def test_the_ospa_of_one_track_is_its_distance_up_to_the_cut_off() -> None:
    assert ospa(np.array([[1.0, 0.3]]), np.array([[1.0, 0.0]])) == pytest.approx(0.3)
    assert ospa(np.array([[1.0, 5.0]]), np.array([[1.0, 0.0]])) == 1.0


def test_a_missing_or_a_superfluous_track_counts_as_the_cut_off() -> None:
    people = np.array([[0.0, 0.0], [3.0, 0.0]])
    assert ospa(people[:1], people) == pytest.approx(math.sqrt(0.5))
    assert ospa(people, people[:1]) == pytest.approx(math.sqrt(0.5))
    assert ospa(NOBODY, people) == ospa(people, NOBODY) == 1.0
    assert ospa(NOBODY, NOBODY) == 0.0


def test_tracks_are_paired_with_the_least_sum_of_squares_whatever_their_order() -> None:
    people = np.array([[0.0, 0.0], [2.0, 0.0]])
    tracks = np.array([[2.0, 0.4], [0.3, 0.0]])
    assert ospa(tracks, people) == ospa(tracks[::-1], people) == pytest.approx(math.sqrt((0.09 + 0.16) / 2))


def test_order_and_cut_off_are_those_asked_for() -> None:
    people = np.array([[0.0, 0.0], [9.0, 0.0]])
    tracks = np.array([[0.5, 0.0], [9.0, 3.0]])
    assert ospa(tracks, people, cut_off=2.0, order=1.0) == pytest.approx((0.5 + 2.0) / 2)


def test_two_tracks_that_swap_people_are_two_id_switches() -> None:
    left, right = np.array([0.0, 0.0]), np.array([4.0, 0.0])
    quality, people = TrackQuality(), np.array([left, right])
    quality.record({7: left, 8: right}, people)
    assert quality.id_switches == 0
    quality.record({7: right, 8: left}, people)
    assert quality.id_switches == 2
    assert quality.ospa == [0.0, 0.0]


def test_a_person_found_again_is_a_switch_only_under_another_id() -> None:
    here, people = np.array([0.0, 0.0]), np.array([[0.0, 0.5]])
    quality = TrackQuality()
    for tracks in ({}, {3: here}, {}, {3: here}):
        quality.record(tracks, people)
    assert quality.id_switches == 0
    quality.record({4: here}, people)
    assert quality.id_switches == 1
    assert quality.ospa == pytest.approx([1.0, 0.5, 1.0, 0.5, 0.5])


def test_a_track_more_than_a_metre_off_is_nobodys() -> None:
    quality, people = TrackQuality(), np.array([[0.0, 0.0]])
    quality.record({1: np.array([0.0, 0.2])}, people)
    quality.record({2: np.array([0.0, 1.1])}, people)
    assert quality.id_switches == 0
