"""The layers: who costs what, where."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.costmap.body import BodyLayer
from han_bullet.costmap.grid import FREE, INSCRIBED, LETHAL, UNKNOWN, Costmap
from han_bullet.costmap.inflation import InflationLayer
from han_bullet.costmap.interaction import InteractionLayer
from han_bullet.costmap.layer import Layer
from han_bullet.costmap.layers import standard_layers
from han_bullet.costmap.oncoming import OncomingLayer
from han_bullet.costmap.overtake import OvertakeLayer
from han_bullet.costmap.personal_still import PersonalStillLayer
from han_bullet.costmap.personal_walking import PersonalWalkingLayer
from han_bullet.costmap.static import StaticLayer
from han_bullet.costmap.visibility import VisibilityLayer
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Pose2D, SolidBox
from han_bullet.messages import Device, GoTo, HandOver, Posture, Scene, Seat, TrackedPerson
from han_bullet.planning.astar import astar

STANDING, WALKING, SEATED = Posture.STANDING, Posture.WALKING, Posture.SEATED
ROOM = [((0.0, 10.0), (0.0, 10.0))]
COUCH = Seat("couch", np.array([5.0, 5.0]), -0.5 * math.pi, 0.8, 1.9, "tv")


def person(
    posture: Posture = STANDING,
    at: tuple[float, float] = (5.0, 5.0),
    velocity: tuple[float, float] = (0.0, 0.0),
    heading: float | None = None,
    deviation: float = 0.05,
    seat: str | None = None,
) -> TrackedPerson:
    covariance = deviation**2 * np.eye(4)
    return TrackedPerson(3, 0.0, np.array(at), np.array(velocity), covariance, posture, heading, seat)


def box(x: float, y: float, sx: float, sy: float, bottom: float = 0.0, yaw: float = 0.0) -> SolidBox:
    return SolidBox("box", "object", np.array([x, y, bottom + 0.4]), np.array([sx, sy, 0.8]), yaw)


def room() -> Costmap:
    return Costmap.covering(ROOM, 0.05)


def costs(layer: Layer, scene: Scene, *points: tuple[float, float]) -> list[int]:
    """Costs at points after one layer on an empty 10 x 10 m room."""
    costmap = room()
    layer.apply(costmap, scene)
    return [int(cost) for cost in costmap.cost_at(np.array(points))]


def g(*exponents: float) -> float:
    return 252.0 * math.exp(-0.5 * sum(exponents))


def test_a_box_blocks_every_cell_that_it_touches_and_no_other() -> None:
    costmap = room()
    StaticLayer([box(5.0, 5.0, 1.0, 0.42)]).apply(costmap, Scene(0.0))
    rows, columns = np.nonzero(costmap.cost == LETHAL)
    # x from 4.5 to 5.5 m lies on cell borders: 20 columns. y from 4.79 to 5.21 m cuts into cells: 10 rows.
    assert (columns.min(), columns.max(), rows.min(), rows.max()) == (90, 109, 95, 104)
    assert len(rows) == 200
    assert np.array_equal(costmap.building, costmap.cost)


@given(yaw=st.floats(-3.2, 3.2), x=st.floats(2.0, 8.0), y=st.floats(2.0, 8.0))
@settings(max_examples=20, deadline=None)
def test_a_turned_box_blocks_every_cell_that_holds_one_of_its_points(yaw: float, x: float, y: float) -> None:
    costmap, turned = room(), box(x, y, 1.3, 0.7, yaw=yaw)
    StaticLayer([turned]).apply(costmap, Scene(0.0))
    u, v = np.meshgrid(np.linspace(-0.649, 0.649, 40), np.linspace(-0.349, 0.349, 30))
    c, s = math.cos(yaw), math.sin(yaw)
    inside = np.stack([x + c * u - s * v, y + s * u + c * v], axis=-1)
    assert (costmap.cost_at(inside) == LETHAL).all()
    far = costmap.cell_to_world(np.argwhere(costmap.cost == LETHAL))
    assert turned.contains(far, margin=0.0354).all()


def test_a_box_that_hangs_above_the_robot_is_no_obstacle() -> None:
    costmap = room()
    StaticLayer([box(3.0, 5.0, 1.0, 1.0, bottom=1.3), box(7.0, 5.0, 1.0, 1.0, bottom=0.6)]).apply(costmap, Scene(0.0))
    assert costmap.cost_at(np.array([[3.0, 5.0], [7.0, 5.0]])).tolist() == [FREE, LETHAL]


def test_the_robot_touches_a_wall_up_to_its_radius_and_the_cost_decays_to_the_inflation_radius() -> None:
    costmap = room()
    StaticLayer([box(5.0, 5.0, 1.0, 1.0)]).apply(costmap, Scene(0.0))
    InflationLayer(robot_radius=0.3, inflation_radius=0.55, cost_scaling_factor=10.0).apply(costmap, Scene(0.0))
    at = costmap.cost_at(np.array([[5.525, 5.0], [5.775, 5.0], [5.825, 5.0], [5.925, 5.0], [6.025, 5.0], [6.075, 5.0]]))
    # Cell centres 0.025, 0.275, 0.325, 0.425, 0.525 and 0.575 m off the face.
    expected = [INSCRIBED, INSCRIBED, *(round(252 * math.exp(-10 * d)) for d in (0.025, 0.125, 0.225)), FREE]
    assert at.tolist() == expected


def test_a_robot_in_a_free_cell_overlaps_no_corner_of_a_box() -> None:
    costmap, obstacle = room(), box(5.0, 5.0, 1.0, 1.0)
    StaticLayer([obstacle]).apply(costmap, Scene(0.0))
    InflationLayer(robot_radius=0.3).apply(costmap, Scene(0.0))
    free = costmap.cell_to_world(np.argwhere(costmap.cost < INSCRIBED))
    gap = np.hypot(*np.maximum(np.abs(free - 5.0) - 0.5, 0.0).T)
    assert 0.3 < gap.min() < 0.34


def test_the_edge_of_the_floor_is_inflated_like_a_wall() -> None:
    costmap = Costmap.covering([((0.0, 4.0), (-1.5, 1.5))], 0.05)
    InflationLayer(robot_radius=0.3).apply(costmap, Scene(0.0))
    assert costmap.cost_at(np.array([[2.0, 1.21], [2.0, 1.19], [0.21, 0.0], [2.0, 0.0]])).tolist()[0] == INSCRIBED
    assert 0 < costmap.cost_at(np.array([2.0, 1.19])) < INSCRIBED
    assert costmap.cost_at(np.array([2.0, 0.0])) == FREE


def test_inflation_follows_a_building_that_changes() -> None:
    layer = InflationLayer(robot_radius=0.3)
    first, second = room(), room()
    StaticLayer([box(3.0, 3.0, 1.0, 1.0)]).apply(first, Scene(0.0))
    StaticLayer([box(7.0, 7.0, 1.0, 1.0)]).apply(second, Scene(0.0))
    layer.apply(first, Scene(0.0))
    layer.apply(second, Scene(0.0))
    assert second.cost_at(np.array([[7.6, 7.0], [3.6, 3.0]])).tolist() == [INSCRIBED, FREE]


@pytest.mark.parametrize(("deviation", "radius"), [(0.01, 0.65), (0.08, 0.71), (0.5, 0.75)])
def test_the_body_disc_holds_both_bodies_and_two_deviations_between_10_and_20_centimetres(
    deviation: float, radius: float
) -> None:
    scene = Scene(0.0, (person(at=(5.0, 5.0), deviation=deviation),))
    costmap = room()
    BodyLayer(robot_radius=0.3).apply(costmap, scene)
    lethal = costmap.cell_to_world(np.argwhere(costmap.cost == LETHAL))
    distance = np.hypot(*(lethal - 5.0).T)
    assert radius - 0.04 < distance.max() <= radius
    assert costmap.building.max() == FREE


def test_personal_space_of_a_walker_is_longest_ahead_and_grows_with_speed() -> None:
    slow = person(WALKING, velocity=(0.35, 0.0), heading=0.0)
    ahead, behind, side = (6.025, 5.025), (3.975, 5.025), (5.025, 6.025)
    got = costs(PersonalWalkingLayer(), Scene(0.0, (slow,)), ahead, behind, side)
    small = (0.025 / (0.8 * 2 / 3)) ** 2
    want = [g((1.025 / 0.8) ** 2, small), g((1.025 / 0.4) ** 2, small), g((1.025 / (1.6 / 3)) ** 2, (0.025 / 0.8) ** 2)]
    assert got == pytest.approx(want, abs=0.51)
    fast = person(WALKING, velocity=(1.5, 0.0), heading=0.0)
    assert costs(PersonalWalkingLayer(), Scene(0.0, (fast,)), ahead)[0] == pytest.approx(
        g((1.025 / 1.5) ** 2, (0.025 / 1.0) ** 2), abs=0.51
    )


def test_a_walker_without_a_heading_is_taken_to_face_along_the_velocity() -> None:
    layer = PersonalWalkingLayer()
    north = person(WALKING, velocity=(0.0, 0.4), heading=None)
    assert costs(layer, Scene(0.0, (north,)), (5.025, 6.025)) > costs(layer, Scene(0.0, (north,)), (6.025, 5.025))
    same = person(WALKING, velocity=(0.0, 0.4), heading=0.5 * math.pi)
    points = ((5.5, 6.0), (4.2, 5.1), (5.0, 4.3))
    assert costs(layer, Scene(0.0, (north,)), *points) == costs(layer, Scene(0.0, (same,)), *points)


@pytest.mark.parametrize("posture", [STANDING, SEATED])
def test_personal_space_of_a_still_person_is_round_with_a_tenth_left_at_1_2_metres(posture: Posture) -> None:
    points = [(5.0 + 1.2 * math.cos(a), 5.0 + 1.2 * math.sin(a)) for a in np.linspace(0.0, 6.0, 9)]
    got = costs(PersonalStillLayer(), Scene(0.0, (person(posture),)), *points)
    assert got == pytest.approx([25.3] * 9, abs=3.0)  # a cell centre is up to 0.035 m nearer or farther
    assert costs(PersonalStillLayer(), Scene(0.0, (person(WALKING, velocity=(0.4, 0.0)),)), *points) == [0] * 9


def test_the_hand_over_opens_22_5_degrees_to_either_side_from_0_6_metres_on() -> None:
    task = HandOver(np.array([5.0, 5.0]), person=3, heading=0.5 * math.pi)
    layer = PersonalStillLayer()

    def at(distance: float, degrees: float, scene: Scene) -> int:
        angle = math.radians(90.0 + degrees)
        return costs(layer, scene, (5.0 + distance * math.cos(angle), 5.0 + distance * math.sin(angle)))[0]

    asked = Scene(0.0, (person(),), task=task)
    assert at(0.9, 0.0, asked) == at(0.9, 19.0, asked) == at(0.9, -19.0, asked) == at(0.66, 0.0, asked) == FREE
    assert min(at(0.9, 27.0, asked), at(0.9, -27.0, asked), at(0.9, 180.0, asked), at(0.54, 0.0, asked)) > 60
    somebody_else = Scene(0.0, (person(),), task=HandOver(np.array([5.0, 5.0]), person=7, heading=0.5 * math.pi))
    assert at(0.9, 0.0, somebody_else) > 60


def test_the_space_behind_a_seated_person_costs_and_the_space_in_front_does_not() -> None:
    scene = Scene(0.0, (person(SEATED, heading=-0.5 * math.pi, seat="couch"),), seats=(COUCH,))
    behind, beside, front = (5.025, 6.225), (5.825, 5.025), (5.025, 4.775)
    got = costs(VisibilityLayer(), scene, behind, beside, front)
    want = [g((1.225 / 1.2) ** 2, (0.025 / 0.8) ** 2), g((0.025 / 1.2) ** 2, (0.825 / 0.8) ** 2), 0.0]
    assert got == pytest.approx(want, abs=0.51)
    two_metres = costs(VisibilityLayer(), scene, (5.025, 7.025))[0]
    assert two_metres / 252 <= 0.25


def test_a_seated_person_without_a_heading_faces_as_the_seat_does_and_standing_ones_have_no_behind() -> None:
    unknown = Scene(0.0, (person(SEATED, seat="couch"),), seats=(COUCH,))
    known = Scene(0.0, (person(SEATED, heading=-0.5 * math.pi, seat="couch"),), seats=(COUCH,))
    assert costs(VisibilityLayer(), unknown, (5.2, 6.0)) == costs(VisibilityLayer(), known, (5.2, 6.0)) != [0]
    assert costs(VisibilityLayer(), Scene(0.0, (person(heading=0.0),)), (4.0, 5.0)) == [0]


def test_a_lobe_thinner_than_a_cell_ends_at_the_same_cells_wherever_in_the_cell_the_person_stands() -> None:
    edges = set()
    for x in np.linspace(5.001, 5.024, 9):
        costmap = room()
        seated = person(SEATED, at=(float(x), 5.0), heading=math.pi)
        VisibilityLayer().apply(costmap, Scene(0.0, (seated,)))
        edges.add(int(np.nonzero(costmap.cost)[1].min()))
    assert edges == {100}


def test_the_disc_between_a_person_and_the_tv_costs_only_while_the_tv_is_on() -> None:
    def scene(on: bool, posture: Posture = SEATED) -> Scene:
        tv = Device("tv", np.array([5.0, 2.0]), on)
        return Scene(0.0, (person(posture, heading=-0.5 * math.pi, seat="couch"),), (tv,), (COUCH,))

    middle, rim_inside, rim_outside = (5.0, 3.5), (6.4, 3.5), (6.6, 3.5)
    layer = InteractionLayer()
    assert costs(layer, scene(True), middle, rim_inside, rim_outside) == [227, 227, 0]
    assert costs(layer, scene(False), middle) == [0]
    assert costs(layer, scene(True, STANDING), middle) == [0]


@pytest.mark.parametrize(("pass_side", "closed", "open_"), [("left", 4.0, 6.0), ("right", 6.0, 4.0)])
def test_the_side_on_which_one_does_not_overtake_is_closed(pass_side: str, closed: float, open_: float) -> None:
    walker = Scene(0.0, (person(WALKING, velocity=(0.4, 0.0), heading=0.0),))
    got = costs(OvertakeLayer(pass_side=pass_side), walker, (5.0, closed), (5.0, open_))
    assert got[0] == pytest.approx(g((1.0 / 1.5) ** 2), abs=6.0) and got[1] == 0
    assert costs(OvertakeLayer(pass_side=pass_side), Scene(0.0, (person(heading=0.0),)), (5.0, closed)) == [0]


postures = st.sampled_from([STANDING, WALKING, SEATED])
places = st.tuples(st.floats(-1.0, 11.0), st.floats(-1.0, 11.0))
headings = st.one_of(st.none(), st.floats(-3.2, 3.2))


@given(people=st.lists(st.tuples(postures, places, headings), max_size=3), background=st.integers(0, 255))
@settings(max_examples=25, deadline=None)
def test_no_layer_ever_lowers_a_cost_or_makes_a_social_one_block(
    people: list[tuple[Posture, tuple[float, float], float | None]], background: int
) -> None:
    tracks = tuple(person(posture, at, (0.3, 0.2), heading, seat="couch") for posture, at, heading in people)
    robot = Pose2D(3.0, 6.0, 0.0)
    scene = Scene(0.0, tracks, (Device("tv", np.array([5.0, 2.0]), True),), (COUCH,), pose_robot_in_world=robot)
    for layer in standard_layers([box(2.0, 2.0, 1.0, 1.0)], robot_radius=0.3):
        costmap = room()
        costmap.cost[40:90, 30:120] = background
        before = costmap.cost.copy()
        layer.apply(costmap, scene)
        assert (costmap.cost >= before).all()
        if layer.name not in {"static", "inflation", "body"}:
            assert costmap.cost[before < INSCRIBED].max() < INSCRIBED


def met(robot: tuple[float, float], *people: TrackedPerson) -> Scene:
    """People, and a robot that may meet them."""
    return Scene(0.0, people, pose_robot_in_world=Pose2D(*robot, 0.0))


def test_whoever_comes_towards_the_robot_costs_from_where_they_meet_as_far_as_they_get_in_4_seconds() -> None:
    """They are 7 m apart and close in at 1.5 m/s: they meet 4.67 m from the robot, and 4 s are 2 m, 1.33 m before."""
    scene = met((1.0, 5.0), person(WALKING, (8.0, 5.0), (-0.5, 0.0)))
    layer = OncomingLayer(robot_speed=1.0, side=0.53)
    assert min(costs(layer, scene, *((x, 5.0) for x in (5.6, 5.0, 4.4)))) == 252
    assert costs(layer, scene, (5.0, 5.53), (5.0, 4.47), (5.0, 6.06)) == pytest.approx([g(1.0), g(1.0), g(4.0)], abs=4)
    # A cell of 0.05 m nearer to the walker is 0.075 m farther behind where they will be.
    assert costs(layer, scene, (6.02, 5.0), (3.98, 5.0)) == pytest.approx([g(1.0), g(1.0)], abs=24)
    assert max(costs(layer, scene, (7.0, 5.0), (3.0, 5.0))) < g(7.0)


def test_the_robot_passes_behind_whoever_crosses_its_way() -> None:
    """It could be on their way after 4 s, when they are 2 m farther on, at y = 5; the next 2 m are theirs."""
    scene = met((2.0, 5.0), person(WALKING, (6.0, 7.0), (0.0, -0.5)))
    layer = OncomingLayer(robot_speed=1.0, side=0.53)
    assert min(costs(layer, scene, (6.0, 5.0), (6.0, 4.0), (6.0, 3.2))) >= 247
    assert max(costs(layer, scene, (6.0, 6.6), (6.0, 7.0), (6.0, 8.0))) < g(7.0)
    way = planned(OncomingLayer(robot_speed=1.0), scene, (10.0, 5.0))
    assert 5.7 < np.interp(6.0, way[:, 0], way[:, 1]) < 7.5


def planned(layer: Layer, scene: Scene, goal: tuple[float, float]) -> Array:
    """The cheapest way through an empty room with one layer, (n, 2) [m]."""
    costmap = room()
    layer.apply(costmap, scene)
    assert scene.pose_robot_in_world is not None
    way = astar(costmap, scene.pose_robot_in_world.position, np.array(goal) - 0.01)
    assert way is not None
    return way.points_in_world


def test_a_faster_robot_meets_people_sooner() -> None:
    scene = met((2.0, 5.0), person(WALKING, (6.0, 7.0), (0.0, -0.5)))
    assert costs(OncomingLayer(robot_speed=2.0), scene, (6.0, 6.0))[0] >= 247  # after 2 s
    assert costs(OncomingLayer(robot_speed=0.5), scene, (6.0, 5.0))[0] < g(3.0)  # after 8 s they are at y = 3


@given(robot=places, walker=places, heading=st.floats(-4.0, 4.0), speed=st.floats(0.2, 1.5), row=st.integers(0, 199))
@settings(max_examples=50, deadline=None)
def test_the_way_of_a_walker_costs_what_its_definition_says(
    robot: tuple[float, float], walker: tuple[float, float], heading: float, speed: float, row: int
) -> None:
    costmap, direction = room(), np.array([math.cos(heading), math.sin(heading)])
    scene = met(robot, person(WALKING, walker, (speed * direction[0], speed * direction[1]), heading))
    OncomingLayer(robot_speed=0.8, horizon=3.0, side=0.4, amplitude=0.9).apply(costmap, scene)
    for column in range(0, 200, 7):
        place = costmap.cell_to_world(np.array([row, column]))
        there = np.array(walker) + speed * math.dist(place, robot) / 0.8 * direction
        way = there + np.linspace(0.0, 3.0, 2000)[:, None] * speed * direction
        nearest = np.hypot(*(way - place).T).min()
        expected = 252.0 * 0.9 * math.exp(-0.5 * (nearest / 0.4) ** 2)
        assert costmap.cost[row, column] == pytest.approx(expected, abs=0.6)


def test_who_goes_the_robots_own_way_is_overtaken_and_not_met() -> None:
    robot = Pose2D(1.0, 5.0, 0.0)
    for degrees, meets in ((0.0, False), (40.0, False), (-40.0, False), (50.0, True), (90.0, True), (180.0, True)):
        velocity = (0.5 * math.cos(math.radians(degrees)), 0.5 * math.sin(math.radians(degrees)))
        walker = person(WALKING, (4.0, 5.0), velocity, math.radians(degrees))
        costmap = room()
        scene = Scene(0.0, (walker,), task=GoTo(Pose2D(9.0, 5.0, 1.0)), pose_robot_in_world=robot)
        OncomingLayer(robot_speed=1.0).apply(costmap, scene)
        assert bool(costmap.cost.any()) is meets, degrees


@pytest.mark.parametrize("trembling", [(0.01, 0.0), (-0.01, 0.0), (0.0, 0.01), (0.0, -0.01)])
def test_a_robot_at_its_goal_meets_nobody_wherever_its_place_trembles(trembling: tuple[float, float]) -> None:
    robot = Pose2D(1.0 + trembling[0], 5.0 + trembling[1], 0.0)
    scene = Scene(
        0.0,
        (person(WALKING, (4.0, 5.0), (0.5, 0.0)),),
        task=GoTo(Pose2D(1.0, 5.0, 0.0)),
        pose_robot_in_world=robot,
    )
    costmap = room()
    OncomingLayer(robot_speed=1.0).apply(costmap, scene)
    assert not costmap.cost.any()


@pytest.mark.parametrize("posture", [STANDING, SEATED])
def test_who_does_not_walk_has_no_way_before_them(posture: Posture) -> None:
    costmap = room()
    scene = met((1.0, 5.0), person(posture, (8.0, 5.0), (-0.5, 0.0)))
    OncomingLayer(robot_speed=1.0).apply(costmap, scene)
    assert not costmap.cost.any()


def test_without_a_robot_nobody_is_met() -> None:
    costmap = room()
    OncomingLayer(robot_speed=1.0).apply(costmap, Scene(0.0, (person(WALKING, (8.0, 5.0), (-0.5, 0.0)),)))
    assert not costmap.cost.any()


SOCIAL = (PersonalWalkingLayer, PersonalStillLayer, VisibilityLayer, InteractionLayer, OvertakeLayer)


@pytest.mark.parametrize("layer", SOCIAL)
@given(amplitude=st.floats(0.0, 1.0), opening=st.booleans())
@settings(max_examples=20, deadline=None)
def test_the_amplitude_of_a_social_layer_multiplies_its_costs(
    layer: type[PersonalStillLayer], amplitude: float, opening: bool
) -> None:
    tracks = (person(WALKING, (2.0, 3.0), (0.4, 0.1)), person(SEATED, seat="couch"), person(at=(8.0, 7.0)))
    task = HandOver(np.array([8.0, 7.0]), person=3, heading=0.5) if opening else None
    scene = Scene(0.0, tracks, (Device("tv", np.array([5.0, 2.0]), True),), (COUCH,), task)
    whole, part = room(), room()
    layer().apply(whole, scene)
    layer(amplitude=amplitude).apply(part, scene)
    assert whole.cost.max() > 200
    assert np.abs(part.cost - amplitude * whole.cost).max() <= 1.0  # both are rounded
    if amplitude == 0.0:
        assert not part.cost.any()


def test_the_standard_layers_come_in_order_and_can_be_left_out() -> None:
    in_order = [
        "static", "obstacle", "inflation", "body", "personal_walking", "personal_still", "visibility", "interaction",
        "overtake", "oncoming",
    ]  # fmt: skip
    assert [layer.name for layer in standard_layers([], robot_radius=0.3)] == in_order
    chosen = standard_layers([], robot_radius=0.3, without=["overtake", "static"])
    assert [layer.name for layer in chosen] == [*in_order[1:-2], "oncoming"]


def test_a_world_may_set_a_layers_numbers() -> None:
    layers = standard_layers([], robot_radius=0.3, parameters={"personal_still": {"deviation": 0.8}})
    still = next(layer for layer in layers if isinstance(layer, PersonalStillLayer))
    assert still.deviation == 0.8


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"without": ["overtaking"]}, "'overtaking' is not known; there are static, obstacle, inflation"),
        ({"parameters": {"visbility": {}}}, "'visbility' is not known"),
        ({"parameters": {"visibility": {"beta": 1.0}}}, "unknown parameter 'beta'; it has behind, side, front"),
        ({"parameters": {"body": {"robot_radius": 1.0}}}, "unknown parameter 'robot_radius'"),
        ({"parameters": {"obstacle": {"obstacle_range": -1.0}}}, r"layer obstacle: obstacle_range is -1\.0"),
        ({"parameters": {"static": {"boxes": 1.0}}}, "unknown parameter 'boxes'; it has none"),
        (
            {"parameters": {"inflation": {"inflation_radius": 0.7}}},
            "'inflation_radius' is 0.7 under layers; inflation_radius and cost_scaling_factor are set in the costmap",
        ),
        ({"parameters": {"inflation": {"cost_scaling_factor": 5.0}}}, "'cost_scaling_factor' is 5.0 under layers"),
        ({"parameters": {"inflation": {"robot_radius": 0.2}}}, "'robot_radius' is 0.2 under layers"),
        ({"parameters": {"personal_still": {"deviation": -0.5}}}, r"deviation is -0\.5"),
        ({"parameters": {"interaction": {"gamma": 1.5}}}, r"gamma is 1\.5"),
        (
            {"parameters": {"overtake": {"amplitude": 1.1}}},
            r"layer overtake: amplitude is 1\.1; it must lie in \[0, 1\]",
        ),
        ({"parameters": {"visibility": {"amplitude": -0.1}}}, r"amplitude is -0\.1"),
        ({"parameters": {"interaction": {"amplitude": math.nan}}}, "amplitude is nan"),
        ({"parameters": {"body": {"smallest_margin": 0.4}}}, r"smallest_margin is 0\.4"),
        ({"inflation_radius": 0.2}, r"inflation_radius is 0\.2"),
        ({"pass_side": "middle"}, "'middle'; it must be 'left' or 'right'"),
    ],
)
def test_wrong_names_and_values_are_refused_with_what_would_be_right(
    arguments: dict[str, object], message: str
) -> None:
    with pytest.raises(BadInputError, match=message):
        standard_layers([], robot_radius=0.3, **arguments)  # type: ignore[arg-type]


def test_people_off_the_map_cost_nothing_and_break_nothing() -> None:
    scene = Scene(0.0, (person(at=(40.0, -30.0)), person(WALKING, at=(-9.0, 5.0), velocity=(0.4, 0.0))))
    costmap = Costmap.covering([((0.0, 2.0), (0.0, 2.0)), ((2.0, 4.0), (1.0, 2.0))], 0.05)
    for layer in standard_layers([], robot_radius=0.3, without=["inflation"]):
        layer.apply(costmap, scene)
    assert set(np.unique(costmap.cost).tolist()) == {FREE, UNKNOWN}


@given(data=st.data())
@settings(max_examples=30, deadline=None)
def test_inflation_of_what_has_changed_is_inflation_of_the_whole(data: st.DataObject) -> None:
    places = st.tuples(st.floats(-0.2, 10.2), st.floats(-0.2, 10.2))
    layer = InflationLayer(robot_radius=0.3)
    for _ in range(3):
        boxes = [box(x, y, 0.3, 0.2) for x, y in data.draw(st.lists(places, max_size=3))]
        changed, whole = room(), room()
        for costmap, inflation in ((changed, layer), (whole, InflationLayer(robot_radius=0.3))):
            StaticLayer([box(5.0, 5.0, 1.0, 1.0), *boxes]).apply(costmap, Scene(0.0))
            inflation.apply(costmap, Scene(0.0))
        assert np.array_equal(changed.cost, whole.cost)
