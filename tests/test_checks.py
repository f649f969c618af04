import numpy as np
import pytest

from han_bullet.checks import check_expectations, check_world
from han_bullet.coverage import coverages
from han_bullet.errors import BadInputError
from han_bullet.metrics import Metric
from han_bullet.static_map import static_costmap
from han_bullet.world_file import load_world
from han_bullet.world_schema import Expectation, World

WORLD = load_world("real2")


def with_person_at(x: float, y: float) -> World:
    person = WORLD.people[0].model_copy(update={"start": (x, y, 0.0)})
    return WORLD.model_copy(update={"people": (person,)})


def test_the_shipped_worlds_pass() -> None:
    for name in ("real2", "sim1"):
        check_world(load_world(name), name)


@pytest.mark.parametrize(("x", "y", "what"), [(4.0, 1.4, "wall"), (19.5, -0.4, "couch"), (-3.0, 0.0, "no floor")])
def test_a_person_who_starts_where_nobody_can_stand_is_refused(x: float, y: float, what: str) -> None:
    with pytest.raises(BadInputError, match=rf"my.yaml: people\[0\].start: .*{what}"):
        check_world(with_person_at(x, y), "my.yaml")


def test_a_person_who_starts_inside_the_robot_is_refused() -> None:
    with pytest.raises(BadInputError, match=r"people\[0\].start: walker stands 0.14 m from the robot's start"):
        check_world(with_person_at(1.6, 0.1), "my.yaml")


def test_a_robot_needs_more_room_than_a_person() -> None:
    check_world(with_person_at(4.0, 1.23), "my.yaml")
    robot = WORLD.robot.model_copy(update={"start": (4.0, 1.23, 0.0)})
    with pytest.raises(BadInputError, match=r"robot.start"):
        check_world(WORLD.model_copy(update={"robot": robot}), "my.yaml")


def test_the_static_map_is_free_in_the_corridor_and_closed_outside() -> None:
    costmap = static_costmap(WORLD)
    costs = costmap.cost_at(np.array([[5.0, 0.0], [5.0, 1.5], [5.0, 3.0]]))
    assert costs[0] == 0 and costs[1] >= 253 and costs[2] == 255


def test_camera_one_sees_whole_people_along_the_first_half_of_the_corridor_only() -> None:
    one = next(coverage for coverage in coverages(WORLD) if coverage.camera == "camera1")
    assert one.x is not None
    assert 2.5 < one.x[0] < 4.5
    assert 8.0 < one.x[1] < 11.5
    assert one.area > 10.0


def test_every_place_of_the_corridor_beyond_the_first_metres_is_seen_by_some_ceiling_camera() -> None:
    spans = [c.x for c in coverages(WORLD) if c.camera in {"camera1", "camera2", "camera3"}]
    for x in np.arange(4.0, 15.0, 0.5):
        assert any(span is not None and span[0] <= x <= span[1] for span in spans), x


METRICS = [
    Metric("outcome", "arrived", "", "d"),
    Metric("minimum_distance.walker", 0.8, "m", "d"),
    Metric("overtaking_side.walker", None, "", "d"),
]


@pytest.mark.parametrize(
    ("expectation", "passed"),
    [
        (Expectation(metric="outcome", equals="arrived"), True),
        (Expectation(metric="outcome", equals="blocked"), False),
        (Expectation(metric="minimum_distance.walker", at_least=0.75), True),
        (Expectation(metric="minimum_distance.walker", at_least=0.85), False),
        (Expectation(metric="minimum_distance.walker", at_most=0.75), False),
        (Expectation(metric="minimum_distance.walker", at_least=0.7, at_most=0.9), True),
        (Expectation(metric="overtaking_side.walker", equals="left"), False),
    ],
)
def test_an_expectation_is_met_within_its_range_and_not_outside(expectation: Expectation, passed: bool) -> None:
    (check,) = check_expectations([expectation], METRICS)
    assert check.passed is passed


def test_a_value_is_judged_as_it_is_written() -> None:
    six_periods = [Metric("stalled_time", 6 * 0.05, "s", "")]  # 0.30000000000000004
    (check,) = check_expectations([Expectation(metric="stalled_time", at_most=0.3)], six_periods)
    assert (check.passed, check.value) == (True, 0.3)
    assert not check_expectations([Expectation(metric="stalled_time", at_most=0.299999)], six_periods)[0].passed


def test_an_expectation_on_an_unknown_metric_is_refused() -> None:
    with pytest.raises(BadInputError, match=r"'applause' is no metric"):
        check_expectations([Expectation(metric="applause", at_least=1.0)], METRICS)


def test_bounds_are_written_as_people_write_them() -> None:
    metrics = [Metric("ospa", 0.25, "m", "")]
    (check,) = check_expectations([Expectation(metric="ospa", at_least=0.0, at_most=0.5)], metrics)
    assert check.expected == ">= 0 and <= 0.5"
