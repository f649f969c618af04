"""Reads arrays of numbers from npz files, without trusting them.

Every size that the file claims is checked before anything is made of it, so that a broken or hostile file costs no more
memory than MOST_CONTENT. What is not asked for is not looked at.
"""

from __future__ import annotations

import io
import math
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

MOST_CONTENT = 64 * 2**20  # [bytes] of all arrays together
_KINDS = "biuf"  # truth values, integers, floating-point numbers
_npy: Any = np.lib.format  # which numpy leaves without types
_HEADERS = {(1, 0): _npy.read_array_header_1_0, (2, 0): _npy.read_array_header_2_0}
# What zipfile, zlib and numpy raise for damaged files, beside OSError.
_DAMAGE = (
    zipfile.BadZipFile,
    zlib.error,
    tokenize.TokenError,
    struct.error,
    EOFError,
    SyntaxError,
    TypeError,
    ArithmeticError,
    RuntimeError,
    MemoryError,
)


def read_npz(path: Path, names: Collection[str]) -> dict[str, NDArray[np.generic]]:
    """Return those of the arrays with these names that a file holds.

    Raises:
        OSError: It cannot be read.
        ValueError: It is no npz file, is broken, or holds more than MOST_CONTENT or other things than numbers.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            members = {name: archive.getinfo(f"{name}.npy") for name in names if f"{name}.npy" in archive.namelist()}
            total = sum(member.file_size for member in members.values())
            if total > MOST_CONTENT:
                raise ValueError(f"its arrays have {total} bytes, at most {MOST_CONTENT} are read")
            return {name: _array(name, _content(archive, member)) for name, member in members.items()}
    except _DAMAGE as error:
        raise ValueError(str(error) or type(error).__name__) from error


def _content(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> bytes:
    """Unpack a member, but never to more bytes than it claims."""
    if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(f"{member.filename} is packed by method {member.compress_type}, 0 or 8 would be right")
    with archive.open(member) as file:
        return file.read(member.file_size)


def _array(name: str, content: bytes) -> NDArray[np.generic]:
    """Make an array of a member's content."""
    stream = io.BytesIO(content)
    version = _npy.read_magic(stream)
    if version not in _HEADERS:
        raise ValueError(f"{name} is of npy version {version}, (1, 0) or (2, 0) would be right")
    shape, by_column, kind = _HEADERS[version](stream)
    if kind.kind not in _KINDS:
        raise ValueError(f"{name} holds values of type {kind}, numbers would be right")
    there = len(content) - stream.tell()
    if min(shape, default=0) < 0 or math.prod(shape) * kind.itemsize != there:
        raise ValueError(f"{name} claims shape {shape} of {kind}, but holds {there} bytes")
    values = np.frombuffer(content, kind, offset=stream.tell())
    return values.reshape(shape, order="F" if by_column else "C")
