"""Reads the structures in Matlab's MAT-files of version 5, without trusting them.

Every size in the file is checked against the bytes that are there before anything is made of it, so that a broken or
hostile file costs no more memory than its own length, and no time. Complex, sparse and opaque values, objects and
function handles are passed over: they read as None.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Value = dict[str, "Value"] | list["Value"] | NDArray[np.generic] | str | None
"""A structure; a cell array or an array of structures; numbers, with Matlab's indices; a text; anything else."""

LARGEST_CONTENT = 16 * 2**20  # [bytes] of a file, and of all that is packed in it
MOST_ARRAYS = 10_000
MOST_DIMENSIONS = 8
DEEPEST = 16  # structures within structures

_HEADER = 128
_MATRIX, _COMPRESSED = 14, 15
_NUMBERS = {1: "i1", 2: "u1", 3: "<i2", 4: "<u2", 5: "<i4", 6: "<u4", 7: "<f4", 9: "<f8", 12: "<i8", 13: "<u8"}
_TEXTS = {1: "utf-8", 2: "utf-8", 4: "utf-16-le", 16: "utf-8", 17: "utf-16-le", 18: "utf-32-le"}
_CELL, _STRUCTURE, _CHARACTERS = 1, 2, 4
_NUMERIC_CLASSES = range(6, 16)
_COMPLEX = 0x0800


def read_mat(path: Path) -> dict[str, Value]:
    """Return the variables of a file by their names.

    Raises:
        OSError: It cannot be read.
        ValueError: It is not a little-endian MAT-file of version 5, or is broken.
    """
    size = path.stat().st_size
    if size > LARGEST_CONTENT:
        raise ValueError(f"it has {size} bytes, at most {LARGEST_CONTENT} are read")
    content = path.read_bytes()
    if content[124:128] == b"\x00\x02IM" or content[:8] == b"\x89HDF\r\n\x1a\n":
        raise ValueError("it is a MAT-file of version 7.3 (HDF5); one saved with -v7 would be right")
    if content[124:128] != b"\x00\x01IM":
        raise ValueError("it is not a little-endian MAT-file of version 5")
    reader = _Reader()
    return dict(reader.matrix(kind, part, DEEPEST) for kind, part in _parts(memoryview(content)[_HEADER:]))


def _parts(data: memoryview) -> Iterator[tuple[int, memoryview]]:
    """Yield the elements of a file, those that are packed unpacked."""
    room = LARGEST_CONTENT
    for kind, part in _elements(data):
        if kind == _COMPRESSED:
            unpacked = _unpack(part, room)
            room -= len(unpacked)
            yield from _elements(unpacked)
        else:
            yield kind, part


def _unpack(data: memoryview, room: int) -> memoryview:
    """Return decompressed bytes, so many at most."""
    inflater = zlib.decompressobj()
    try:
        unpacked = inflater.decompress(data, room + 1)
    except zlib.error as error:
        raise ValueError(f"a compressed part is broken ({error})") from error
    if not inflater.eof or len(unpacked) > room:
        raise ValueError(f"its compressed parts are cut short or hold more than {LARGEST_CONTENT} bytes")
    return memoryview(unpacked)


def _elements(data: memoryview) -> Iterator[tuple[int, memoryview]]:
    """Yield type and bytes of one element after another."""
    start = 0
    while start < len(data):
        if start + 8 > len(data):
            raise ValueError("it is cut short")
        kind, length = struct.unpack_from("<II", data, start)
        small = kind >> 16  # an element of four bytes or less stands in its own tag
        first = start + (4 if small else 8)
        length = small or length
        if (small and small > 4) or first + length > len(data):
            raise ValueError(f"an element of {length} bytes reaches beyond its end")
        kind &= 0xFFFF
        yield kind, data[first : first + length]
        start = start + 8 if small else first + length + (0 if kind == _COMPRESSED else -length % 8)


class _Reader:
    """Makes values of matrix elements, and counts them."""

    def __init__(self) -> None:
        self._arrays = 0

    def matrix(self, kind: int, data: memoryview, depth: int) -> tuple[str, Value]:
        """Return name and value of a matrix element."""
        if kind != _MATRIX:
            raise ValueError(f"an element of type {kind} stands where a matrix should")
        self._arrays += 1
        if self._arrays > MOST_ARRAYS:
            raise ValueError(f"it holds more than {MOST_ARRAYS} arrays")
        if depth == 0:
            raise ValueError(f"its structures are more than {DEEPEST} deep")
        if not data:
            return "", np.empty(0)
        parts = _elements(data)
        flags = [*_integers(*_next(parts)), 0][0]
        kind_of_array = flags & 0xFF
        if kind_of_array not in (_CELL, _STRUCTURE, _CHARACTERS, *_NUMERIC_CLASSES) or flags & _COMPLEX:
            return "", None
        shape = _integers(*_next(parts))
        count = _values_of(shape, len(data))
        name = _text(*_next(parts))
        if kind_of_array == _CELL:
            return name, [self.matrix(*_next(parts), depth - 1)[1] for _ in range(count)]
        if kind_of_array == _STRUCTURE:
            return name, self._structure(parts, count, depth)
        if kind_of_array == _CHARACTERS:
            return name, _text(*_next(parts))
        numbers = _numbers(*_next(parts)) if count else np.empty(0)
        if numbers.size != count:
            raise ValueError(f"an array of shape {shape} has {numbers.size} values")
        return name, numbers.reshape(shape, order="F")

    def _structure(self, parts: Iterator[tuple[int, memoryview]], count: int, depth: int) -> Value:
        """Return a structure, or a list of them where there is not just one."""
        length = [*_integers(*_next(parts)), 0][0]
        _, names = _next(parts)
        if length <= 0 or len(names) > MOST_ARRAYS * length or count > MOST_ARRAYS:
            raise ValueError(f"it has {count} structures with {len(names)} bytes of field names, {length} to each")
        fields = [_cut_text(names[start : start + length]) for start in range(0, len(names), length)]
        structures: list[Value] = [
            {field: self.matrix(*_next(parts), depth - 1)[1] for field in fields} for _ in range(count)
        ]
        return structures[0] if count == 1 else structures


def _values_of(shape: list[int], size: int) -> int:
    """Return how many values an array has that stands in so many bytes."""
    if not 2 <= len(shape) <= MOST_DIMENSIONS or min(shape) < 0:
        raise ValueError(f"an array has {len(shape)} sides, the shortest {min(shape, default=0)}")
    count = math.prod(shape)  # of any size: no overflow
    if count > size:
        raise ValueError(f"an array of shape {shape} stands in {size} bytes")
    return count


def _next(parts: Iterator[tuple[int, memoryview]]) -> tuple[int, memoryview]:
    """Return the next element."""
    element = next(parts, None)
    if element is None:
        raise ValueError("a part of an array is missing")
    return element


def _numbers(kind: int, data: memoryview) -> NDArray[np.generic]:
    """Return the values of a numeric element, as they are stored."""
    if kind not in _NUMBERS or len(data) % np.dtype(_NUMBERS[kind]).itemsize:
        raise ValueError(f"an element of type {kind} with {len(data)} bytes is no list of numbers")
    return np.frombuffer(data, _NUMBERS[kind])


def _integers(kind: int, data: memoryview) -> list[int]:
    """Return the whole numbers of an element."""
    numbers = _numbers(kind, data)
    if numbers.dtype.kind == "f":
        raise ValueError("a size is no whole number")
    return [int(number) for number in numbers]


def _text(kind: int, data: memoryview) -> str:
    """Return the text of an element."""
    if kind not in _TEXTS:
        raise ValueError(f"an element of type {kind} is no text")
    return bytes(data).decode(_TEXTS[kind], errors="replace")


def _cut_text(data: memoryview) -> str:
    """Return a text that ends with the first zero byte."""
    return bytes(data).split(b"\0")[0].decode("utf-8", errors="replace")
