"""What a sweep runs: every world with every variant and every seed, checked before the first run starts."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import quote

from han_bullet.checks import check_world
from han_bullet.errors import BadInputError
from han_bullet.runner import RunOptions
from han_bullet.sweep.variants import parse_variant
from han_bullet.world_file import find_world, load_world


@dataclass(frozen=True)
class WorldFile:
    """A world as it travels to where it is run.

    Attributes:
        name: Of the file, without its ending; the world's name in the sweep.
        files: Name and content of the file, then of every other one that it needs beside it.
        cameras: Names of its cameras.
    """

    name: str
    files: tuple[tuple[str, bytes], ...]
    cameras: tuple[str, ...]

    @property
    def sha256(self) -> str:
        """Return the checksum as result.json has it, in hexadecimal digits."""
        return hashlib.sha256(b"".join(content for _, content in self.files)).hexdigest()


@dataclass(frozen=True)
class PlannedRun:
    """One run of a sweep.

    Attributes:
        world: Where.
        variant: How, in the words of the command line.
        options: The same, as the runner takes it, with the seed.
    """

    world: WorldFile
    variant: str
    options: RunOptions

    @property
    def folder(self) -> str:
        """Return the folder of the run's files, relative to the sweep's."""
        return f"runs/{self.world.name}/{_file_name(self.variant)}/{self.options.seed}"

    @property
    def row(self) -> str:
        """Return the file of the run's row, relative to the sweep's folder."""
        return f"rows/{self.world.name}.{_file_name(self.variant)}.{self.options.seed}.parquet"


def _file_name(variant: str) -> str:
    """Write a variant so that every file system takes it: `=` for the colon; `+` stays."""
    return quote(variant.replace(":", "="), safe="+=")


def plan_sweep(worlds: Sequence[str | Path], seeds: Sequence[int], variants: Sequence[str]) -> list[PlannedRun]:
    """Return the runs of a sweep: seed by seed, so that a look at an unfinished one sees all worlds and variants.

    Args:
        worlds: Names of shipped worlds or paths of YAML files.
        seeds: Of each world and variant.
        variants: As `parse_variant` takes them.

    Raises:
        BadInputError: A world, a variant or a camera that does not exist, or something twice.
    """
    files = [_read(world) for world in worlds]
    ways = {variant: parse_variant(variant) for variant in variants}
    _refuse_twice("world", [file.name for file in files])
    _refuse_twice("variant", list(variants))
    _refuse_twice("seed", [str(seed) for seed in seeds])
    for file in files:
        for variant, options in ways.items():
            missing = [camera for camera in options.cameras or () if camera not in file.cameras]
            if missing:
                raise BadInputError(
                    f"variant {variant!r}: world {file.name!r} has no camera {missing[0]!r}; it has "
                    f"{', '.join(file.cameras) or 'none'}"
                )
    return [
        PlannedRun(file, variant, replace(options, seed=seed))
        for seed in seeds
        for file in files
        for variant, options in ways.items()
    ]


def _read(name_or_path: str | Path) -> WorldFile:
    world, path = load_world(name_or_path), find_world(name_or_path)
    check_world(world, str(path))
    files = tuple((file.name, file.read_bytes()) for file in [path])
    return WorldFile(path.stem, files, tuple(camera.name for camera in world.cameras))


def _refuse_twice(kind: str, given: list[str]) -> None:
    twice = sorted({one for one in given if given.count(one) > 1})
    if twice:
        raise BadInputError(f"{kind} {twice[0]!r} is given twice; each once would be right")
