"""Explanations of real runs: the replay is the run, the layer that moves the way is named, bad input is refused."""

import json
import math
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from made_runs import made_run, replayed

from han_bullet.cli import main
from han_bullet.costmap.obstacle import ObstacleLayer
from han_bullet.errors import BadInputError
from han_bullet.explain.explainer import explain, explain_run
from han_bullet.explain.explanation import Explanation, LayerEffect
from han_bullet.explain.picture import COLOURS, paint
from han_bullet.explain.recorded_run import read_run
from han_bullet.explain.replay import AGREEMENT, replay
from han_bullet.explain.sentences import details, movers, strength, verdict
from han_bullet.messages import RecoveryStep, Scene, Status
from han_bullet.runner import RunOptions, run_world
from han_bullet.topdown import PATH
from han_bullet.world_file import find_world, read_yaml


def brief(folder: Path, world: str, duration: float, **walker: Any) -> Path:
    """A copy of a world that ends early, with another walker where one is described."""
    document = read_yaml(find_world(world).read_text()) | {"duration": duration}
    document["people"][0] |= walker
    path = folder / "brief.yaml"
    path.write_text(yaml.safe_dump(document))
    return path


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three seconds of real2 with its cameras."""
    folder = tmp_path_factory.mktemp("seen")
    run_world(brief(folder, "real2", 3.0), RunOptions(seed=1, video=False), folder / "run")
    return folder / "run"


@pytest.fixture(scope="module")
def overtaking(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Real2 with perfect perception and the walker left of the middle, so that there is more room on the right."""
    folder = tmp_path_factory.mktemp("overtaking")
    walk = {"kind": "walk", "waypoints": [[15.5, 0.2]], "speed": 0.35, "starts": {"when": "robot_moves"}}
    world = brief(folder, "real2", 4.0, start=[4.5, 0.2, 0.0], behaviour=walk)
    run_world(world, RunOptions(seed=1, perception="truth", video=False), folder / "run")
    return folder / "run"


@pytest.fixture(scope="module")
def television(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Real3 with perfect perception, until after the television has gone on."""
    folder = tmp_path_factory.mktemp("television")
    run_world(brief(folder, "real3", 7.0), RunOptions(seed=1, perception="truth", video=False), folder / "run")
    return folder / "run"


def effect(explanation: Explanation, layer: str) -> LayerEffect:
    return next(effect for effect in explanation.way.layers if effect.layer == layer)


@pytest.mark.scenario
def test_a_replay_of_a_run_with_cameras_has_its_tracks_at_every_tick(seen: Path) -> None:
    run = read_run(seen)
    assert sum(map(len, run.tracks.values())) > 30 and len(run.detections) > 30
    assert sum(len(legs.positions) for legs in run.legs.values()) > 20
    replayed = replay(run, 3.0)
    assert replayed.tick.truth.time == 3.0
    assert replayed.differs_since is None
    assert replayed.difference < 0.1 * AGREEMENT


@pytest.mark.scenario
def test_a_run_with_cameras_explains_its_walker(seen: Path, capsys: pytest.CaptureFixture[str]) -> None:
    explanation = explain_run(seen, 2.5)
    (walker,) = explanation.people
    assert walker.track == 0 and walker.distance is not None and walker.distance < 0.3
    assert {sighting.camera for sighting in walker.sightings} == {"camera1", "camera2", "camera3", "camera4", "onboard"}
    assert explanation.warnings == () and explanation.strays == ()
    assert explanation.detections
    assert explanation.difference is not None and explanation.difference < 1e-5
    assert main(["explain", str(seen), "--time", "2.5"]) == 0
    assert "at 2.50 s; the replay agrees with tracks.csv to 0.0000" in capsys.readouterr().out


@pytest.mark.scenario
def test_without_the_laser_a_replay_has_other_tracks(seen: Path) -> None:
    run = read_run(seen)
    assert replay(replace(run, legs={}), 3.0).difference > 10.0 * AGREEMENT


@pytest.mark.scenario
def test_an_edited_file_is_told(seen: Path, tmp_path: Path) -> None:
    folder = tmp_path / "edited"
    shutil.copytree(seen, folder)
    lines = (folder / "tracks.csv").read_text().splitlines()
    time, key, x, *rest = lines[20].split(",")
    lines[20] = ",".join([time, key, f"{float(x) + 0.01:.6f}", *rest])
    (folder / "tracks.csv").write_text("\n".join(lines) + "\n")
    (warning,) = explain_run(folder, 3.0).warnings
    assert warning.startswith(f"from {float(time):.2f} s on the replay's tracks differ from tracks.csv")


def test_while_overtaking_on_the_side_with_less_room_overtake_is_what_moves_the_way(overtaking: Path) -> None:
    explanation = explain_run(overtaking, 2.0)
    assert explanation.warnings == ()
    strongest = movers(explanation.way)[0]
    assert strongest.layer == "overtake"
    assert strongest.shift is not None and strongest.shift.largest > 1.0
    assert strongest.causes == ("track 0 (walker)",)
    assert explanation.way.sides == {"walker": "right"} and strongest.sides == {"walker": "left"}
    (sentence,) = verdict(explanation.way)
    assert sentence.startswith("overtake moved the way by ")
    assert " m to the left near (" in sentence and sentence.endswith(", because of track 0 (walker)")
    assert "the best way without it has walker on its left" in details(strongest, explanation.way)


def test_costs_tell_what_a_layer_is_worth(overtaking: Path) -> None:
    explanation = explain_run(overtaking, 2.0)
    way, overtake = explanation.way, effect(explanation, "overtake")
    assert overtake.cost_without < overtake.cost_of_way <= way.best_cost < overtake.cost_if_ignored
    assert overtake.dearest is not None
    (x, y), rise = overtake.dearest
    walker = explanation.people[0].place
    assert math.dist((x, y), walker) < 2.0 and y < walker[1]  # on the closed side
    assert 50 < rise <= 252
    idle = effect(explanation, "interaction")
    assert idle.shift is not None and idle.shift.largest == pytest.approx(0.0, abs=1e-9)
    assert (idle.cost_of_way, idle.cost_if_ignored) == (way.best_cost, way.best_cost)
    assert idle.dearest is None and idle.causes == ()


def test_planning_again_leaves_the_stack_as_it_was(overtaking: Path) -> None:
    replayed = replay(read_run(overtaking), 2.0)
    before = replayed.tick.decision.costmap.cost.copy()
    first, second = explain(replayed), explain(replayed)
    assert np.array_equal(replayed.tick.decision.costmap.cost, before)
    assert verdict(first.way) == verdict(second.way)
    costmap = replayed.stack.free_space.copy()
    for layer in replayed.stack.layers:
        layer.apply(costmap, replayed.tick.decision.scene)
    assert np.array_equal(costmap.cost, before)


def test_with_the_television_on_it_is_named_beside_its_viewer(television: Path) -> None:
    assert (television / "messages.csv").read_text().splitlines()[0] == "time,device,sent,on,session"
    explanation = explain_run(television, 6.5)
    interaction = effect(explanation, "interaction")
    assert interaction.causes == ("track 0 (viewer)", "tv")
    assert interaction.shift is not None and interaction.shift.largest > 2.0  # round the other side of the couch
    assert "interaction" in " ".join(verdict(explanation.way))


def test_before_the_first_message_the_television_is_off(television: Path) -> None:
    scene: Scene = replay(read_run(television), 1.0).tick.decision.scene
    assert [device.on for device in scene.devices] == [False]
    assert replay(read_run(television), 6.5).tick.decision.scene.devices[0].on


def test_the_picture_shows_the_best_way_and_those_without_a_layer(overtaking: Path) -> None:
    replayed = replay(read_run(overtaking), 2.0)
    explanation = explain(replayed)
    picture = paint(replayed, explanation)
    unmoved = paint(replayed, replace(explanation, way=replace(explanation.way, layers=())))
    assert picture.shape[1] == unmoved.shape[1] == 1920
    assert count(picture, PATH) > 200
    assert count(picture, COLOURS[0]) > 200
    assert count(unmoved, COLOURS[0]) == 0


def test_of_more_layers_than_colours_the_strongest_are_drawn(overtaking: Path) -> None:
    replayed = replay(read_run(overtaking), 2.0)
    explanation = explain(replayed)
    strongest = max(explanation.way.layers, key=strength)
    assert strongest.way is not None
    layers = tuple(replace(strongest, layer=f"layer{number}") for number in range(len(COLOURS) + 1))
    picture = paint(replayed, replace(explanation, way=replace(explanation.way, layers=layers)))
    assert count(picture, COLOURS[-1]) > 200


def count(picture: np.ndarray, colour: tuple[int, int, int]) -> int:
    return int((picture == colour).all(axis=2).sum())


def test_the_command_tells_people_and_way_and_draws(
    overtaking: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = tmp_path / "new" / "moment.png"
    assert main(["explain", str(overtaking), "--time", "2.02", "--plot", str(picture)]) == 0
    out = capsys.readouterr().out
    assert "real2, seed 1, at 2.00 s; perception: truth" in out
    assert "walking: track 0, 0.00 m off" in out
    assert "overtake: moves the way up to " in out and "without effect: static" in out
    assert f"picture: {picture}" in out
    image = cv2.imread(str(picture))
    assert image is not None and image.shape[1] == 1920


def refusal(folder: Path, time: float = 1.0) -> str:
    with pytest.raises(BadInputError) as caught:
        explain_run(folder, time)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_what_is_no_run_is_refused(tmp_path: Path) -> None:
    assert "is no folder" in refusal(tmp_path / "nowhere")
    assert "holds no result.json" in refusal(tmp_path)


def test_a_run_of_a_version_without_these_files_is_refused_with_their_names(overtaking: Path, tmp_path: Path) -> None:
    folder = tmp_path / "old"
    shutil.copytree(overtaking, folder)
    (folder / "messages.csv").unlink()
    (folder / "world.yaml").unlink()
    assert "lacks world.yaml, messages.csv, as one of another version does" in refusal(folder)


@pytest.mark.parametrize("time", [-0.1, 4.2, math.nan, math.inf])
def test_a_time_outside_the_run_is_refused_with_its_span(overtaking: Path, time: float) -> None:
    message = refusal(overtaking, time)
    assert f"time is {time:g} s" in message and "lasts from 0 to 4 s" in message


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("result.json", "{", "Invalid JSON"),
        ("result.json", "[]", "the document: Input should be an object"),
        ("trace.csv", "time,robot.x\n", "has no column 'walker.x'"),
        ("messages.csv", "time,device,sent,on,session\n0.0,tv,now,1,\n", "line 2 cannot be read: could not convert"),
        ("messages.csv", "time,device,sent,on,session\ninf,tv,0.0,1,\n", "line 2 cannot be read: its time is 'inf'"),
        ("tracks.csv", "time,id,x,y,vx,vy\n0.0,inf,1,1,0,0\n", "line 2 cannot be read: its id is 'inf'"),
        ("tracks.csv", "time,id,x,y,vx,vy\n0,1,1\n0,1,1,1,0,0\n", "line 2 cannot be read: it has 3 cells"),
        (
            "legs.csv",
            "time,x,y,deviation_x,deviation_y,correlation,vacant\n0.0,1.0,,0.1,0.1,0.0,\n",
            "could not convert",
        ),
        ("tracks.csv", "time,id\xff\n", "cannot be read: 'utf-8' codec"),
        ("world.yaml", "name: [", "not readable as YAML"),
    ],
)
def test_a_broken_file_is_named(overtaking: Path, tmp_path: Path, name: str, content: str, words: str) -> None:
    folder = tmp_path / "broken"
    shutil.copytree(overtaking, folder)
    (folder / name).write_bytes(content.encode("latin-1"))
    message = refusal(folder)
    assert str(folder / name) in message and words in message


def test_a_trace_with_a_gap_is_refused(overtaking: Path, tmp_path: Path) -> None:
    folder = tmp_path / "gap"
    shutil.copytree(overtaking, folder)
    lines = (folder / "trace.csv").read_text().splitlines()
    (folder / "trace.csv").write_text("\n".join([*lines[:10], *lines[11:]]) + "\n")
    assert "a row per tick would be right" in refusal(folder)


def test_layers_of_ones_own_are_told_to_be_missing(overtaking: Path, tmp_path: Path) -> None:
    folder = tmp_path / "own"
    shutil.copytree(overtaking, folder)
    result = json.loads((folder / "result.json").read_text())
    result["layers"].append("quiet_corner")
    (folder / "result.json").write_text(json.dumps(result))
    assert explain_run(folder, 1.0).warnings == ("the run had layers of its own, which a replay lacks: quiet_corner",)


def test_layers_that_the_run_left_out_are_left_out_again(overtaking: Path, tmp_path: Path) -> None:
    folder = tmp_path / "fewer"
    shutil.copytree(overtaking, folder)
    result = json.loads((folder / "result.json").read_text())
    result["layers"].remove("overtake")
    (folder / "result.json").write_text(json.dumps(result))
    assert "overtake" not in [one.layer for one in explain_run(folder, 2.0).way.layers]


def test_the_command_refuses_in_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", str(tmp_path / "nowhere"), "--time", "1"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("han-bullet: ") and error.count("\n") == 1


def test_a_picture_of_another_kind_is_refused(overtaking: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", str(overtaking), "--time", "1", "--plot", "moment.gif"]) == 2
    captured = capsys.readouterr()
    assert "'moment.gif' does not end in .png" in captured.err and captured.out == ""


def test_two_people_who_stand_abreast_close_the_corridor_by_their_bodies() -> None:
    places = {"anna": (6.0, 0.75), "bob": (6.0, -0.75)}
    run = made_run(places, 41, lambda camera, time: list(places.values()) if camera == "camera1" else [])
    explanation = explain(replayed(run))
    assert [person.track for person in explanation.people] in ([0, 1], [1, 0])
    assert explanation.way.best is None and explanation.way.taken_cost == math.inf
    (sentence,) = verdict(explanation.way)
    assert sentence.startswith("body closed the way, because of track ")
    assert "without it there is one of 13." in sentence
    drawn = paint(replayed(run), explanation)
    assert count(drawn, COLOURS[0]) > 200


def test_a_replay_says_what_the_robot_was_up_to_and_clears_when_it_did(monkeypatch: pytest.MonkeyPatch) -> None:
    cleared: list[float] = []
    monkeypatch.setattr(ObstacleLayer, "clear", lambda self: cleared.append(1.0))
    doings = [
        (0.0, Status.MOVING, None),
        (0.3, Status.WAITING, RecoveryStep.WAIT),
        (0.5, Status.WAITING, RecoveryStep.CLEAR),
    ]
    run = replace(made_run({"anna": (8.0, 0.0)}, 20, lambda *_: ()), doings=doings)
    assert [replay(run, time).tick.decision.status for time in (0.2, 0.4)] == [Status.MOVING, Status.WAITING]
    assert cleared == []
    decision = replay(run, 0.9).tick.decision
    assert (decision.status, decision.step, cleared) == (Status.WAITING, RecoveryStep.CLEAR, [1.0])
