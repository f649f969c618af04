import pytest

from han_bullet.variation import vary
from han_bullet.world_file import load_world
from han_bullet.world_schema import SeedVariation, Walk

WORLD = load_world("real2")


def test_the_same_seed_gives_the_same_world() -> None:
    assert vary(WORLD, 7) == vary(WORLD, 7)


def test_different_seeds_move_what_the_world_lets_them_move() -> None:
    one, other = vary(WORLD, 1), vary(WORLD, 2)
    assert one.robot.start != other.robot.start
    assert one.people[0].start != other.people[0].start
    assert one.light != other.light
    assert one.image_noise != other.image_noise


@pytest.mark.parametrize("seed", range(20))
def test_no_seed_leaves_the_ranges_of_the_world(seed: int) -> None:
    world, limits = vary(WORLD, seed), WORLD.seed_varies
    walk, original = world.people[0].behaviour, WORLD.people[0].behaviour
    assert isinstance(walk, Walk) and isinstance(original, Walk)
    assert abs(world.robot.start[0] - WORLD.robot.start[0]) <= limits.robot_start
    assert abs(world.people[0].start[1] - WORLD.people[0].start[1]) <= limits.person_start
    assert abs(walk.speed / original.speed - 1.0) <= limits.speed
    assert 0.0 <= walk.starts.delay - original.starts.delay <= limits.start_delay
    assert limits.image_noise[0] <= world.image_noise <= limits.image_noise[1]


def test_a_world_that_varies_nothing_stays_as_it_is() -> None:
    still = SeedVariation(
        robot_start=0, person_start=0, heading=0, speed=0, start_delay=0, image_noise=(0, 0), light=False, outfits=False
    )
    world = WORLD.model_copy(update={"seed_varies": still})
    assert vary(world, 3) == world


def test_switching_one_variation_off_leaves_the_others_draws_alone() -> None:
    limits = WORLD.seed_varies.model_copy(update={"light": False})
    assert vary(WORLD.model_copy(update={"seed_varies": limits}), 5).people == vary(WORLD, 5).people
