"""Where people of which height may stand."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from han_bullet.detection.acf import AcfDetector
from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.detector import Detector
from han_bullet.detection.nms import suppress
from han_bullet.detection.pedestrian_detector import PedestrianDetector
from han_bullet.detection.scales import level_sizes
from han_bullet.detection.scan_limits import BOX_TOLERANCE, SHORTEST_SEATED, ScanLimits, limits_on_floor
from han_bullet.detection.search_area import Both, SearchArea
from han_bullet.errors import BadInputError
from han_bullet.geometry import Intrinsics, Pose2D, camera_on_robot, look_at, project
from han_bullet.messages import Detections

INTRINSICS = Intrinsics.from_vertical_field_of_view(640, 480, math.radians(45.0))
CEILING = look_at(np.array([0.2, 0.0, 2.6]), np.array([6.2, 0.0, 0.9]))
ROOM = 0.5  # [px] a row's own height


def permissive_model(depth: int = 2) -> AcfModel:
    """Trees that let a good part of the windows through."""
    rng = np.random.default_rng(4)
    features = rng.integers(0, 5120, (8, 2**depth - 1)).astype(np.int32)
    thresholds = np.where(features % 10 < 3, 0.4, 0.02).astype(np.float32)
    return AcfModel(features, thresholds, rng.normal(0.0, 0.7, (8, 2**depth)).astype(np.float32), (0.0, 0.1, 0.1))


def allows(limits: ScanLimits, feet: float, height: float) -> bool:
    """Whether a box that ends in a row and has a height [px] is allowed."""
    return bool(limits.allow_boxes(np.array([[0.0, feet - height, 1.0, height]]))[0])


IMAGE = np.kron(np.random.default_rng(9).integers(0, 256, (15, 17, 3), dtype=np.uint8), np.ones((20, 20, 1), np.uint8))


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.floats(50, 400), min_size=2, max_size=400),
    st.lists(st.floats(0, 200), min_size=400, max_size=400),
    st.sampled_from([2, 3]),
)
def test_a_limited_scan_is_the_whole_scan_filtered_by_the_same_limits(
    least: list[float], room: list[float], depth: int
) -> None:
    limits = ScanLimits(np.array(least), np.array(least) + np.array(room[: len(least)]))
    detector = AcfDetector(permissive_model(depth))
    whole, limited = detector.scan(IMAGE), detector.scan(IMAGE, limits)
    heights = whole.boxes[:, 3]
    rows = np.minimum(np.maximum(whole.boxes[:, 1] + heights, 0.0), limits.least.size - 1).astype(int)
    allowed = (limits.least[rows] <= heights) & (heights <= limits.greatest[rows])
    assert len(whole.boxes) > 100
    assert np.array_equal(limited.boxes, whole.boxes[allowed])
    assert np.array_equal(limited.scores, whole.scores[allowed])
    assert limited.windows <= whole.windows
    assert limited.trees <= whole.trees


@given(
    st.one_of(st.tuples(st.just(True), st.floats(1.0, 2.6)), st.tuples(st.just(False), st.floats(2.0, 3.5))),
    st.floats(1.5, 2.0),
)
def test_a_box_that_ends_at_the_lower_edge_above_the_feet_is_allowed_while_most_of_the_person_shows(
    place: tuple[bool, float], size: float
) -> None:
    on_robot, ahead = place  # so near that the feet, and not the head, are below the image
    camera = camera_on_robot(Pose2D(0.2, 0.0, 0.0), 0.0, 1.2, 0.05) if on_robot else CEILING
    limits = limits_on_floor(INTRINSICS, camera, shortest=SHORTEST_SEATED)
    pixels, depths = project(np.array([[0.2 + ahead, 0.0, 0.0], [0.2 + ahead, 0.0, size]]), INTRINSICS, camera)
    foot, head = pixels[:, 1]
    assume(depths.min() > 0.0 and foot > 480.0 and 0.0 < head < 480.0)
    assume((480.0 - head) / (foot - head) > 0.6)
    assert allows(limits, 480.0, 480.0 - head)


class RandomArea(SearchArea):
    """Allows each box or not, by its place and size alone."""

    def __init__(self, seed: int, share: float, left: float, right: float) -> None:
        self.seed, self.share, self.left, self.right = seed, share, left, right

    def windows(self, x: np.ndarray, y: np.ndarray, width: float, height: float) -> np.ndarray:
        there = (self.left <= x[np.newaxis, :]) & (x[np.newaxis, :] <= self.right) & (height > 0.0)
        lot = np.sin(self.seed + 12.9 * x[np.newaxis, :] + 78.2 * y[:, np.newaxis] + 37.7 * height + width)
        return there & (lot * 43758.5 % 1.0 < self.share)


@settings(max_examples=30, deadline=None)
@given(
    st.integers(0, 99),
    st.floats(0.0, 1.0),
    st.floats(-20.0, 340.0),
    st.floats(0.0, 300.0),
    st.sampled_from([(300, 340), (320, 352)]),
)
def test_what_a_detector_proposes_in_an_area_is_the_whole_scan_filtered_before_suppression(
    seed: int, share: float, left: float, across: float, shape: tuple[int, int]
) -> None:
    proposer = AcfDetector(permissive_model())
    image = np.zeros((*shape, 3), np.uint8)
    image[:300, :340] = IMAGE
    area = RandomArea(seed, share, left, left + across)
    whole, found = proposer.scan(image), proposer.scan(image, area)
    allowed = area.allow_boxes(whole.boxes)
    assert np.array_equal(found.boxes, whole.boxes[allowed])
    assert np.array_equal(found.scores, whole.scores[allowed])
    proposals = PedestrianDetector(proposer, None, -math.inf).propose(image, area)
    kept = suppress(whole.boxes[allowed], whole.scores[allowed])
    assert np.array_equal(proposals.boxes, whole.boxes[allowed][kept])


def test_a_detector_that_knows_no_areas_proposes_what_they_allow() -> None:
    class Two(Detector):
        def detect(self, image: np.ndarray) -> Detections:
            return Detections(np.array([[10.0, 10, 40, 100], [90, 10, 40, 100]]), np.array([2.0, 1]), np.ones(2))

    left = RandomArea(0, 1.0, 0.0, 50.0)
    assert len(Two().propose(IMAGE).boxes) == 2
    assert Two().propose(IMAGE, left).boxes.tolist() == [[10.0, 10.0, 40.0, 100.0]]
    assert Two().propose(IMAGE, Both(left, RandomArea(0, 1.0, 60.0, 99.0))).boxes.shape == (0, 4)


@given(st.floats(-math.pi, math.pi), st.floats(2.5, 9.0), st.floats(-1.0, 1.0), st.floats(1.2, 1.45))
def test_who_sits_is_allowed_from_every_side(facing: float, ahead: float, aside: float, crown: float) -> None:
    limits = limits_on_floor(INTRINSICS, CEILING, shortest=SHORTEST_SEATED)
    seat = np.array([ahead, aside])
    toes = seat + 0.55 * np.array([math.cos(facing), math.sin(facing)])
    # The lowest part that shows is the feet, or the body's back over the floor beneath the seat.
    points = np.array([[*toes, 0.0], [*seat, 0.0], [*seat, crown]])
    pixels, depths = project(points, INTRINSICS, CEILING)
    assert depths.min() > 0.0
    lowest, top = pixels[:2, 1].max(), pixels[2, 1]
    assume(lowest < 480.0)
    assert allows(limits, lowest, lowest - top)


def test_limits_that_allow_everything_change_nothing_and_that_allow_nothing_leave_nothing() -> None:
    detector = AcfDetector(permissive_model())
    whole = detector.scan(IMAGE)
    everything = detector.scan(IMAGE, ScanLimits(np.zeros(1), np.full(1, np.inf)))
    nothing = detector.scan(IMAGE, ScanLimits(np.full(1, np.inf), np.zeros(1)))
    assert np.array_equal(everything.boxes, whole.boxes)
    assert (everything.windows, everything.trees) == (whole.windows, whole.trees)
    assert (nothing.windows, nothing.trees, len(nothing.boxes)) == (0, 0, 0)
    sizes = level_sizes(*IMAGE.shape[:2], (100, 41))
    assert whole.windows == sum((size.rows + 8 - 31) * (size.columns + 6 - 15) for size in sizes)
    assert whole.windows < whole.trees < 8 * whole.windows


def test_a_ceiling_camera_spares_half_of_the_windows() -> None:
    detector = AcfDetector(permissive_model())
    image = np.random.default_rng(2).integers(0, 256, (480, 640, 3), dtype=np.uint8)
    whole, limited = detector.scan(image), detector.scan(image, limits_on_floor(INTRINSICS, CEILING))
    assert whole.windows == 73_888
    assert 10_000 < limited.windows < 0.5 * whole.windows
    assert limited.trees < 0.6 * whole.trees


@given(st.floats(2.5, 15.0), st.floats(-1.0, 1.0), st.floats(1.4, 2.1), st.floats(-0.3, 0.3))
def test_every_person_on_the_floor_is_allowed_and_shorter_or_taller_things_are_not(
    ahead: float, aside: float, size: float, roll: float
) -> None:
    camera = CEILING.copy()
    turn = np.array([[math.cos(roll), -math.sin(roll), 0], [math.sin(roll), math.cos(roll), 0], [0, 0, 1]])
    camera[:3, :3] = CEILING[:3, :3] @ turn
    limits = limits_on_floor(INTRINSICS, camera)
    pixels, depths = project(np.array([[ahead, aside, 0.0], [ahead, aside, size]]), INTRINSICS, camera)
    assert depths.min() > 0.0
    (u, foot), (_, head) = pixels
    assume(0.0 <= u <= 640.0 and 0.0 <= foot < 590.0)
    height = foot - head
    assert allows(limits, foot, height)
    if roll == 0.0:
        assert not allows(limits, foot, height * 0.5 * 1.4 / size)
        assert not allows(limits, foot, height * 1.5 * 2.1 / size)


def test_a_person_of_two_metres_at_six_has_the_height_that_the_lens_gives() -> None:
    level = look_at(np.array([0.0, 0.0, 1.0]), np.array([6.0, 0.0, 1.0]))
    limits = limits_on_floor(INTRINSICS, level, shortest=2.0, tallest=2.0)
    row = math.floor(240 + INTRINSICS.fy * 1.0 / 6.0)
    expected = 2.0 * INTRINSICS.fy / 6.0  # 193.1 px
    assert limits.least[row] == pytest.approx((1 - BOX_TOLERANCE) * expected, abs=2 * ROOM)
    assert limits.greatest[row] == pytest.approx((1 + BOX_TOLERANCE) * expected, abs=2 * ROOM)


def test_nobody_stands_above_the_horizon() -> None:
    level = look_at(np.array([0.0, 0.0, 1.0]), np.array([6.0, 0.0, 1.0]))
    limits = limits_on_floor(INTRINSICS, level)
    assert limits.least.shape == (600,)
    assert not any(allows(limits, *each) for each in ((0.0, 100.0), (100.0, 10.0), (239.0, 1.0)))
    assert np.all(limits.least[:240] > limits.greatest[:240])
    assert np.all(limits.least[241:] < limits.greatest[241:])


@pytest.mark.parametrize(
    ("shortest", "tallest"), [(0.0, 2.0), (2.0, 1.0), (-1.0, 2.0), (1.0, math.inf), (math.nan, 2.0)]
)
def test_people_of_impossible_heights_are_bad_input(shortest: float, tallest: float) -> None:
    with pytest.raises(BadInputError, match="two positive heights"):
        limits_on_floor(INTRINSICS, CEILING, shortest, tallest)


@pytest.mark.parametrize(
    ("least", "greatest"),
    [(np.zeros(3), np.zeros(4)), (np.zeros(0), np.zeros(0)), (np.zeros((2, 2)), np.zeros((2, 2)))],
)
def test_limits_of_different_lengths_are_bad_input(least: np.ndarray, greatest: np.ndarray) -> None:
    with pytest.raises(BadInputError, match="scan limits of shapes"):
        ScanLimits(least, greatest)


def test_limits_that_are_no_numbers_are_bad_input() -> None:
    with pytest.raises(BadInputError, match="no numbers"):
        ScanLimits(np.array([np.nan]), np.array([1.0]))
