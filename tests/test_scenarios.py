"""Whole episodes: the worlds' expectations with cameras, the truth ablation, and equal results for equal seeds."""

import json
from pathlib import Path

import pytest
import yaml

from experiments import real2, sim1
from han_bullet.metrics import Metric
from han_bullet.runner import RunOptions, RunResult, run_world
from han_bullet.world_file import find_world, load_world

SEED = 1


def values(result: RunResult) -> dict[str, object]:
    return {metric.name: metric.value for metric in result.metrics}


def assert_expectations_met(result: RunResult) -> None:
    assert result.checks
    assert [check for check in result.checks if not check.passed] == []


@pytest.fixture(scope="session")
def real2_with_cameras(tmp_path_factory: pytest.TempPathFactory) -> RunResult:
    return real2.main(seed=SEED, folder=tmp_path_factory.mktemp("real2"), workers=2)


@pytest.mark.scenario
def test_real2_with_cameras_meets_its_expectations(real2_with_cameras: RunResult) -> None:
    assert_expectations_met(real2_with_cameras)


@pytest.mark.scenario
def test_people_are_where_the_cameras_put_them(real2_with_cameras: RunResult) -> None:
    metrics = values(real2_with_cameras)
    rmse = metrics["person_position_rmse"]
    assert isinstance(rmse, float) and 0.0 < rmse <= 0.15


@pytest.mark.scenario
def test_a_run_leaves_all_its_files(real2_with_cameras: RunResult) -> None:
    folder = real2_with_cameras.folder
    result = json.loads((folder / "result.json").read_text())
    assert result["localization"] == "simulator"
    assert result["perception"] == "cameras"
    assert result["outcome"] == "arrived"
    assert {metric["name"] for metric in result["metrics"]} == set(values(real2_with_cameras))
    assert (folder / "video.mp4").stat().st_size > 100_000
    header, *rows = (folder / "trace.csv").read_text().splitlines()
    assert header == (
        "time,robot.x,robot.y,robot.yaw,robot.vx,robot.vy,robot.omega,walker.x,walker.y,walker.yaw,walker.posture"
    )
    assert len(rows) > 200
    assert (folder / "tracks.csv").read_text().startswith("time,id,x,y,vx,vy,yaw,posture\n0")
    assert (folder / "detections.csv").read_text().startswith("time,camera,x,y,width,height,score,probability\n0")


@pytest.mark.scenario
def test_sim1_with_cameras_meets_its_expectations(tmp_path: Path) -> None:
    assert_expectations_met(sim1.main(seed=SEED, folder=tmp_path, workers=2, video=False))


@pytest.mark.scenario
@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("world", ["real2", "sim1"])
def test_with_perfect_perception_the_expectations_are_met(world: str, seed: int, tmp_path: Path) -> None:
    assert_expectations_met(run_world(world, RunOptions(seed=seed, perception="truth", video=False), tmp_path))


@pytest.mark.scenario
def test_with_traffic_on_the_other_side_the_robot_passes_on_the_right(tmp_path: Path) -> None:
    document = yaml.safe_load(find_world("real2").read_text())
    document["people"][0]["start"][1] = 0.2
    document["people"][0]["behaviour"]["waypoints"] = [[15.5, 0.2]]
    path = tmp_path / "mirrored.yaml"
    path.write_text(yaml.safe_dump(document))
    options = RunOptions(perception="truth", video=False, pass_side="right")
    assert values(run_world(path, options, tmp_path / "run"))["overtaking_side.walker"] == "right"


def brief(world: str, folder: Path, duration: float) -> Path:
    document = yaml.safe_load(find_world(world).read_text()) | {"duration": duration}
    path = folder / "brief.yaml"
    path.write_text(yaml.safe_dump(document))
    return path


def without_timings(folder: Path) -> dict[str, object]:
    result: dict[str, object] = json.loads((folder / "result.json").read_text())
    del result["timings"]
    return result


@pytest.mark.scenario
def test_the_same_seed_gives_the_same_files_whatever_the_number_of_workers(tmp_path: Path) -> None:
    world = brief("real2", tmp_path, duration=3.0)
    folders = []
    for workers in (1, 2, 4):
        folders.append(tmp_path / f"workers{workers}")
        run_world(world, RunOptions(seed=SEED, workers=workers, video=False), folders[-1])
    for name in ("trace.csv", "tracks.csv", "detections.csv"):
        first = (folders[0] / name).read_bytes()
        assert len(first.splitlines()) > 10
        assert all((folder / name).read_bytes() == first for folder in folders[1:])
    assert without_timings(folders[0]) == without_timings(folders[1]) == without_timings(folders[2])


@pytest.mark.scenario
def test_another_seed_gives_another_run(tmp_path: Path) -> None:
    world = brief("real2", tmp_path, duration=1.0)
    for seed in (1, 2):
        run_world(world, RunOptions(seed=seed, perception="truth", video=False), tmp_path / str(seed))
    assert (tmp_path / "1/trace.csv").read_bytes() != (tmp_path / "2/trace.csv").read_bytes()


@pytest.mark.scenario
def test_without_the_overtake_layer_the_planner_pays_nothing_for_the_right_side(tmp_path: Path) -> None:
    options = RunOptions(perception="truth", video=False, without=("overtake", "personal_walking"))
    run_world("real2", options, tmp_path)
    layers = json.loads((tmp_path / "result.json").read_text())["layers"]
    assert layers == ["static", "inflation", "body", "personal_still", "visibility", "interaction"]


def test_metrics_are_told_with_their_definitions(real2_with_cameras: RunResult) -> None:
    assert all(isinstance(metric, Metric) and metric.definition for metric in real2_with_cameras.metrics)
    assert load_world("real2").expectations
