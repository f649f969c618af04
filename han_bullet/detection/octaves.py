"""What each octave of a pyramid must make so that the wanted parts of its levels are there, and no more."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from han_bullet.detection.channels import REACH
from han_bullet.detection.region import Region
from han_bullet.detection.resampling import sources
from han_bullet.detection.scales import LevelSize, octaves

HALF = 0.5  # the scale from whose colour planes the coarser ones are made

Needed = Callable[[LevelSize], Region | None]
"""Tells which part of a padded level [cells] is looked at, if any."""


@dataclass(frozen=True)
class Octave:
    """One real scale and the levels approximated from it.

    Attributes:
        real: The scale.
        levels: The parts of levels to make, by the level's size: without padding, but with the neighbours that
            smoothing looks at.
        channels: Part of the real channels [cells] that the levels are made from; None if there are no levels.
        planes: Part of the colour planes at this scale [px] that its channels and coarser planes are made from; None
            if there are neither.
    """

    real: LevelSize
    levels: dict[LevelSize, Region]
    channels: Region | None
    planes: Region | None = None


def plan(
    height: int,
    width: int,
    sizes: Sequence[LevelSize],
    cell: int,
    padding: tuple[int, int],
    needed: Needed | None,
) -> tuple[list[Octave], Region | None]:
    """Return the octaves, from fine to coarse, and the part of the image [px] that they are made from.

    Args:
        height: Of the image [px].
        width: Of the image [px].
        sizes: Of the pyramid's levels.
        cell: Side of a cell [px].
        padding: Rows above and below and columns beside each level [cells].
        needed: Which parts of the padded levels to make; None makes everything.
    """
    numbered = octaves(len(sizes))
    half = next((sizes[real] for real, _ in numbered if sizes[real].scale == HALF), None)
    of_image: Region | None = None
    of_half: Region | None = None
    planned = []
    for number, members in reversed(numbered):
        octave = _octave(sizes[number], [sizes[member] for member in members], padding, needed)
        wanted = None if octave.channels is None else neighbourhood(octave.channels, cell).refined(cell)
        if octave.real is half and of_half is not None:
            wanted = of_half.joined(wanted)
        if wanted is not None and half is not None and octave.real.scale < HALF:
            of_half = sources(wanted, half.rows * cell, half.columns * cell).joined(of_half)
        elif wanted is not None:
            of_image = sources(wanted, height, width).joined(of_image)
        planned.append(replace(octave, planes=wanted))
    return planned[::-1], of_image


def _octave(real: LevelSize, members: list[LevelSize], padding: tuple[int, int], needed: Needed | None) -> Octave:
    """Return an octave without its planes."""
    levels: dict[LevelSize, Region] = {}
    channels: Region | None = None
    for size in members:
        looked_at = None if needed is None else needed(size)
        if needed is not None and looked_at is None:
            continue
        whole = Region.all_of(size.rows, size.columns)
        levels[size] = whole if looked_at is None else _without_padding(looked_at, size, padding)
        channels = sources(levels[size], real.rows, real.columns).joined(channels)
    return Octave(real, levels, channels)


def _without_padding(padded: Region, size: LevelSize, padding: tuple[int, int]) -> Region:
    """Return what a part of a padded level is made from: cells of the level, with the neighbours for smoothing."""
    rows, columns = _inner(padded.rows, padding[0], size.rows), _inner(padded.columns, padding[1], size.columns)
    return Region(rows, columns, (size.rows, size.columns))


def _inner(padded: range, padding: int, end: int) -> range:
    return range(max(min(padded.start - padding - 1, end - 2), 0), min(max(padded.stop - padding + 1, 2), end))


def neighbourhood(channels: Region, cell: int) -> Region:
    """Return the cells that channels depend on, by smoothing, gradients and their normalisation."""
    return channels.grown(-(-REACH // cell))
