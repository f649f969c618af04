"""Where worlds, URDFs and weights lie: inside an installed package, or beside it in a checkout."""

from __future__ import annotations

from pathlib import Path

from han_bullet.errors import HanError

_PACKAGE = Path(__file__).resolve().parent


def worlds_folder() -> Path:
    """Return the folder of the shipped world files."""
    return _find("worlds")


def urdf_folder() -> Path:
    """Return the folder of robot, avatars, furniture and textures."""
    return _find("urdf")


def models_folder() -> Path:
    """Return the folder of our trained weights."""
    return _PACKAGE / "models"


def _find(name: str) -> Path:
    for folder in (_PACKAGE / name, _PACKAGE.parent / name):
        if folder.is_dir():
            return folder
    raise HanError(f"folder {name!r} is neither in {_PACKAGE} nor beside it; the installation is incomplete")
