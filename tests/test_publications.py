"""All that the robot says on ROS: who is told what, and when."""

import dataclasses
import json
import math
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from ticks import CAMERA, found, frame, make_world, tick, track

from han_bullet import runner
from han_bullet.costmap.grid import Costmap
from han_bullet.costmap.layer import Layer
from han_bullet.costmap.layers import STANDARD
from han_bullet.detection.detector import Detector
from han_bullet.episode import Hook, Tick
from han_bullet.geometry import Pose2D
from han_bullet.messages import Detections, GoTo, LaserScan, Scene
from han_bullet.ros import publications as module
from han_bullet.ros.message_types import serialize, type_of
from han_bullet.ros.publications import STANDARD_LAYERS, Publications
from han_bullet.ros.topics import COSTMAP, COSTMAP_UPDATES, PLAN, Outgoing, layer_topic, table
from han_bullet.runner import RunOptions, run_world
from han_bullet.stack import NavigationStack
from han_bullet.world_file import save_world
from han_bullet.world_schema import World

CAMERAS = [CAMERA.model_dump(mode="json")]
WORLD = make_world(cameras=CAMERAS)
GRIDS = [layer_topic(layer.name) for layer in STANDARD]
PICTURE = np.random.default_rng(0).integers(0, 256, (480, 640, 3), dtype=np.uint8)


def everything(topic: str) -> bool:
    return True


def moment(number: int, **changes: Any) -> Tick:
    """A tick with a person, a goal, a laser scan, and at every second one an image with a box."""
    time = 0.05 * number
    frames = [frame(time=time, image=PICTURE)] if number % 2 == 0 else []
    people = (track(2, 5.0, 0.5, velocity=(0.5, 0.0), posture="walking"),)
    scene = Scene(time, people, task=GoTo(Pose2D(18.0, 0.0, 0.0)), pose_robot_in_world=Pose2D(1.0, 0.0, 0.0))
    boxes = [found(image, (100, 100, 50, 120)) for image in frames]
    given: dict[str, Any] = {"tracks": people, "scene": scene, "frames": frames, "detections": boxes}
    seen = tick(number, **(given | changes))
    scan = LaserScan(time, np.array([1.0, 2.0, math.inf]), -0.1, 0.1, 0.05, 8.0, Pose2D(0.2, 0.0, 0.0))
    return dataclasses.replace(seen, observation=dataclasses.replace(seen.observation, laser=scan))


def said(publications: Publications, seen: Tick, wanted: Callable[[str], bool] = everything) -> list[Outgoing]:
    return list(publications.of(seen.observation, seen.decision, wanted))


def topics(outgoing: Iterable[Outgoing]) -> list[str]:
    return [each.topic for each in outgoing]


def test_every_message_is_of_its_topics_type_and_can_be_sent() -> None:
    publications = Publications(WORLD)
    types = {topic.name: topic.type for topic in publications.topics}
    outgoing = [*publications.statics(), *(o for k in range(3) for o in said(publications, moment(k)))]
    for each in outgoing:
        assert type_of(each.message) == types[each.topic]
        assert len(serialize(each.message)) > 0
    assert set(topics(outgoing)) == set(types) - {COSTMAP_UPDATES, *GRIDS, "/detection_markers"}


def leaves(value: Any) -> Iterator[Any]:
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from leaves(getattr(value, field.name))
    elif isinstance(value, list):
        for each in value:
            yield from leaves(each)
    else:
        yield value


def test_every_number_is_finite_but_a_range_at_which_there_is_nothing() -> None:
    publications, lost = Publications(WORLD), 0
    for k in range(4):
        for each in [*publications.statics(), *said(publications, moment(k, path=None, lost=k > 1))]:
            for leaf in leaves(each.message):
                if isinstance(leaf, float | np.ndarray) and not np.isfinite(leaf).all():
                    lost += 1
                    assert each.topic == "/scan" and not np.isnan(leaf).any()
    assert lost == 4  # one scan with an empty ray at each tick


def test_each_topic_is_said_no_more_often_than_its_rate() -> None:
    publications = Publications(WORLD)
    counts = Counter(topic for k in range(40) for topic in topics(said(publications, moment(k))))  # two seconds
    rates = {topic.name: topic.rate for topic in publications.topics}
    for topic, count in counts.items():
        rate = rates[topic]
        assert rate is None or count <= 2.0 * rate, topic
    assert counts["/tf"] == counts["/clock"] == 40 and counts["/ceiling/image_raw"] == counts["/people"] == 20
    assert counts[PLAN] == 10 and counts["/diagnostics"] == 2


def test_what_is_static_is_latched_and_nothing_else_is() -> None:
    publications = Publications(WORLD)
    assert set(topics(publications.statics())) == {topic.name for topic in publications.topics if topic.latched}


def test_the_map_has_walls_where_the_world_has_them() -> None:
    world = make_world(walls=[{"start": [5.0, -2.0], "end": [5.0, 2.0]}])
    grid = next(each.message for each in Publications(world).statics() if each.topic == "/map")
    cells = grid.data.reshape(grid.info.height, grid.info.width)

    def at(x: float, y: float) -> int:
        column = int((x - grid.info.origin.position.x) / grid.info.resolution)
        return int(cells[int((y - grid.info.origin.position.y) / grid.info.resolution), column])

    assert (at(5.0, 0.5), at(4.0, 0.5), at(6.0, -1.5)) == (100, 0, 0)


@pytest.mark.parametrize(
    "name", ["image_message", "image_with_boxes", "plan_message", "detection_markers", "people_message", "occupancy"]
)
def test_nothing_is_made_that_nobody_wants(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def made(*_: object) -> None:
        raise AssertionError(f"{name} was called")

    monkeypatch.setattr(module, name, made)
    publications = Publications(WORLD)
    for k in range(4):
        assert topics(said(publications, moment(k), {"/tf"}.__contains__)) == ["/tf"]


def test_only_what_is_wanted_is_said() -> None:
    for topic in Publications(WORLD).topics:
        wanted = {topic.name}
        for k in range(3):
            assert set(topics(said(Publications(WORLD), moment(k), wanted.__contains__))) <= wanted


def test_wheels_and_trajectory_go_on_while_nobody_listens() -> None:
    publications, listens = Publications(WORLD), {"/trajectory", "/joint_states"}
    for k in range(20):
        said(publications, moment(k, robot=(0.2 * k, 0.0, 0.0), twist=(0.15, 0.0, 0.0)), lambda _: False)
    end = moment(20, robot=(4.0, 0.0, 0.0), twist=(0.15, 0.0, 0.0))
    messages = {each.topic: each.message for each in said(publications, end, listens.__contains__)}
    assert len(messages["/trajectory"].poses) == 21
    assert messages["/joint_states"].position[1] == pytest.approx(21 * 0.05 * 2.0)


def test_an_image_without_pixels_is_not_sent_but_its_calibration_is() -> None:
    empty = frame(image=np.zeros((0, 0, 3), np.uint8))
    sent = topics(said(Publications(WORLD), moment(0, frames=[empty], detections=[])))
    assert "/ceiling/camera_info" in sent and not {"/ceiling/image_raw", "/ceiling/image_boxes"} & set(sent)


def test_boxes_are_those_of_the_very_image() -> None:
    late = frame(time=0.0, image=PICTURE)
    other = dataclasses.replace(late, camera="other")
    seen = moment(4, frames=[late], detections=[found(other, (10, 10, 200, 300)), found(late)])
    messages = {each.topic: each.message for each in said(Publications(WORLD), seen)}
    np.testing.assert_array_equal(messages["/ceiling/image_boxes"].data, PICTURE.reshape(-1))
    assert messages["/ceiling/image_raw"].header.stamp.sec == 0


def with_cost(number: int, cost: int) -> Tick:
    costmap = Costmap.covering([((0.0, 20.0), (-2.0, 2.0))], 0.1)
    costmap.cost[3, 5] = cost
    return moment(number, costmap=costmap)


def grids(outgoing: Sequence[Outgoing]) -> list[str]:
    return [topic for topic in topics(outgoing) if topic in (COSTMAP, COSTMAP_UPDATES)]


def test_a_new_subscriber_of_the_costmap_gets_it_whole() -> None:
    publications = Publications(WORLD)
    both = {COSTMAP, COSTMAP_UPDATES}.__contains__
    assert grids(said(publications, with_cost(0, 0), both)) == [COSTMAP]
    assert grids(said(publications, with_cost(4, 9), both)) == [COSTMAP_UPDATES]
    publications.greet(COSTMAP)  # a second one
    assert grids(said(publications, with_cost(5, 9), both)) == [COSTMAP]
    assert grids(said(publications, with_cost(9, 8), lambda _: False)) == []
    assert grids(said(publications, with_cost(13, 8), both)) == [COSTMAP]  # after nobody listened


def test_a_new_subscriber_does_not_wait_for_the_next_turn() -> None:
    publications = Publications(WORLD)
    assert "/trajectory" in topics(said(publications, moment(0)))
    assert "/trajectory" not in topics(said(publications, moment(1)))
    publications.greet("/trajectory")
    assert "/trajectory" in topics(said(publications, moment(2)))


def test_a_clock_that_is_set_back_does_not_silence_a_topic() -> None:
    publications = Publications(WORLD)
    said(publications, moment(100))
    assert {"/people", COSTMAP, PLAN} <= set(topics(said(publications, moment(0))))


class Listener(Hook):
    """Wants everything, from a stack whose layers are watched."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.counts: Counter[str] = Counter()
        self._build = runner._build
        monkeypatch.setattr(runner, "_build", self._watch)

    def _watch(self, world: World, *arguments: Any) -> NavigationStack:
        stack = self._build(world, *arguments)
        self._publications = Publications(world)
        self._publications.watch_layers(stack)
        self._publications.watch_times(stack)
        return stack

    def record(self, tick: Tick) -> None:
        for outgoing in self._publications.of(tick.observation, tick.decision, everything):
            serialize(outgoing.message)
            self.counts[outgoing.topic] += 1


class OneBox(Detector):
    """Finds the same person in every image."""

    def detect(self, image: np.ndarray) -> Detections:
        return Detections(np.array([[150.0, 60.0, 40.0, 100.0]]), np.array([50.0]), np.array([1.0]))


def test_a_run_is_the_same_to_the_last_bit_with_and_without_listeners(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small = [
        {"name": "hall", "kind": "ceiling", "size": [320, 240], "position": [0.2, 1.0, 2.6], "look_at": [6.2, 0, 0.9]}
    ]
    box = {"name": "crate", "position": [3.0, 0.0], "size": [0.5, 0.5, 1.0], "known": False}
    walls = [{"start": [0.0, y], "end": [20.0, y]} for y in (-2.05, 2.05)]
    world = make_world("anna", "bob", walls=walls, cameras=small, furniture=[box], duration=1.5)
    save_world(world, tmp_path / "hall.yaml", "a hall")
    options = RunOptions(video=False)
    run_world(tmp_path / "hall.yaml", options, tmp_path / "plain", detector=OneBox())
    listener = Listener(monkeypatch)
    run_world(tmp_path / "hall.yaml", options, tmp_path / "heard", [listener], detector=OneBox())
    assert listener.counts["/hall/image_boxes"] == 16 and all(listener.counts[grid] >= 2 for grid in GRIDS)
    for path in sorted((tmp_path / "plain").iterdir()):
        same = (tmp_path / "heard" / path.name).read_text()
        if path.name == "result.json":
            assert without_timings(same) == without_timings(path.read_text())
        else:
            assert same == path.read_text(), path.name


class Corner(Layer):
    """A layer of one's own."""

    name = "corner"

    def apply(self, costmap: Costmap, scene: Scene) -> None:
        costmap.cost[0, 0] = 7


@pytest.mark.parametrize(("layers", "has_grid"), [((), False), (("corner",), True)])
def test_a_layer_of_ones_own_has_a_grid_if_it_was_named(layers: tuple[str, ...], has_grid: bool) -> None:
    class Stack:
        layers: Sequence[Layer] = (Corner(),)

    stack, publications = Stack(), Publications(WORLD, (*STANDARD_LAYERS, *layers))
    publications.watch_layers(cast(NavigationStack, stack))
    sent: list[str] = []
    for k in range(2):
        costmap = Costmap.covering([((0.0, 20.0), (-2.0, 2.0))], 0.1)
        for layer in stack.layers:
            layer.apply(costmap, moment(k).decision.scene)
        assert costmap.cost[0, 0] == 7
        sent += topics(said(publications, moment(k, costmap=costmap)))
    assert (layer_topic("corner") in sent) is has_grid


def test_of_two_layers_of_one_name_none_is_lost() -> None:
    class OtherCorner(Corner):
        def apply(self, costmap: Costmap, scene: Scene) -> None:
            costmap.cost[-1, -1] = 9

    class Stack:
        layers: Sequence[Layer] = (Corner(), OtherCorner())

    stack = Stack()
    Publications(WORLD, (*STANDARD_LAYERS, "corner")).watch_layers(cast(NavigationStack, stack))
    costmap = Costmap.covering([((0.0, 20.0), (-2.0, 2.0))], 0.1)
    for layer in stack.layers:
        layer.apply(costmap, moment(0).decision.scene)
    assert (costmap.cost[0, 0], costmap.cost[-1, -1]) == (7, 9)


def without_timings(text: str) -> dict[str, Any]:
    result: dict[str, Any] = json.loads(text)
    del result["timings"]
    return result


def test_the_robot_says_all_this_without_a_simulator() -> None:
    code = "import sys, han_bullet.ros.publications; print(*({'pybullet', 'torch', 'rospy'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_the_documentation_has_the_table_of_topics() -> None:
    page = (Path(__file__).parent.parent / "docs/ros.md").read_text()
    assert table(["CAMERA"], ["LAYER"]) in page
