"""Npz files, whole, damaged and hostile."""

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from han_bullet.detection import npz_file
from han_bullet.detection.npz_file import read_npz

VALUES = {"a": np.arange(12.0).reshape(3, 4), "b": np.int64(7), "c": np.asfortranarray(np.arange(6).reshape(2, 3))}


def npy(values: np.ndarray) -> bytes:
    content = io.BytesIO()
    np.save(content, values)
    return content.getvalue()


def pack(path: Path, content: bytes, method: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", method) as archive:
        archive.writestr("a.npy", content)
    return path


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_the_arrays_asked_for_come_back_and_no_others(tmp_path: Path, save: object) -> None:
    save(tmp_path / "it.npz", **VALUES)
    for names in (["a", "b"], ["c", "missing"], []):
        read = read_npz(tmp_path / "it.npz", names)
        assert sorted(read) == [name for name in names if name in VALUES]
        for name, values in read.items():
            assert values.dtype == VALUES[name].dtype
            assert np.array_equal(values, VALUES[name])


def test_more_than_the_most_content_is_refused_before_it_is_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    np.savez_compressed(tmp_path / "it.npz", a=np.zeros(100), b=np.zeros(100))
    monkeypatch.setattr(npz_file, "MOST_CONTENT", 1500)
    assert read_npz(tmp_path / "it.npz", ["a"])["a"].shape == (100,)
    monkeypatch.setattr(npz_file, "_content", None)
    with pytest.raises(ValueError, match="its arrays have 1856 bytes, at most 1500 are read"):
        read_npz(tmp_path / "it.npz", ["a", "b"])


def test_a_member_that_unpacks_to_more_than_it_claims_is_refused(tmp_path: Path) -> None:
    path = pack(tmp_path / "it.npz", npy(np.zeros(10**6)))
    with zipfile.ZipFile(path) as archive:
        size = archive.getinfo("a.npy").file_size
    path.write_bytes(path.read_bytes().replace(size.to_bytes(4, "little"), (208).to_bytes(4, "little")))
    with pytest.raises(ValueError, match="Bad CRC-32"):
        read_npz(path, ["a"])


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_a_packing_that_numpy_does_not_write_is_refused(tmp_path: Path, method: int) -> None:
    with pytest.raises(ValueError, match=rf"packed by method {method}, 0 or 8 would be right"):
        read_npz(pack(tmp_path / "it.npz", npy(np.zeros(3)), method), ["a"])


@pytest.mark.parametrize(
    "header",
    [
        b"{'descr': '<f8', 'fortran_order': False, 'shape': (",
        b"{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }}",
        b"{'descr': '<f99', 'fortran_order': False, 'shape': (2,), }",
        b"{'descr': '<f8', 'fortran_order': False, 'shape': (0, 1%s), }" % (b"0" * 40),
        b"{'descr': '<c8', 'fortran_order': False, 'shape': (2,), }",
        b"[" * 5000,
        b"",
        b"'" + bytes(range(256)),
    ],
)
def test_a_malformed_header_is_refused(tmp_path: Path, header: bytes) -> None:
    content = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + bytes(16)
    with pytest.raises(ValueError):
        read_npz(pack(tmp_path / "it.npz", content), ["a"])


@pytest.mark.parametrize("content", [b"", b"\x93NUMPY", b"\x93NUMPY\x09\x00" + bytes(50), b"text, not numbers"])
def test_a_member_that_is_no_array_is_refused(tmp_path: Path, content: bytes) -> None:
    with pytest.raises(ValueError):
        read_npz(pack(tmp_path / "it.npz", content), ["a"])


def test_a_missing_file_is_an_os_error(tmp_path: Path) -> None:
    with pytest.raises(OSError, match=r"nowhere\.npz"):
        read_npz(tmp_path / "nowhere.npz", ["a"])
