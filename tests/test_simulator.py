import ast
from pathlib import Path

import numpy as np
import pybullet
import pytest

import han_bullet.sim
from han_bullet.device_payload import read_payload
from han_bullet.errors import BadInputError
from han_bullet.geometry import Twist2D, camera_on_robot
from han_bullet.messages import Observation, Posture, Truth
from han_bullet.sim.renderer import InProcessRenderer
from han_bullet.sim.simulator import Simulator
from han_bullet.world_file import load_world
from han_bullet.world_schema import Person, Sit, Stand, Trigger, Walk, World

FORWARD = Twist2D(1.0, 0.0, 0.0)


def real2(**changes: object) -> World:
    return load_world("real2").model_copy(update=changes)


def with_small_images(world: World) -> World:
    return world.model_copy(
        update={"cameras": tuple(camera.model_copy(update={"size": (160, 120)}) for camera in world.cameras)}
    )


def weave(tick: int) -> Twist2D:
    return Twist2D(0.8, 0.3 * float(np.sin(tick / 9.0)), 0.4 * float(np.cos(tick / 7.0)))


def test_twelve_physics_steps_make_a_tick_of_a_twentieth_of_a_second() -> None:
    with Simulator(real2(), renderer=None) as simulator:
        assert simulator.reset().time == 0.0
        times = [simulator.step(FORWARD).time for _ in range(20)]
        assert times == pytest.approx(np.arange(1, 21) * 0.05)
        assert simulator.truth.time == simulator.truth_time == times[-1]
        assert simulator.truth.twist_robot_in_body.vx == pytest.approx(1.0, abs=0.02)
        assert simulator.truth.pose_robot_in_world.x == pytest.approx(1.5 + 0.5, abs=0.02)


def test_frames_come_at_the_cameras_own_rate_and_say_where_the_camera_is() -> None:
    world = with_small_images(real2())
    world = world.model_copy(
        update={"cameras": (*world.cameras[:4], world.cameras[4].model_copy(update={"rate": 5.0}))}
    )
    frames = InProcessRenderer(world, 0)
    with Simulator(world, renderer=frames) as simulator:
        observations = [simulator.reset(), *(simulator.step(FORWARD) for _ in range(8))]
        counts = [len(observation.images) for observation in observations]
        assert counts == [5, 0, 4, 0, 5, 0, 4, 0, 5]
        last = observations[-1]
        assert [frame.camera for frame in last.images] == ["camera1", "camera2", "camera3", "camera4", "onboard"]
        assert [frame.fixed for frame in last.images] == [True, True, True, True, False]
        assert all(frame.time == last.time and frame.image.shape == (120, 160, 3) for frame in last.images)
        robot = simulator.truth.pose_robot_in_world
        expected = camera_on_robot(robot, 0.25, 1.2, 0.05)
        assert last.images[4].placed(robot).camera_in_world == pytest.approx(expected)
        assert np.array_equal(last.images[0].placed(robot).camera_in_world, world.cameras[0].camera_in_world)
    frames.close()


def test_without_a_renderer_there_are_no_images() -> None:
    with Simulator(real2(), renderer=None) as simulator:
        assert simulator.reset().images == ()
        assert simulator.step(FORWARD).images == ()


def test_equal_seeds_and_commands_give_equal_truth_and_images_to_the_last_bit() -> None:
    world = with_small_images(real2())
    frames = InProcessRenderer(world, 7)

    def episode() -> tuple[list[str], list[bytes]]:
        with Simulator(world, renderer=frames) as simulator:
            observations = [simulator.reset()]
            truths = [simulator.truth]
            for tick in range(24):
                observations.append(simulator.step(weave(tick)))
                truths.append(simulator.truth)
        images = [frame.image.tobytes() for observation in observations for frame in observation.images]
        return [repr(truth) for truth in truths], images

    first, second = episode(), episode()
    assert len(first[1]) == 5 * 13
    assert first == second
    frames.close()


def test_a_reset_brings_back_the_same_episode() -> None:
    with Simulator(real2(), renderer=None) as simulator:
        runs = []
        for _ in range(2):
            simulator.reset()
            runs.append([repr(simulator.step(weave(tick))) + repr(simulator.truth) for tick in range(30)])
        assert runs[0] == runs[1]


def test_two_simulators_side_by_side_do_not_disturb_each_other() -> None:
    with Simulator(real2(), renderer=None) as alone:
        alone.reset()
        expected = [(alone.step(weave(tick)), repr(alone.truth))[1] for tick in range(20)]
    with Simulator(real2(), renderer=None) as one, Simulator(load_world("sim1"), renderer=None) as other:
        one.reset()
        other.reset()
        got = []
        for tick in range(20):
            other.step(FORWARD)
            one.step(weave(tick))
            got.append(repr(one.truth))
    assert got == expected


def test_every_pybullet_call_names_its_client() -> None:
    without_client = {
        "connect", "getEulerFromQuaternion", "getQuaternionFromEuler", "getMatrixFromQuaternion"
    }  # fmt: skip
    calls = 0
    for file in Path(han_bullet.sim.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
                continue
            owner = node.func.value
            if isinstance(owner, ast.Name) and owner.id in {"p", "pybullet"} and node.func.attr not in without_client:
                calls += 1
                named = any(keyword.arg == "physicsClientId" for keyword in node.keywords)
                assert named, f"{file.name}:{node.lineno}: {node.func.attr}"
    assert calls > 20


def test_the_observation_holds_nothing_of_the_truth() -> None:
    with Simulator(real2(), renderer=None) as simulator:
        observation = simulator.reset()
    assert set(vars(observation)) == {"time", "odometry", "laser", "images", "device_messages"}
    assert isinstance(observation, Observation)
    assert "walker" not in repr(observation)


def test_the_walker_starts_when_the_robot_moves() -> None:
    with Simulator(real2(), renderer=None) as simulator:
        simulator.reset()
        for _ in range(20):
            simulator.step(Twist2D())
        assert simulator.truth.people[0].posture is Posture.STANDING
        assert simulator.truth.people[0].pose_in_world.x == 4.7
        for _ in range(20):
            simulator.step(FORWARD)
        walker = simulator.truth.people[0]
        assert walker.posture is Posture.WALKING
        assert walker.velocity_in_world == pytest.approx([0.35, 0.0])
        assert walker.pose_in_world.x == pytest.approx(4.7 + 0.35 * (1.0 - 0.05 - 0.25), abs=0.02)


def drive(simulator: Simulator, twist: Twist2D, ticks: int) -> list[Truth]:
    truths = []
    for _ in range(ticks):
        simulator.step(twist)
        truths.append(simulator.truth)
    return truths


def test_the_robot_cannot_pass_through_a_person_and_the_contact_is_reported() -> None:
    person = Person(name="guard", start=(3.5, 0.0, 0.0), behaviour=Stand())
    with Simulator(real2(people=(person,)), renderer=None) as simulator:
        simulator.reset()
        truths = drive(simulator, FORWARD, 60)
        touched = [contact for truth in truths for contact in truth.contacts]
        assert {(contact.body, contact.kind) for contact in touched} == {("guard", "person")}
        assert all(-0.02 < contact.distance <= 0.0 for contact in touched)
        gaps = [np.hypot(t.pose_robot_in_world.x - 3.5, t.pose_robot_in_world.y) - 0.3 - 0.25 for t in truths]
        assert min(gaps) > -0.02
        assert not any(truth.contacts for truth, gap in zip(truths, gaps, strict=True) if gap > 0.05)
        assert simulator.truth.people[0].pose_in_world.x == 3.5


def test_a_person_who_walks_into_the_robot_touches_it() -> None:
    walk = Walk(waypoints=((0.5, 0.0),), speed=0.8)
    person = Person(name="hurry", start=(3.0, 0.0, 3.1416), behaviour=walk)
    with Simulator(real2(people=(person,)), renderer=None) as simulator:
        simulator.reset()
        truths = drive(simulator, Twist2D(), 60)
        assert any(contact.body == "hurry" for truth in truths for contact in truth.contacts)
        assert np.isfinite(simulator.truth.pose_robot_in_world.x)


def test_walls_and_furniture_are_reported_by_name_and_the_floor_never() -> None:
    world = real2(people=(), robot=load_world("real2").robot.model_copy(update={"start": (18.0, -0.4, 0.0)}))
    with Simulator(world, renderer=None) as simulator:
        simulator.reset()
        truths = drive(simulator, FORWARD, 40)
        assert {(c.body, c.kind) for t in truths for c in t.contacts} == {("couch", "object")}
        assert simulator.truth.pose_robot_in_world.x < 19.5 - 0.5 * 1.9 - 0.3 + 0.01
        truths = drive(simulator, Twist2D(0.0, 1.0, 0.0), 120)
        assert ("wall6", "wall") in {(c.body, c.kind) for t in truths for c in t.contacts}


def test_a_short_touch_between_two_ticks_is_not_missed() -> None:
    with Simulator(real2(people=()), renderer=None) as simulator:
        simulator.reset()
        drive(simulator, Twist2D(0.0, 1.0, 0.0), 23)
        client, body = simulator._client, simulator._robot.body
        for _ in range(40):  # stop just before the wall, then knock against it and back within one tick
            simulator.step(Twist2D())
        y = simulator.truth.pose_robot_in_world.y
        assert 0.5 < y < 1.19 and simulator.truth.contacts == ()
        position, turn = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)
        pybullet.resetBasePositionAndOrientation(body, [position[0], 1.193, position[2]], turn, physicsClientId=client)
        pybullet.resetBaseVelocity(body, [0.0, 4.0, 0.0], physicsClientId=client)
        simulator._robot.drive = lambda: None  # type: ignore[method-assign]
        pybullet.changeDynamics(body, -1, restitution=1.0, physicsClientId=client)
        for wall in simulator._contacts._bodies:
            pybullet.changeDynamics(wall, -1, restitution=1.0, physicsClientId=client)
        simulator.step(Twist2D())
        assert simulator.truth.pose_robot_in_world.y < 1.195  # away from the wall again
        assert [contact.body for contact in simulator.truth.contacts] == ["wall1"]


def test_a_world_that_cannot_be_loaded_leaves_no_physics_behind() -> None:
    def clients() -> list[int]:
        return [client for client in range(64) if pybullet.isConnected(physicsClientId=client)]

    before, robot = clients(), load_world("real2").robot.model_copy(update={"urdf": "nowhere.urdf"})
    with pytest.raises(BadInputError, match=r"nowhere\.urdf"):
        Simulator(real2(robot=robot), renderer=None)
    assert clients() == before


def test_someone_turns_to_the_robot_only_while_it_requests_a_hand_over() -> None:
    person = Person(name="giver", start=(4.0, 0.0, 0.0), behaviour=Stand(turns_to_robot=True))
    with Simulator(real2(people=(person,)), renderer=None) as simulator:
        simulator.reset()
        drive(simulator, Twist2D(), 10)
        assert simulator.truth.people[0].pose_in_world.yaw == 0.0
        simulator.request_hand_over(True)
        drive(simulator, Twist2D(), 80)
        assert abs(simulator.truth.people[0].pose_in_world.yaw) == pytest.approx(np.pi, abs=0.05)
        simulator.reset()
        drive(simulator, Twist2D(), 10)
        assert simulator.truth.people[0].pose_in_world.yaw == 0.0


def test_the_television_tells_its_state_at_the_start_when_it_goes_on_and_every_second() -> None:
    (tv,) = load_world("real2").devices
    world = real2(devices=(tv.model_copy(update={"turns_on": Trigger(when="robot_moves", delay=0.5)}),))
    with Simulator(world, renderer=None) as simulator:
        observations = [simulator.reset(), *(simulator.step(FORWARD) for _ in range(60))]
        payloads = [payload for observation in observations for payload in observation.device_messages]
        messages = [read_payload(payload, ["tv"]) for payload in payloads]
        assert [message.on for message in messages] == [False, True, True, True]
        assert messages[0].time == 0.0
        assert 0.55 <= messages[1].time <= 0.65
        assert [message.time - messages[1].time for message in messages[2:]] == pytest.approx([1.0, 2.0])
        assert simulator.truth.devices_on == (("tv", True),)
        assert simulator.render_state.devices_on == (("tv", True),)


def test_a_seated_person_is_rendered_seated() -> None:
    person = Person(name="viewer", start=(0.0, 0.0, 0.0), behaviour=Sit(on="couch"))
    with Simulator(real2(people=(person,)), renderer=None) as simulator:
        simulator.reset()
        assert simulator.truth.people[0].posture is Posture.SEATED
        assert simulator.render_state.people[0].root_height < 0.7
        assert simulator.render_state.people[0].pose_in_world.y == -0.4
