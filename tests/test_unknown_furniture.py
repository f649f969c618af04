"""Furniture that the robot's map does not have, and furniture that is taken away: who has it and who has not."""

import dataclasses

import numpy as np
import pytest

from han_bullet.errors import BadInputError
from han_bullet.geometry import SolidBox, Twist2D
from han_bullet.messages import Truth
from han_bullet.sim.renderer import Renderer
from han_bullet.sim.simulator import Simulator
from han_bullet.static_map import static_costmap
from han_bullet.world_file import load_world
from han_bullet.world_schema import Furniture, Trigger, World
from tests.ticks import make_world

CRATE = {"name": "crate", "position": [3.0, 0.0], "size": [0.5, 0.5, 0.5], "known": False}
PLACE = np.array([3.0, 0.0])


def world(**changes: object) -> World:
    return make_world(furniture=[CRATE | changes], robot={"start": [1.0, 0.0, 0.0], "laser": {"noise": 0.0}})


def names(boxes: tuple[SolidBox, ...]) -> list[str]:
    return [box.name for box in boxes]


def test_the_map_lacks_what_is_not_known_and_the_world_has_it() -> None:
    there, fleeting = world(), world(until={"when": "time", "delay": 1.0})
    assert names(there.solid_boxes()) == [] and names(world(known=True).solid_boxes()) == ["crate"]
    assert names(there.all_boxes()) == names(there.lasting_boxes()) == ["crate"]
    assert names(fleeting.all_boxes()) == ["crate"] and names(fleeting.lasting_boxes()) == []
    assert static_costmap(there).cost_at(PLACE) > 0 == static_costmap(fleeting).cost_at(PLACE)


def test_what_is_on_the_map_cannot_be_taken_away() -> None:
    with pytest.raises(BadInputError, match="crate is on the robot's map, which never changes"):
        world(known=True, until={"when": "time"})


def test_until_it_is_taken_away_the_laser_sees_it_and_the_robot_bumps_into_it() -> None:
    truths: list[Truth] = []
    ahead: list[float] = []
    with Simulator(world(until={"when": "time", "delay": 4.0}), renderer=None) as simulator:
        observation = simulator.reset()
        while observation.time < 6.0:
            if observation.laser is not None:
                ahead.append(float(observation.laser.ranges[len(observation.laser.ranges) // 2]))
            observation = simulator.step(Twist2D(0.8))
            truths.append(simulator.truth)
        assert simulator.render_state.taken_away == ("crate",)
        simulator.reset()
        assert simulator.truth.taken_away == ()
    before = [truth for truth in truths if truth.time < 4.0]
    assert ahead[0] == pytest.approx(3.0 - 0.25 - 1.2, abs=1e-3)
    assert any(contact.body == "crate" for truth in before for contact in truth.contacts)
    assert all(truth.taken_away == () for truth in before)
    assert truths[-1].taken_away == ("crate",) and not truths[-1].contacts
    assert truths[-1].pose_robot_in_world.x > 3.0
    assert ahead[-1] > 3.0


def test_pictures_show_it_until_then_and_then_what_was_behind() -> None:
    crate = Furniture(name="crate", position=(4.0, 0.0), size=(0.6, 0.6, 0.8), known=False, until=Trigger())
    real2 = load_world("real2").model_copy(update={"people": (), "image_noise": 0.0})
    pictured = real2.model_copy(update={"furniture": (*real2.furniture, crate)})
    with Simulator(real2, renderer=None) as simulator:
        simulator.reset()
        state = simulator.render_state
    gone = dataclasses.replace(state, taken_away=("crate",))
    with_crate, without = Renderer(pictured, 0), Renderer(real2, 0)
    for camera in ("camera1", "onboard"):
        there, after = with_crate.render(camera, state), with_crate.render(camera, gone)
        assert (there != after).any(axis=-1).sum() > 200
        assert np.array_equal(after, without.render(camera, state))
    with_crate.close()
    without.close()
