"""The import rule of the house, walked with ast, and what importing must not do."""

import ast
import dataclasses
import re
import subprocess
import sys
from pathlib import Path

import pytest

from han_bullet.messages import Observation

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "han_bullet"
MODULES = sorted(PACKAGE.rglob("*.py"))
STAGES = {"sim", "detection", "tracking", "costmap", "planning", "control", "localization", "health"}
VALUES = {"geometry", "messages", "errors", "assets", "atomic_file", "device_payload", "device_channel", "mecanum"}
WORLD = {"world_schema", "world_file", "wall_faces"}
ONLY_IN = {"pybullet": "sim", "torch": "detection", "rospy": None, "paho": "mqtt_channel"}


def imports(path: Path) -> set[str]:
    """Full names of everything a module imports, also inside functions."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def rooms(path: Path) -> set[str]:
    """The rooms and modules directly under han_bullet that a module imports."""
    return {name.split(".")[1] for name in imports(path) if name.startswith("han_bullet.")}


def room(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def test_there_are_modules_to_look_at() -> None:
    assert len(MODULES) > 30


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_a_module_imports_only_what_its_room_may(path: Path) -> None:
    here, used = room(path), rooms(path)
    if here in VALUES | WORLD:
        assert used <= VALUES | (WORLD if here in WORLD else set())
    elif here in STAGES:
        allowed = VALUES | WORLD | {here} | ({"costmap"} if here in {"planning", "control"} else set())
        assert used <= allowed
    elif here == "stack":
        assert used <= VALUES | STAGES - {"sim"} | WORLD | {"situation"}
    elif here == "known_devices":
        assert used <= VALUES


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_a_heavy_library_stays_in_its_room(path: Path) -> None:
    for library, owner in ONLY_IN.items():
        if any(name.split(".")[0] == library for name in imports(path)):
            assert room(path) == owner


@pytest.mark.parametrize("path", [p for p in MODULES if room(p) in {"planning", "control"}], ids=lambda p: p.name)
def test_planning_and_control_read_only_the_grid_of_the_costmap(path: Path) -> None:
    used = {name for name in imports(path) if name.startswith("han_bullet.costmap")}
    assert all(name.startswith("han_bullet.costmap.grid") for name in used)


@pytest.mark.parametrize(
    "path",
    [p for p in MODULES if room(p) in (STAGES - {"sim"}) | {"stack", "situation", "known_devices"}],
    ids=lambda p: str(p.relative_to(PACKAGE)),
)
def test_the_stack_never_sees_the_truth(path: Path) -> None:
    forbidden = {f"han_bullet.messages.{name}" for name in ("Truth", "TruePerson", "Contact")}
    assert not imports(path) & forbidden
    assert not rooms(path) & {"sim", "ablation"}


def test_an_observation_holds_nothing_of_the_truth() -> None:
    names = {field.name for field in dataclasses.fields(Observation)}
    assert names == {"time", "odometry", "laser", "images", "device_messages"}


def test_every_exported_name_exists() -> None:
    for path in MODULES:
        name = ".".join(("han_bullet", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__")
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.Assign) and any(
                isinstance(t, ast.Name) and t.id == "__all__" for t in node.targets
            ):
                module = __import__(name, fromlist=["_"])
                assert all(hasattr(module, exported) for exported in ast.literal_eval(node.value))


def test_every_module_of_the_detector_stands_once_where_newcomers_are_told_to_read() -> None:
    section = (ROOT / "docs/detector.md").read_text().split("## Where to read")[1].split("\n## ")[0]
    files = " ".join(re.findall(r"^\| `([^`]+)` \|", section, re.MULTILINE)).split()
    there = {path.name for path in (PACKAGE / "detection").glob("*.py")} - {"__init__.py"}
    assert sorted(files) == sorted(there | {"training/"})


def test_no_library_module_prints_or_exits() -> None:
    for path in MODULES:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id not in {"print", "exit", "quit"}, path


def test_the_core_imports_without_torch_or_a_window() -> None:
    modules = "han_bullet.world_file, han_bullet.planning.planner, han_bullet.costmap.layers"
    code = f"import sys, {modules}; assert not {{'torch', 'pybullet'}} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


HEAVY = ("torch", "pybullet", "numba", "scipy", "matplotlib", "cv2", "numpy", "pydantic")


@pytest.mark.parametrize(
    ("code", "unneeded"),
    [
        ("import han_bullet.cli", HEAVY),
        ("import han_bullet.fork_server", HEAVY),
        ("import han_bullet.runner", ("torch", "paho", "matplotlib", "imageio_ffmpeg")),
        ("from han_bullet.camera_workers import DetectorChoice; DetectorChoice().load()", ("matplotlib", "sympy")),
    ],
)
def test_starting_imports_no_more_than_it_needs(code: str, unneeded: tuple[str, ...]) -> None:
    check = f"import sys; {code}; print(*({set(unneeded)} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_a_run_with_true_perception_draws_and_detects_nothing_so_it_imports_neither(tmp_path: Path) -> None:
    command = ["run", "real2", "--perception", "truth", "--no-video", "--out", str(tmp_path)]
    check = (
        f"import sys; from han_bullet.cli import main; main({command}); print('torch' in sys.modules, file=sys.stderr)"
    )
    check = check.replace("'torch' in sys.modules", "{'torch', 'matplotlib', 'imageio_ffmpeg'} & set(sys.modules)")
    done = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "set()"


def test_every_source_that_is_cited_stands_in_the_references_and_the_other_way_round() -> None:
    files = [*MODULES, *ROOT.glob("docs/*.md"), *PACKAGE.glob("models/*.md"), *ROOT.glob("urdf/*.py")]
    cited = {key for file in files for key in re.findall(r"\[([A-Z][A-Za-z]+(?:19|20)\d\d)\]", file.read_text())}
    listed = set(re.findall(r"^\| (\w+\d{4}) \|", (ROOT / "docs/references.md").read_text(), re.MULTILINE))
    assert cited and cited == listed
