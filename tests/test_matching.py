"""Which detections are people: held against a reference written from the toolbox's rules, loop by loop."""

import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.detection.evaluation import judge
from han_bullet.detection.matching import assign, fix_aspect, in_ignored, match

PERSON = np.array([[0.0, 0.0, 41.0, 100.0]])
NOBODY = np.empty((0, 4))


def test_boxes_keep_height_and_centre_and_become_narrow() -> None:
    assert fix_aspect(np.array([[10.0, 20.0, 60.0, 100.0]]))[0] == pytest.approx([19.5, 20.0, 41.0, 100.0])


def test_a_second_detection_of_the_same_person_is_false() -> None:
    assert match(np.repeat(PERSON, 2, axis=0), PERSON).tolist() == [True, False]


def test_a_detection_takes_the_person_it_overlaps_most_and_leaves_the_other_to_the_next() -> None:
    people = np.array([[0.0, 0.0, 40.0, 100.0], [10.0, 0.0, 40.0, 100.0]])
    assert match(np.array([[9.0, 0.0, 40.0, 100.0], [1.0, 0.0, 40.0, 100.0]]), people).tolist() == [True, True]
    assert match(np.array([[9.0, 0.0, 40.0, 100.0], [60.0, 0.0, 40.0, 100.0]]), people).tolist() == [True, False]


def test_each_detection_is_told_whom_it_takes() -> None:
    people = np.array([[0.0, 0.0, 40.0, 100.0], [10.0, 0.0, 40.0, 100.0]])
    boxes = np.array([[9.0, 0.0, 40.0, 100.0], [8.0, 0.0, 40.0, 100.0], [90.0, 0.0, 40.0, 100.0]])
    assert assign(boxes, people).tolist() == [1, 0, -1]
    assert assign(boxes, NOBODY).tolist() == [-1, -1, -1]


def test_without_people_every_detection_is_false() -> None:
    assert match(PERSON, NOBODY).tolist() == [False]


def test_an_ignored_region_swallows_what_lies_in_it_by_half_of_its_own_area_any_number_of_times() -> None:
    region = np.array([[0.0, 0.0, 400.0, 100.0]])
    boxes = np.array([[0.0, 0, 41, 100], [300.0, 0, 41, 100], [0.0, 49, 41, 100], [0.0, 51, 41, 100]])
    assert in_ignored(boxes, region).tolist() == [True, True, True, False]
    assert in_ignored(boxes, NOBODY).tolist() == [False] * 4


def test_a_detection_in_an_ignored_region_counts_only_if_it_hits_a_person() -> None:
    region = np.array([[0.0, 0.0, 400.0, 100.0]])
    boxes = np.array([[0.0, 0, 41, 100], [0.0, 0, 41, 100], [300.0, 0, 41, 100], [300.0, 200, 41, 100]])
    judged = judge(boxes, np.array([2.0, 4.0, 3.0, 1.0]), PERSON, region)
    assert (judged.scores.tolist(), judged.hits.tolist(), judged.people) == ([4.0, 1.0], [True, False], 1)


def reference(boxes: np.ndarray, scores: np.ndarray, people: np.ndarray, ignored: np.ndarray) -> list[tuple]:
    """Score and outcome, 1 hit, 0 false, of the detections that count, as the toolbox's evaluation describes it."""

    def area(box: np.ndarray) -> float:
        return float(box[2] * box[3])

    def shared(a: np.ndarray, b: np.ndarray) -> float:
        across = min(a[0] + a[2], b[0] + b[2]) - max(a[0], b[0])
        down = min(a[1] + a[3], b[1] + b[3]) - max(a[1], b[1])
        return float(across * down) if across > 0 and down > 0 else 0.0

    narrow = [np.array([x + w / 2 - 0.41 * h / 2, y, 0.41 * h, h]) for x, y, w, h in people]
    taken, outcomes = set(), []
    for number in sorted(range(len(boxes)), key=lambda n: -scores[n]):
        box, best, chosen = boxes[number], 0.5, None
        for candidate, person in enumerate(narrow):
            overlap = shared(box, person) / (area(box) + area(person) - shared(box, person))
            if candidate not in taken and overlap >= best and (chosen is None or overlap > best):
                best, chosen = overlap, candidate
        if chosen is not None:
            taken.add(chosen)
            outcomes.append((scores[number], 1))
        elif not any(shared(box, region) / area(box) >= 0.5 for region in ignored):
            outcomes.append((scores[number], 0))
    return outcomes


def boxes_of(count: int) -> st.SearchStrategy[np.ndarray]:
    box = st.tuples(st.integers(0, 60), st.integers(0, 60), st.integers(10, 50), st.integers(20, 100))
    return st.lists(box, max_size=count).map(lambda rows: np.array(rows, float).reshape(-1, 4))


@settings(max_examples=300, deadline=None)
@given(boxes_of(12), boxes_of(4), boxes_of(3), st.randoms(use_true_random=False))
def test_judging_equals_the_reference(
    boxes: np.ndarray, people: np.ndarray, ignored: np.ndarray, draw: random.Random
) -> None:
    shift = np.array([2.0, 3.0, 0.0, 0.0])
    boxes = np.concatenate([boxes, fix_aspect(people) + shift, ignored + shift])  # or hits would be rare
    scores = np.array(draw.sample(range(100), len(boxes)), float)
    judged = judge(boxes, scores, people, ignored)
    found = list(zip(judged.scores.tolist(), judged.hits.astype(int).tolist(), strict=True))
    assert found == reference(boxes, scores, people, ignored)
