"""Scenes drawn for sequences: people and robot keep out of each other's way, and every kind of scene comes up."""

import itertools
import math

import pytest

from han_bullet.rendered_takes import LANES, Take, corridor_takes, couch_takes, onboard_takes
from han_bullet.sim.simulator import Simulator
from han_bullet.world_schema import Sit, Stand, Walk


def takes(seed: int = 0) -> list[Take]:
    return [*itertools.islice(corridor_takes(seed), 30), *itertools.islice(onboard_takes(seed), 30)]


def test_people_start_and_turn_inside_the_corridor_and_beside_the_robot_s_lane() -> None:
    for take in takes():
        assert len(take.world.people) in (2, 3)
        for person in take.world.people:
            points = [person.start[:2]]
            if isinstance(person.behaviour, Walk):
                points += person.behaviour.waypoints
            for x, y in points:
                assert 0.4 < x < 22.6
                assert abs(y) < 1.2
                assert abs(y - take.robot_lane.y) > 0.8 - 0.15 - 1e-9  # a start is moved by up to 0.15 m


def test_people_stand_and_walk_along_and_across_in_front_of_all_three_corridor_cameras() -> None:
    drawn = list(itertools.islice(corridor_takes(0), 30))
    assert {take.camera.name for take in drawn} == {"camera1", "camera2", "camera3"}
    behaviours = [person.behaviour for take in drawn for person in take.world.people]
    walks = [behaviour.waypoints for behaviour in behaviours if isinstance(behaviour, Walk)]
    along = [ends for ends in walks if ends[0][1] == ends[1][1]]
    across = [ends for ends in walks if ends[0][0] == ends[1][0]]
    assert len(along) + len(across) == len(walks)
    assert min(len(along), len(across)) >= 10
    assert sum(isinstance(behaviour, Stand) for behaviour in behaviours) >= 15
    assert all(LANES[0] <= y <= LANES[-1] for ends in walks for _, y in ends)


def test_each_take_has_its_own_light_noise_and_clothes_and_the_same_seed_the_same_takes() -> None:
    drawn = takes()
    assert len({take.world.light.direction for take in drawn}) == len(drawn)
    assert len({take.world.image_noise for take in drawn}) == len(drawn)
    assert {person.outfit for take in drawn for person in take.world.people} == set(range(8))
    assert {person.build for take in drawn for person in take.world.people} == {"slim", "broad"}
    assert takes() == drawn
    assert takes(1) != drawn


@pytest.mark.parametrize("number", range(4))
def test_the_robot_drives_along_its_lane_touching_nobody(number: int) -> None:
    take = next(itertools.islice(onboard_takes(5), number, None))
    lane, aside = take.robot_lane, []
    with Simulator(take.world, renderer=None) as simulator:
        simulator.reset()
        start = simulator.truth.pose_robot_in_world
        for _ in range(80):
            truth = simulator.truth
            aside.append(lane.to_body(truth.pose_robot_in_world.position)[1])
            assert not truth.contacts
            simulator.step(take.command(truth.pose_robot_in_world, truth.time))
        end = simulator.truth.pose_robot_in_world
    along = lane.to_body(end.position)[0] - lane.to_body(start.position)[0]
    assert along == pytest.approx(0.4 * 4.0, abs=0.25)
    assert max(map(abs, aside)) < 0.25  # [m] from the lane's middle
    assert abs(math.remainder(end.yaw - lane.yaw, 2.0 * math.pi)) < 0.5


def test_the_couch_holds_one_seated_person_before_camera4() -> None:
    (take,) = itertools.islice(couch_takes(0), 1)
    (person,) = take.world.people
    assert isinstance(person.behaviour, Sit)
    assert take.camera.name == "camera4"
