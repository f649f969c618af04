"""Triangle meshes from Wavefront OBJ files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from han_bullet.errors import BadInputError
from han_bullet.sim.surfaces import Surface

LEAST_NUMBERS = {"v": 3, "vt": 2, "vn": 3}  # of a row, by its kind
_UP = (0.0, 0.0, 1.0)


class _Corner(NamedTuple):
    """Vertex [m], texture coordinates and normal; no normal is ()."""

    vertex: tuple[float, ...]
    uv: tuple[float, ...]
    normal: tuple[float, ...]


def read_obj(path: Path) -> tuple[Surface, Path | None]:
    """Read all faces of a file as one surface.

    Polygons become fans of triangles. A face without normals gets its own, a corner without texture coordinates (0, 0).

    Returns:
        The surface, and the picture that the first map_Kd of its material file names, or None.

    Raises:
        BadInputError: The file is missing, or is no OBJ file with faces.
    """
    try:
        lines = [line.split() for line in path.read_text(encoding="utf-8").splitlines()]
        return _surface(lines), _texture(path, lines)
    except (OSError, ValueError, IndexError) as error:
        raise BadInputError(f"mesh {path} is no OBJ file with faces that can be read ({error})") from error


def _surface(lines: Sequence[list[str]]) -> Surface:
    """Return the surface of all faces; a corner that several share is kept once, unless they lack normals."""
    rows: dict[str, list[tuple[float, ...]]] = {kind: [] for kind in LEAST_NUMBERS}
    corners: list[_Corner] = []
    numbers: dict[str, int] = {}
    triangles = []
    for words in lines:
        kind = words[0] if words else ""
        if kind in rows:
            rows[kind].append(_row(words))
        elif kind == "f":
            for word in words[1:]:
                if word not in numbers or "-" in word:  # what counts from the end is another one each time
                    numbers[word] = len(corners)
                    corners.append(_corner(word, rows))
            face = [numbers[word] for word in words[1:]]
            triangles += [(face[0], face[k], face[k + 1]) for k in range(1, len(face) - 1)]
    if not triangles:
        raise ValueError("it has none of three corners")
    triangles = [_with_normals(triangle, corners) for triangle in triangles]
    # A corner that only lent its place to others is no longer of use, but has no normal.
    vertices, uvs, normals = (
        np.array(part, float) for part in zip(*((c.vertex, c.uv, c.normal or _UP) for c in corners), strict=True)
    )
    return Surface(vertices, normals, uvs, np.array(triangles, np.int64))


def _row(words: Sequence[str]) -> tuple[float, ...]:
    row = tuple(map(float, words[1:]))
    if len(row) < LEAST_NUMBERS[words[0]]:
        raise ValueError(f"an entry {words[0]!r} has fewer than {LEAST_NUMBERS[words[0]]} numbers")
    return row


def _corner(word: str, rows: dict[str, list[tuple[float, ...]]]) -> _Corner:
    """Return what "1", "1/2", "1//3" or "1/2/3" names.

    Numbers count from 1, negative ones back from the last row so far. A normal without length is none.
    """
    numbers = [int(number) if number else 0 for number in (*word.split("/"), "", "")[:3]]
    vertex, uv, normal = (
        rows[kind][number - 1 if number > 0 else number] if number else ()
        for kind, number in zip(("v", "vt", "vn"), numbers, strict=True)
    )
    return _Corner(vertex[:3], uv[:2] or (0.0, 0.0), normal[:3] if any(normal) else ())


def _with_normals(triangle: tuple[int, int, int], corners: list[_Corner]) -> tuple[int, int, int]:
    """Return a triangle with normals; one without gets corners of its own, added to the others."""
    if all(corners[number].normal for number in triangle):
        return triangle
    first, second, third = (np.array(corners[number].vertex) for number in triangle)
    x, y, z = map(float, np.cross(second - first, third - first))
    if not (x or y or z):  # a triangle without area is never seen
        x, y, z = _UP
    end = len(corners)
    corners += [corners[number]._replace(normal=(x, y, z)) for number in triangle]
    return end, end + 1, end + 2


def _texture(path: Path, lines: Sequence[list[str]]) -> Path | None:
    libraries = [path.parent / " ".join(words[1:]) for words in lines if words[:1] == ["mtllib"]]
    for library in filter(Path.is_file, libraries):
        for words in map(str.split, library.read_text(encoding="utf-8").splitlines()):
            if words[:1] == ["map_Kd"] and len(words) > 1:
                whole = library.parent / " ".join(words[1:])
                return whole if whole.is_file() else library.parent / words[-1]  # options come before the name
    return None
