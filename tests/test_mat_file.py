"""MAT-files of version 5, sound, broken and hostile."""

import io
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from han_bullet.detection.mat_file import LARGEST_CONTENT, read_mat

HEADER = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"
VARIABLES = {
    "model": {
        "table": np.arange(6, dtype=np.float32).reshape(2, 3),
        "counts": np.array([[3, 70000]], np.uint32),
        "name": "luv",
        "inner": {"flag": True, "empty": np.empty((0, 0))},
        "list": np.array([np.float64(1.5), "text"], dtype=object),
    },
    "other": np.int16(-4),
}


def element(kind: int, content: bytes) -> bytes:
    return struct.pack("<II", kind, len(content)) + content + bytes(-len(content) % 8)


def array(class_: int, shape: tuple[int, ...], *parts: bytes, name: bytes = b"x") -> bytes:
    sides = struct.pack(f"<{len(shape)}i", *shape)
    return element(
        14, element(6, struct.pack("<II", class_, 0)) + element(5, sides) + element(1, name) + b"".join(parts)
    )


def numbers(count: int) -> bytes:
    return element(9, bytes(8 * count))


def saved(compressed: bool) -> bytes:
    stream = io.BytesIO()
    savemat(stream, VARIABLES, do_compression=compressed)
    return stream.getvalue()


def read(tmp_path: Path, content: bytes) -> dict[str, object]:
    path = tmp_path / "file.mat"
    path.write_bytes(content)
    return read_mat(path)


@pytest.mark.parametrize("compressed", [False, True])
def test_what_scipy_writes_comes_back(tmp_path: Path, compressed: bool) -> None:
    variables = read(tmp_path, saved(compressed))
    assert set(variables) == {"model", "other"}
    model = variables["model"]
    assert np.array_equal(model["table"], [[0, 1, 2], [3, 4, 5]])
    assert np.array_equal(model["counts"], [[3, 70000]])
    assert model["name"] == "luv"
    assert model["inner"]["flag"].item() == 1
    assert model["inner"]["empty"].size == 0
    assert model["list"][0].item() == 1.5
    assert model["list"][1] == "text"
    assert variables["other"].item() == -4


def test_a_list_of_structures_is_a_list(tmp_path: Path) -> None:
    stream = io.BytesIO()
    savemat(stream, {"each": np.array([(1.0,), (2.0,)], dtype=[("value", object)])})
    values = [entry["value"].item() for entry in read(tmp_path, stream.getvalue())["each"]]
    assert values == [1.0, 2.0]


def test_what_is_no_plain_value_reads_as_none(tmp_path: Path) -> None:
    handle = array(16, (1, 1), array(6, (1, 1), numbers(1)))
    complex_flag = element(6, struct.pack("<II", 0x0800 | 6, 0))
    names = element(5, struct.pack("<i", 32)) + element(1, b"handle".ljust(32, b"\0"))
    whole = array(2, (1, 1), names, handle, name=b"options")
    assert read(tmp_path, HEADER + whole) == {"options": {"handle": None}}
    assert read(tmp_path, HEADER + element(14, complex_flag)) == {"": None}


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "not a little-endian MAT-file"),
        (b"plain text" * 40, "not a little-endian MAT-file"),
        (HEADER[:124] + b"\x01\x00MI" + bytes(100), "not a little-endian MAT-file"),
        (b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + bytes(400), "version 7.3"),
        (b"\x89HDF\r\n\x1a\n" + bytes(400), "version 7.3"),
        (HEADER + b"\x0e\x00", "cut short"),
        (HEADER + struct.pack("<II", 14, 2**32 - 1), "beyond its end"),
        (HEADER + element(9, bytes(8)), "where a matrix should"),
        (HEADER + element(14, element(6, struct.pack("<II", 6, 0))), "a part of an array is missing"),
        (HEADER + element(14, element(9, struct.pack("<d", np.inf))), "a size is no whole number"),
        (HEADER + element(14, element(6, struct.pack("<II", 6, 0)) + element(7, b"\0\0\x80\x7f")), "no whole number"),
        (HEADER + array(6, (2**31 - 1, 2**31 - 1), numbers(1)), "stands in"),
        (HEADER + array(6, (3, 1), numbers(1)), "has 1 values"),
        (HEADER + array(6, (-3, 1), numbers(1)), "the shortest -3"),
        (HEADER + array(6, (1,), numbers(1)), "1 sides"),
        (HEADER + array(6, (1,) * 100_000, numbers(1)), "100000 sides"),
        (HEADER + array(6, (1, 1), element(9, bytes(5))), "no list of numbers"),
        (HEADER + array(1, (2**20, 1)), "stands in"),
        (HEADER + array(1, (50, 1), numbers(20)), "where a matrix should"),
        (HEADER + array(2, (1, 1), element(5, bytes(4)), element(1, b"name")), "4 bytes of field names, 0 to each"),
        (HEADER + array(2, (60_000, 1), element(5, b"\x01\0\0\0"), element(1, b""), bytes(60_000)), "60000 structures"),
        (HEADER + array(2, (1, 1), element(5, b"\x01\0\0\0"), element(1, bytes(60_000))), "60000 bytes of field names"),
        (HEADER + array(1, (20_000, 1), element(14, b"") * 20_000), "more than 10000 arrays"),
        (HEADER + element(15, b"no zlib stream"), "a compressed part is broken"),
        (HEADER + element(15, zlib.compress(bytes(100))[:-6]), "cut short"),
        (HEADER + element(15, zlib.compress(bytes(LARGEST_CONTENT + 1))), "hold more than"),
    ],
)
def test_a_broken_or_hostile_file_is_refused_with_its_reason(tmp_path: Path, content: bytes, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        read(tmp_path, content)


def test_structures_nested_without_end_are_refused(tmp_path: Path) -> None:
    content = numbers(1)
    for _ in range(3000):
        content = array(1, (1, 1), content)
    with pytest.raises(ValueError, match="more than 16 deep"):
        read(tmp_path, HEADER + content)


def test_many_packed_parts_share_one_limit(tmp_path: Path) -> None:
    part = element(15, zlib.compress(array(6, (1, LARGEST_CONTENT // 32), numbers(LARGEST_CONTENT // 32))))
    assert list(read(tmp_path, HEADER + part * 3)) == ["x"]
    with pytest.raises(ValueError, match="hold more than"):
        read(tmp_path, HEADER + part * 5)


def test_a_file_larger_than_any_model_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "large.mat"
    with path.open("wb") as file:
        file.truncate(LARGEST_CONTENT + 1)
    with pytest.raises(ValueError, match="at most"):
        read_mat(path)


@settings(max_examples=300, deadline=None)
@given(
    st.booleans(), st.lists(st.tuples(st.integers(128, 1500), st.integers(0, 255)), max_size=6), st.integers(0, 1500)
)
def test_changed_bytes_give_other_values_or_one_error(
    tmp_path_factory: pytest.TempPathFactory, compressed: bool, changes: list[tuple[int, int]], kept: int
) -> None:
    content = bytearray(saved(compressed))
    for place, byte in changes:
        content[place % len(content)] = byte
    try:
        variables = read(tmp_path_factory.getbasetemp(), bytes(content[: len(content) - kept if kept < 400 else None]))
    except ValueError as error:
        assert 0 < len(str(error)) < 300
    else:
        assert isinstance(variables, dict)
