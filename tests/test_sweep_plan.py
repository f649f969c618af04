"""The plan of a sweep: every combination once, refused as a whole where one of them cannot be run."""

import hashlib
from pathlib import Path

import pytest
import yaml

from han_bullet.errors import BadInputError
from han_bullet.sweep.plan import plan_sweep
from han_bullet.world_file import find_world


def changed(folder: Path, **changes: object) -> Path:
    """A copy of real2 with other values."""
    path = folder / "mine.yaml"
    path.write_text(yaml.safe_dump(yaml.safe_load(find_world("real2").read_text()) | changes))
    return path


def test_every_world_is_run_with_every_variant_and_seed() -> None:
    plan = plan_sweep(["real2", "sim1"], [0, 4], ["truth", "truth+without:overtake"])
    assert {(run.world.name, run.variant, run.options.seed) for run in plan} == {
        (world, variant, seed)
        for world in ("real2", "sim1")
        for variant in ("truth", "truth+without:overtake")
        for seed in (0, 4)
    }
    assert len(plan) == 8 and {run.options.seed for run in plan[:4]} == {0}
    assert all(run.options.without == (("overtake",) if "without" in run.variant else ()) for run in plan)


def test_files_have_names_that_every_file_system_takes_and_no_two_runs_share() -> None:
    plan = plan_sweep(["real2"], [7], ["cameras+nn", "camera:onboard+threshold:40"])
    assert plan[0].folder == "runs/real2/cameras+nn/7"
    assert plan[1].folder == "runs/real2/camera=onboard+threshold=40/7"
    assert plan[1].row == "rows/real2.camera=onboard+threshold=40.7.parquet"


def test_a_world_travels_as_its_files_content(tmp_path: Path) -> None:
    path = changed(tmp_path, duration=2.0)
    (run,) = plan_sweep([path], [0], ["truth"])
    assert run.world.name == "mine" and run.world.files == (("mine.yaml", path.read_bytes()),)
    assert run.world.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert run.world.cameras == ("camera1", "camera2", "camera3", "camera4", "onboard")


def test_a_camera_that_one_world_lacks_is_refused_for_all(tmp_path: Path) -> None:
    camera = yaml.safe_load(find_world("real2").read_text())["cameras"][0]
    blind = changed(tmp_path, cameras=[camera])
    plan_sweep(["real2"], [0], ["camera:onboard"])
    with pytest.raises(BadInputError, match=r"'camera:onboard': world 'mine' has no camera 'onboard'; it has camera1"):
        plan_sweep(["real2", blind], [0], ["truth", "camera:onboard"])


def test_a_world_that_cannot_be_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"robot\.start"):
        plan_sweep(["real2", changed(tmp_path, robot={"start": [0.0, 1.5, 0.0]})], [0], ["truth"])


@pytest.mark.parametrize(
    ("worlds", "seeds", "variants", "twice"),
    [
        (["real2", "real2"], [0], ["truth"], "world 'real2'"),
        (["real2"], [0, 3, 3], ["truth"], "seed '3'"),
        (["real2"], [0], ["truth", "cameras", "truth"], "variant 'truth'"),
    ],
)
def test_what_is_given_twice_is_refused(worlds: list[str], seeds: list[int], variants: list[str], twice: str) -> None:
    with pytest.raises(BadInputError, match=f"{twice} is given twice"):
        plan_sweep(worlds, seeds, variants)
