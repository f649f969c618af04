"""A wheel, installed in an empty folder, finds its worlds, URDFs and models."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    files = subprocess.run(
        ["git", "-C", str(ROOT), "ls-files", "--cached", "--others", "--exclude-standard", "-z"],
        capture_output=True,
        check=True,
        text=True,
    ).stdout
    for name in filter(None, files.split("\0")):
        if (ROOT / name).is_file():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            (source / name).write_bytes((ROOT / name).read_bytes())
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(source)]
    subprocess.run(command, check=True)
    return next(folder.glob("*.whl"))


def test_the_wheel_holds_worlds_bodies_and_weights(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    for wanted in ("worlds/real2.yaml", "urdf/mbot.urdf", "models/acf_inria.npz", "models/cnn_inria.safetensors"):
        assert f"han_bullet/{wanted}" in names
    assert any(name.startswith("han_bullet/urdf/meshes/") for name in names)
    assert any(name.startswith("han_bullet/urdf/textures/") for name in names)


def test_an_unpacked_wheel_runs_a_world_away_from_the_checkout(wheel: Path, tmp_path: Path) -> None:
    installed, empty = tmp_path / "installed", tmp_path / "empty"
    empty.mkdir()
    zipfile.ZipFile(wheel).extractall(installed)
    code = (
        f"import sys; sys.path.insert(0, {str(installed)!r})\n"
        "import han_bullet; assert han_bullet.__file__.startswith(sys.path[0]), han_bullet.__file__\n"
        "from pathlib import Path\n"
        "from han_bullet import assets\n"
        "assert str(assets.urdf_folder()).startswith(sys.path[0])\n"
        "from han_bullet.cli import main\n"
        "sys.exit(main(['worlds', 'real2']))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=empty, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "camera1" in done.stdout
