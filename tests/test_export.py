"""A finished run as a bag: what was published while it ran, from its files; pictures to the last bit; refusals."""

from __future__ import annotations

import dataclasses
import json
import shutil
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from orders import Script
from rosbags.rosbag1 import Reader

from benchmarks import bags
from han_bullet.cli import main
from han_bullet.commands.fault_option import fault
from han_bullet.costmap.layers import STANDARD
from han_bullet.episode import Hook, Operator, Tick
from han_bullet.errors import BadInputError, HanError
from han_bullet.explain.recorded_run import read_run
from han_bullet.explain.replay import replay
from han_bullet.geometry import Pose2D
from han_bullet.messages import Fault, GoTo
from han_bullet.ros.bag import EARLIEST
from han_bullet.ros.export import export
from han_bullet.ros.message_types import deserialize, seconds
from han_bullet.ros.occupancy import occupancy
from han_bullet.ros.publications import Publications
from han_bullet.ros.topics import COSTMAP, COSTMAP_UPDATES, CURRENT_GOAL, DETECTION_MARKERS, layer_topic
from han_bullet.runner import RunOptions, run_world
from han_bullet.world_file import find_world, load_world, read_yaml

Said = dict[str, list[tuple[int, Any]]]  # topic -> (time [ns], message)
LASTS = 1.5  # [s]
DECIMALS = 3e-4  # what six decimals come to at most: 0.5e-6 rad for each of the 400 steps of the laser's angle

COST = 1  # of 100: a cost at the edge between two falls to the other side


class Live(Hook):
    """What is published while a run goes on."""

    def __init__(self, folder: Path) -> None:
        self.said: Said = defaultdict(list)
        self._folder = folder
        self._publications: Publications | None = None

    def record(self, tick: Tick) -> None:
        if self._publications is None:
            self._publications = Publications(load_world(self._folder / "world.yaml"))
            self._take(self._publications.statics(), 0.0)
        self._take(self._publications.of(tick.observation, tick.decision, lambda topic: True), tick.decision.time)

    def _take(self, outgoing: Any, time: float) -> None:
        for one in outgoing:
            self.said[one.topic].append((max(round(time * 1e9), EARLIEST), one.message))


@dataclasses.dataclass(frozen=True)
class Ran:
    """A run, and what was published while it ran."""

    folder: Path
    live: Said


def ran(folder: Path, world: str, lasts: float, operator: Operator | None = None, **options: Any) -> Ran:
    brief = folder / "brief.yaml"
    brief.write_text(yaml.safe_dump(read_yaml(find_world(world).read_text()) | {"duration": lasts}))
    live = Live(folder / "run")
    run_world(brief, RunOptions(seed=1, video=False, **options), folder / "run", [live], operator=operator)
    return Ran(folder / "run", live.said)


@pytest.fixture(scope="module")
def blind(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    """Real2 with perfect perception."""
    return ran(tmp_path_factory.mktemp("blind"), "real2", LASTS, perception="truth")


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    """A second of real2 with two cameras, one of which loses frames."""
    folder = tmp_path_factory.mktemp("seen")
    return ran(folder, "real2", 1.0, cameras=("camera1", "onboard"), faults=(fault("camera1=dropped:0.5"),))


def exported(run: Path, path: Path, **options: Any) -> Said:
    """What is in a bag of a run."""
    export(read_run(run), path, **options)
    said: Said = defaultdict(list)
    with Reader(path) as reader:
        for connection, time, raw in reader.messages():
            said[connection.topic].append((time, deserialize(connection.msgtype, bytes(raw))))
    return said


def differences(one: Any, other: Any, path: str = "") -> Iterator[str]:
    """Where two messages differ by more than a run's files have decimals."""
    if dataclasses.is_dataclass(one):
        for field in dataclasses.fields(one):
            yield from differences(getattr(one, field.name), getattr(other, field.name), f"{path}.{field.name}")
    elif isinstance(one, list) and len(one) == len(other):
        for number, (a, b) in enumerate(zip(one, other, strict=True)):
            yield from differences(a, b, f"{path}[{number}]")
    elif isinstance(one, (float, np.ndarray)) and np.shape(one) == np.shape(other):
        tolerance = COST if getattr(one, "dtype", None) == np.int8 else DECIMALS
        if not np.allclose(one, other, rtol=0.0, atol=tolerance, equal_nan=True):
            yield f"{path}: {one} is not {other}"
    elif one != other:
        yield f"{path}: {one} is not {other}"


def assert_same(live: Said, bag: Said, but: set[str]) -> None:
    """The same messages at the same times in all topics but some."""
    topics = set(live) - but
    assert len(topics) > 15
    for topic in topics:
        assert [time for time, _ in bag[topic]] == [time for time, _ in live[topic]], topic
        for (_, was), (_, message) in zip(live[topic], bag[topic], strict=True):
            found = list(differences(was, message))
            if topic == DETECTION_MARKERS:  # an ellipse that is nearly a circle has no direction to speak of
                found = [one for one in found if ".pose.orientation." not in one]
            assert found == [], topic


def test_a_bag_has_what_was_published_while_the_run_went_on(blind: Ran, tmp_path: Path) -> None:
    bag = exported(blind.folder, tmp_path / "run.bag")
    assert_same(blind.live, bag, but=set())
    assert len(bag["/cmd_vel"]) == round(LASTS / 0.05) + 1
    assert bag["/cmd_vel"][-1][1].linear.x > 0.1 and bag["/odom"][-1][1].pose.pose.position.x > 0.1


def test_the_costmap_of_a_bag_is_that_of_the_run_and_each_layer_has_grids(blind: Ran, tmp_path: Path) -> None:
    bag = exported(blind.folder, tmp_path / "run.bag")
    (_, whole), *_ = bag[COSTMAP]
    cells = whole.data.reshape(whole.info.height, whole.info.width).copy()
    for _, window in bag[COSTMAP_UPDATES]:
        rows, columns = slice(window.y, window.y + window.height), slice(window.x, window.x + window.width)
        cells[rows, columns] = window.data.reshape(window.height, window.width)
    last = seconds(bag[COSTMAP_UPDATES][-1][1].header.stamp)
    assert len(bag[COSTMAP]) == 1 and last > 1.0
    costmap = replay(read_run(blind.folder), last).tick.decision.costmap
    assert np.array_equal(cells, occupancy(costmap.cost))
    assert [len(bag[layer_topic(layer.name)]) for layer in STANDARD] == [3] * len(STANDARD)
    assert max(bag[layer_topic("static")][0][1].data) == 100


def test_a_run_with_orders_has_in_the_bag_what_was_published_under_them(tmp_path: Path) -> None:
    aside = GoTo(Pose2D(3.0, 0.5, 1.0))
    orders = Script(LASTS, (0.5, lambda stack: stack.take(aside)), (1.0, lambda stack: stack.cancel()))
    run = ran(tmp_path, "real2", 60.0, operator=orders, perception="truth")
    goals = [message.pose.position.x for _, message in run.live[CURRENT_GOAL]]
    assert len(set(goals)) == 2 and goals[-1] == 3.0
    assert_same(run.live, exported(run.folder, tmp_path / "run.bag"), but=set())


@pytest.mark.scenario
def test_a_bag_of_a_run_with_cameras_has_what_was_published_but_the_images(seen: Ran, tmp_path: Path) -> None:
    bag = exported(seen.folder, tmp_path / "run.bag")
    images = {topic for topic in seen.live if topic.endswith(("image_raw", "image_boxes"))}
    assert len(images) == 4 and images.isdisjoint(bag)
    assert any(message.markers for _, message in bag["/detection_markers"])
    assert_same(seen.live, bag, but=images)


@pytest.mark.scenario
def test_the_pictures_are_taken_again_to_the_last_bit(seen: Ran, tmp_path: Path) -> None:
    bag = exported(seen.folder, tmp_path / "run.bag", images=True)
    for topic in ("/camera1/image_raw", "/onboard/image_raw", "/onboard/image_boxes"):
        assert [time for time, _ in bag[topic]] == [time for time, _ in seen.live[topic]]
        assert len(bag[topic]) == 11 or (topic.startswith("/camera1") and 1 < len(bag[topic]) < 11)
        for (_, was), (_, image) in zip(seen.live[topic], bag[topic], strict=True):
            assert seconds(image.header.stamp) == seconds(was.header.stamp)
            assert np.array_equal(image.data, was.data)


@pytest.mark.scenario
@pytest.mark.parametrize("column", [3, 2])
def test_a_picture_that_is_another_one_is_refused_and_no_file_is_left(seen: Ran, tmp_path: Path, column: int) -> None:
    folder = tmp_path / "run"
    shutil.copytree(seen.folder, folder)
    cells = (folder / "frames.csv").read_text().splitlines()[6].split(",")
    cells[column] = {3: "12345", 2: "0.050000"}[column]
    replace_line(folder / "frames.csv", 6, ",".join(cells))
    with pytest.raises(HanError, match=f"those of {float(cells[0]):.2f} s differ"):
        export(read_run(folder), tmp_path / "run.bag", images=True)
    assert list(tmp_path.iterdir()) == [folder]


def test_a_run_without_cameras_has_no_images(blind: Ran, tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match="had no cameras"):
        export(read_run(blind.folder), tmp_path / "run.bag", images=True)
    assert list(tmp_path.iterdir()) == []


def test_faults_are_those_that_were_noticed_then(blind: Ran, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    shutil.copytree(blind.folder, folder)
    result = json.loads((folder / "result.json").read_text())
    result["faults"] = [
        {"sensor": "laser", "kind": "dropped", "from": 0.5, "until": 1.1},
        {"sensor": "wheels", "kind": "slip", "from": 1.2, "until": None},
    ]
    (folder / "result.json").write_text(json.dumps(result))
    run = read_run(folder)
    dropped, slip = Fault("laser", "dropped", 0.5), Fault("wheels", "slip", 1.2)
    assert [run.faults_at(time) for time in (0.45, 0.5, 1.05, 1.1, 1.2)] == [(), (dropped,), (dropped,), (), (slip,)]
    statuses = [message.status for _, message in exported(folder, tmp_path / "run.bag")["/diagnostics"]]
    laser = [next(status.message for status in those if status.name.endswith("laser")) for those in statuses]
    assert laser == ["works", "dropped since 0.50 s"]


def test_commands_and_covariances_are_those_of_the_files(blind: Ran, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    shutil.copytree(blind.folder, folder)
    replace_line(folder / "commands.csv", 11, "0.500000,0.123,-0.05,0.3")
    replace_line(folder / "poses.csv", 11, "0.500000,2.0,0.1,0.2,0,0.01,0.002,-0.003,0.04,0.005,0.06")
    bag = exported(folder, tmp_path / "run.bag")
    command, pose = dict(bag["/cmd_vel"])[500_000_000], dict(bag["/amcl_pose"])[500_000_000].pose
    assert (command.linear.x, command.linear.y, command.angular.z) == (0.123, -0.05, 0.3)
    among = pose.covariance.reshape(6, 6)[np.ix_((0, 1, 5), (0, 1, 5))]
    assert among.tolist() == [[0.01, 0.002, -0.003], [0.002, 0.04, 0.005], [-0.003, 0.005, 0.06]]


def replace_line(path: Path, number: int, line: str) -> None:
    lines = path.read_text().splitlines()
    assert lines[number].split(",")[0] == line.split(",")[0]
    path.write_text("\n".join([*lines[:number], line, *lines[number + 1 :]]) + "\n")


def test_why_it_gave_up_is_told_as_it_was(blind: Ran, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    shutil.copytree(blind.folder, folder)
    with (folder / "status.csv").open("a") as table:
        table.write("1.000000,blocked,give_up\n")
    result = json.loads((folder / "result.json").read_text()) | {"outcome_detail": "a crate is in the way"}
    (folder / "result.json").write_text(json.dumps(result))
    messages = [message.status for _, message in exported(folder, tmp_path / "run.bag")["/diagnostics"]]
    before, after = (next(one.message for one in those if one.name.endswith("control")) for those in messages)
    assert "gave up" not in before and after == "gave up: a crate is in the way"


def test_the_command_writes_both_kinds_and_says_what_there_is(
    blind: Ran, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag, mcap, other = tmp_path / "new" / "run.bag", tmp_path / "run.mcap", tmp_path / "run"
    assert main(["export", str(blind.folder), str(bag)]) == 0
    assert f"{bag}: 1.50 s, " in capsys.readouterr().out
    mcap.write_text("old")
    assert main(["export", str(blind.folder), str(mcap)]) == 0
    assert main(["export", str(blind.folder), str(other), "--mcap"]) == 0
    assert bag.read_bytes().startswith(b"#ROSBAG V2.0\n")
    assert all(path.read_bytes().startswith(b"\x89MCAP0\r\n") for path in (mcap, other))


@pytest.mark.parametrize(
    ("file", "words"),
    [
        (["run.txt"], "ends in neither .bag nor .mcap"),
        (["run.bag", "--mcap"], "ends in .bag, and --mcap is given"),
        (["."], "is a folder; a file ending in .bag or .mcap would be right"),
        (["made/run.bag"], "is a file; a folder would be right"),
    ],
)
def test_a_file_that_cannot_be_meant_is_refused(
    file: list[str],
    words: str,
    blind: Ran,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "made").write_text("")
    assert main(["export", str(blind.folder), *file]) == 2
    error = capsys.readouterr().err
    assert words in error and error.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["made"]


def test_what_is_no_run_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", str(tmp_path), str(tmp_path / "run.bag")]) == 2
    assert "holds no result.json" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_the_benchmark_compares_with_what_is_not_compressed(blind: Ran, tmp_path: Path) -> None:
    plain, lz4, zstd = bags.measured(read_run(blind.folder), tmp_path, images=False, rounds=1)
    assert (plain[0], plain[4]) == ("bag, none", "1.00")
    assert float(lz4[4]) < 0.2 and float(zstd[4]) < 0.2 and plain[2] == lz4[2] == zstd[2]


@pytest.mark.parametrize("name", ["odometry.csv", "commands.csv", "poses.csv"])
def test_a_table_that_ends_early_is_refused(name: str, blind: Ran, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    shutil.copytree(blind.folder, folder)
    lines = (folder / name).read_text().splitlines()
    (folder / name).write_text("\n".join(lines[:-1]) + "\n")
    with pytest.raises(BadInputError, match=rf"{name}: its times are not 0, 0.05, ..., 1.5 s"):
        read_run(folder)
