"""Which seats a fixed camera has in view, and when an image says that nobody sits there: on rendered people."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pytest

from han_bullet.detection.empty_seats import LARGEST_CHANGED_PART, SeatInView, seats_in_view
from han_bullet.detection.still_scene import StillScene
from han_bullet.geometry import Array, Intrinsics, Pose2D, SolidBox, look_at
from han_bullet.messages import Posture, Seat
from han_bullet.sim.gait import BodyPose, Gait
from han_bullet.sim.renderer import Renderer
from han_bullet.sim.scene_state import RobotPosture, SceneState
from han_bullet.variation import vary
from han_bullet.world_file import load_world
from han_bullet.world_schema import World

INTRINSICS = Intrinsics.from_vertical_field_of_view(640, 480, math.radians(45.0))
SEAT = Seat("couch", np.array([0.0, 0.0]), 0.0, 0.8, 1.9)
COUCH = SolidBox("couch", "object", np.array([0.0, 0.0, 0.4]), np.array([0.8, 1.9, 0.8]), 0.0)
MARGIN = 10.0  # by which sitters and an empty seat are to be on either side of the limit


def eye_at(x: float, y: float, target: tuple[float, float, float] = (0.0, 0.0, 0.5)) -> Array:
    return look_at(np.array([x, y, 2.5]), np.array(target))


def seen_from(x: float, y: float, *obstacles: SolidBox, seat: Seat = SEAT) -> tuple[SeatInView, ...]:
    return seats_in_view([seat], [COUCH, *obstacles], INTRINSICS, eye_at(x, y))


def test_a_seat_is_in_view_from_the_front_with_a_box_for_every_place_on_it() -> None:
    (couch,) = seen_from(4.0, 0.0)
    assert couch.name == "couch"
    x, _, width, height = couch.boxes.T
    assert len(couch.boxes) == 7
    assert x.min() >= 0.0 and (x + width).max() <= 640.0
    assert ((height > 150.0) & (height < 250.0) & (width < height)).all()
    assert np.allclose(x + 0.5 * width, (640.0 - (x + 0.5 * width))[::-1])  # from the middle, the same to both sides
    assert (np.abs(np.diff(x + 0.5 * width)) < 0.5 * width.min()).all()


def test_the_boxes_turn_with_the_seat() -> None:
    (couch,) = seen_from(4.0, 1.0)
    turned = replace(SEAT, facing=-0.5 * math.pi)
    (same,) = seats_in_view([turned], [replace(COUCH, yaw=-0.5 * math.pi)], INTRINSICS, eye_at(1.0, -4.0))
    assert np.allclose(couch.boxes, same.boxes)


def test_a_narrow_seat_has_one_place() -> None:
    (chair,) = seen_from(4.0, 0.0, seat=replace(SEAT, width=0.4))
    assert chair.boxes.shape == (1, 4)


@pytest.mark.parametrize(("x", "y"), [(-4.0, 0.0), (0.0, 4.0), (-2.0, -3.0)])
def test_from_behind_or_beside_the_couch_hides_too_much_of_who_sits_in_it(x: float, y: float) -> None:
    assert seen_from(x, y) == ()
    assert len(seats_in_view([SEAT], [], INTRINSICS, eye_at(x, y))) == 1


def test_furniture_before_the_seat_hides_it_and_a_wall_that_holds_the_camera_does_not() -> None:
    shelf = SolidBox("shelf", "object", np.array([1.5, 0.0, 0.8]), np.array([0.4, 2.0, 1.6]), 0.0)
    wall = SolidBox("wall", "wall", np.array([4.0, 0.0, 1.4]), np.array([0.1, 6.0, 2.8]), 0.0)
    assert seen_from(4.0, 0.0, shelf) == ()
    assert len(seen_from(4.0, 0.0, wall)) == 1


def test_a_seat_at_the_edge_of_the_image_behind_the_camera_or_far_away_is_not_in_view() -> None:
    assert seats_in_view([SEAT], [COUCH], INTRINSICS, eye_at(4.0, 0.0, (0.0, 2.2, 0.5))) == ()
    assert seats_in_view([SEAT], [COUCH], INTRINSICS, eye_at(4.0, 0.0, (8.0, 0.0, 4.5))) == ()
    assert len(seen_from(9.0, 0.0)) == 1
    assert seen_from(14.0, 0.0) == ()


@dataclass
class LivingRoom:
    """What camera4 sees of a world's couch."""

    world: World
    renderer: Renderer
    scene: StillScene
    couch: SeatInView
    frames: int = 0

    def changed(self, body: BodyPose | None, robot: Pose2D | None = None) -> float:
        """Return the largest part of a box on the couch that has changed."""
        self.frames += 1
        corridor = Pose2D(3.0, 0.0, 0.0)
        shown = self.body(corridor, Posture.STANDING) if body is None else body
        state = SceneState(0.0, self.frames, RobotPosture(robot or corridor), (shown,), (("tv", self.frames % 2 > 0),))
        changes = self.scene.changes(self.renderer.render("camera4", state))
        part = float(changes.part_of(self.couch.boxes).max())
        assert self.couch.is_empty(changes) is (part <= LARGEST_CHANGED_PART)
        return part

    def body(self, pose: Pose2D, posture: Posture) -> BodyPose:
        return Gait(self.world.people[0].build).advance(pose, 0.0, 0.05, posture)


@pytest.fixture(
    params=[("real3", 0), ("real3", 1), ("sim2", 0), ("sim2", 1)], ids=lambda param: f"{param[0]}-{param[1]}"
)
def room(request: pytest.FixtureRequest) -> Iterator[LivingRoom]:
    """A living room with the most noise that a seed gives; the only person is the one who sits."""
    name, seed = request.param
    varied = vary(load_world(name), seed)
    world = varied.model_copy(update={"people": varied.people[:1], "image_noise": 6.0})
    camera = world.camera("camera4")
    (couch,) = seats_in_view(world.seats(), world.solid_boxes(), camera.intrinsics, camera.camera_in_world)
    renderer = Renderer(world, seed)
    yield LivingRoom(world, renderer, StillScene(renderer.calibration_image("camera4"), np.zeros((0, 4))), couch)
    renderer.close()


def test_an_empty_couch_is_seen_to_be_empty_in_every_frame(room: LivingRoom) -> None:
    assert max(room.changed(None) for _ in range(20)) * MARGIN <= LARGEST_CHANGED_PART


def test_who_sits_anywhere_on_the_couch_is_never_said_not_to(room: LivingRoom) -> None:
    places = [Pose2D(19.5 + beside, -0.4, -0.5 * math.pi) for beside in (-0.7, -0.3, 0.0, 0.4, 0.7)]
    parts = [room.changed(room.body(place, Posture.SEATED)) for place in places]
    assert min(parts) > MARGIN * LARGEST_CHANGED_PART


def test_a_walker_or_the_robot_before_the_couch_blocks_the_statement_and_beside_it_does_not(room: LivingRoom) -> None:
    before, beside = Pose2D(19.6, -1.4, 0.0), Pose2D(22.0, -1.0, 0.0)
    assert room.changed(room.body(before, Posture.WALKING)) > MARGIN * LARGEST_CHANGED_PART
    assert room.changed(None, robot=before) > MARGIN * LARGEST_CHANGED_PART
    assert room.changed(room.body(beside, Posture.WALKING)) <= LARGEST_CHANGED_PART
    assert room.changed(None, robot=beside) <= LARGEST_CHANGED_PART
