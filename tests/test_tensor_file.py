"""Files of tensors: what comes back, and what is refused without being unpickled."""

import pickle
import warnings
from pathlib import Path

import pytest
import torch
from safetensors.torch import save_file

from han_bullet.detection.tensor_file import read_tensors
from han_bullet.errors import BadInputError


class Bomb:
    """An object that leaves a file behind when it is unpickled."""

    def __init__(self, trace: Path) -> None:
        self.trace = trace

    def __reduce__(self) -> tuple[object, tuple[object, ...]]:
        return (Path.touch, (self.trace,))


@pytest.mark.parametrize(("name", "write"), [("a.pth", torch.save), ("a.safetensors", save_file)])
def test_tensors_come_back_with_their_names(tmp_path: Path, name: str, write: object) -> None:
    tensors = {"first": torch.arange(6.0).reshape(2, 3), "second": torch.tensor([1.5])}
    write(tensors, tmp_path / name)  # type: ignore[operator]
    read = read_tensors(tmp_path / name)
    assert list(read) == ["first", "second"]
    assert all(torch.equal(read[key], tensor) for key, tensor in tensors.items())


def test_an_object_is_refused_and_never_built(tmp_path: Path) -> None:
    trace, path = tmp_path / "trace", tmp_path / "bomb.pth"
    for content in (pickle.dumps({"weights": Bomb(trace)}), None):
        if content is None:
            torch.save({"weights": Bomb(trace)}, path)
        else:
            path.write_bytes(content)
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # the refusal is one sentence, without torch's own beside it
            with pytest.raises(BadInputError, match=r"bomb\.pth is refused: it is damaged or holds other things"):
                read_tensors(path)
        assert not trace.exists()
    pickle.loads(pickle.dumps(Bomb(trace)))
    assert trace.exists()  # so it was a bomb


@pytest.mark.parametrize("name", ["x.pth", "x.safetensors"])
@pytest.mark.parametrize("content", [b"", b"hello", b"\x00" * 100, b"PK\x03\x04" + b"\x01" * 60, b"\x80\x04]."])
def test_a_damaged_file_is_one_sentence_with_its_name(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(BadInputError) as caught:
        read_tensors(tmp_path / name)
    assert name in str(caught.value) and "\n" not in str(caught.value) and len(str(caught.value)) < 500


@pytest.mark.parametrize(("name", "write"), [("a.pth", torch.save), ("a.safetensors", save_file)])
def test_half_a_file_is_refused(tmp_path: Path, name: str, write: object) -> None:
    write({"first": torch.zeros(1000)}, tmp_path / name)  # type: ignore[operator]
    whole = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(whole[: len(whole) // 2])
    with pytest.raises(BadInputError, match=f"{name} cannot be read as a file of tensors"):
        read_tensors(tmp_path / name)


@pytest.mark.parametrize("name", ["nowhere.pth", "nowhere.safetensors"])
def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(BadInputError, match=f"{name} cannot be read.*No such file"):
        read_tensors(tmp_path / name)
    (tmp_path / name).mkdir()
    with pytest.raises(BadInputError, match=f"{name} cannot be read"):
        read_tensors(tmp_path / name)


def test_a_tensor_without_a_name_is_refused(tmp_path: Path) -> None:
    torch.save(torch.zeros(3), tmp_path / "one.pth")
    with pytest.raises(BadInputError, match=r"one\.pth holds a Tensor; tensors with names would be right"):
        read_tensors(tmp_path / "one.pth")
