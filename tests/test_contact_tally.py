"""Who hit whom."""

import dataclasses
import math

import pytest
from ticks import person, tick

from han_bullet.geometry import Twist2D
from han_bullet.messages import Contact
from han_bullet.metrics.contacts import ContactTally
from han_bullet.sim.simulator import Simulator
from han_bullet.world_file import load_world
from han_bullet.world_schema import Person, Stand, Walk

TOUCH = [Contact("walker", "person", -0.001)]


def counts(*ticks: object) -> tuple[object, object]:
    tally = ContactTally()
    for one in ticks:
        tally.record(one)  # type: ignore[arg-type]
    values = tally.values()
    return values["contacts_person"], values["contacts_by_person"]


@pytest.mark.parametrize(
    ("twist", "hit"),
    [
        ((0.3, 0.0, 0.0), (1, 0)),  # the robot drives into somebody
        ((0.0, 0.0, 0.0), (0, 1)),  # somebody walks into a robot that stands,
        ((0.0, 0.0, 1.0), (0, 1)),  # or turns on the spot,
        ((0.04, 0.0, 0.0), (0, 1)),  # or is held and jitters,
        ((-0.5, 0.0, 0.0), (0, 1)),  # or backs away
        ((0.05 * math.sqrt(2.0) + 0.01, 0.0, 0.0), (1, 0)),
    ],
)
def test_who_hit_is_told_by_the_robots_own_speed_towards_the_person(
    twist: tuple[float, float, float], hit: tuple[int, int]
) -> None:
    walker = [person(x=0.5, yaw=math.pi, speed=0.8)]
    assert counts(tick(0, twist=twist, people=walker), tick(1, twist=twist, people=walker, contacts=TOUCH)) == hit


def test_a_person_who_walks_into_the_flank_of_a_passing_robot_made_the_contact() -> None:
    comes, stands = [person(y=0.55, yaw=-math.pi / 2, speed=0.8)], [person(y=0.55)]
    assert counts(tick(0, twist=(0.8, 0.0, 0.0), people=comes, contacts=TOUCH)) == (0, 1)
    assert counts(tick(0, twist=(0.8, 0.0, 0.0), people=stands, contacts=TOUCH)) == (1, 0)  # grazed


def test_only_the_part_of_the_velocity_towards_the_person_counts() -> None:
    # At 60 degrees off its way: half of the speed is towards them, also where the base is turned.
    ahead = [person(x=0.275, y=0.476, yaw=-2.0 * math.pi / 3.0, speed=0.8)]
    assert counts(tick(0, twist=(0.12, 0.0, 0.0), people=ahead, contacts=TOUCH)) == (1, 0)
    assert counts(tick(0, robot=(0, 0, math.pi / 2), twist=(0.0, -0.12, 0.0), people=ahead, contacts=TOUCH)) == (1, 0)
    assert counts(tick(0, twist=(0.08, 0.0, 0.0), people=ahead, contacts=TOUCH)) == (0, 1)


def test_an_impact_that_stops_the_robot_within_its_tick_is_still_the_robots() -> None:
    someone = [person(x=0.5)]
    before, after = tick(0, twist=(0.6, 0.0, 0.0), people=someone), tick(1, people=someone, contacts=TOUCH)
    assert counts(before, after) == (1, 0)


def test_a_touch_that_lasts_stays_with_who_began_it() -> None:
    someone = [person(x=0.5)]
    begins = tick(0, people=someone, contacts=TOUCH)
    goes_on = [tick(i, twist=(0.3, 0.0, 0.0), people=someone, contacts=TOUCH) for i in range(1, 20)]
    assert counts(begins, *goes_on) == (0, 1)


@pytest.mark.parametrize(
    ("behaviour", "speed", "hit"),
    [(Stand(), 1.0, (1, 0)), (Walk(waypoints=((0.5, 0.0),), speed=0.8), 0.0, (0, 1))],
    ids=["the robot drives", "the person walks"],
)
def test_in_the_simulator_who_moves_has_hit(behaviour: Stand | Walk, speed: float, hit: tuple[int, int]) -> None:
    someone = Person(name="walker", start=(3.5, 0.0, math.pi), behaviour=behaviour)
    with Simulator(load_world("real2").model_copy(update={"people": (someone,)}), renderer=None) as simulator:
        simulator.reset()
        tally = ContactTally()
        for index in range(60):
            simulator.step(Twist2D(speed, 0.0, 0.0))
            tally.record(dataclasses.replace(tick(index), truth=simulator.truth))
    values = tally.values()
    assert (values["contacts_person"], values["contacts_by_person"]) == hit
