"""The paper's network and the small one: sizes, first weights, files with torchvision's VGG-16."""

import math
import pickle
from pathlib import Path

import pytest
import torch
from safetensors.torch import save_file
from torch import nn

from han_bullet.detection.vgg import SmallVgg, VggD
from han_bullet.errors import BadInputError

# Numbers of the convolutions in torchvision's VGG-16, and their channels in and out.
TORCHVISION = {
    0: (3, 64),
    2: (64, 64),
    5: (64, 128),
    7: (128, 128),
    10: (128, 256),
    12: (256, 256),
    14: (256, 256),
    17: (256, 512),
    19: (512, 512),
    21: (512, 512),
    24: (512, 512),
    26: (512, 512),
    28: (512, 512),
}


@pytest.fixture(scope="module")
def network() -> VggD:
    """A network of 40 million weights, made once; tests may change its weights."""
    return VggD()


@pytest.fixture
def state() -> dict[str, torch.Tensor]:
    """What torchvision's VGG-16 would be, in half precision; every number in it stands for its layer."""
    found = {"classifier.0.weight": torch.zeros(4096, 2)}  # of another size than ours, and of no use
    for number, (channels, width) in TORCHVISION.items():
        found[f"features.{number}.weight"] = torch.full((width, channels, 3, 3), number / 64.0).half()
        found[f"features.{number}.bias"] = torch.full((width,), -number / 64.0).half()
    return found


def on_meta(*size: int) -> VggD:
    with torch.device("meta"):  # sizes alone
        return VggD(*size)


def test_vgg_d_has_14_7_million_weights_in_convolutions_and_25_2_million_in_fully_connected_layers() -> None:
    network = on_meta()
    assert (network.height, network.width) == (64, 64)
    assert sum(weight.numel() for weight in network.features.parameters()) == 14_714_688
    assert sum(weight.numel() for weight in network.head.parameters()) == 25_182_210
    assert [type(layer) for layer in network.features].count(nn.Conv2d) == 13
    assert [layer.out_features for layer in network.head if isinstance(layer, nn.Linear)] == [4096, 4096, 2]


def test_at_224_x_224_the_fully_connected_layers_are_those_of_the_original_but_for_the_last() -> None:
    head = [layer for layer in on_meta(224, 224).head if isinstance(layer, nn.Linear)]
    assert sum(weight.numel() for layer in head[:2] for weight in layer.parameters()) == 102_764_544 + 16_781_312


@pytest.mark.parametrize(("size", "cells"), [((64, 64), (2, 2)), ((128, 64), (4, 2)), ((112, 56), (3, 1))])
def test_512_channels_of_a_32nd_of_each_side_reach_the_head(size: tuple[int, int], cells: tuple[int, int]) -> None:
    network = on_meta(*size)
    features = network.features(torch.zeros(1, 3, *size, device="meta"))
    assert features.shape == (1, 512, *cells)
    assert network.head[0].in_features == 512 * cells[0] * cells[1]


def test_vgg_d_gives_two_logits_per_crop(network: VggD) -> None:
    with torch.inference_mode():
        logits = network.eval()(torch.rand(2, 3, 64, 64) * 255)
    assert logits.shape == (2, 2) and bool(torch.isfinite(logits).all())


@pytest.mark.parametrize("size", [(31, 64), (64, 16)])
def test_an_input_of_which_nothing_is_left_is_refused(size: tuple[int, int]) -> None:
    with pytest.raises(BadInputError, match=f"5 blocks that halve {size[0]} x {size[1]} px"):
        VggD(*size)


def test_without_a_file_convolutions_start_as_he_proposes_and_the_head_with_the_deviation_asked_for(
    network: VggD,
) -> None:
    with torch.random.fork_rng():
        torch.manual_seed(0)
        network.start(None, deviation=0.1)
    for number in (2, 12, 28):
        weight = network.features[number].weight
        assert weight.std().item() == pytest.approx(math.sqrt(2.0 / (9 * weight.shape[1])), rel=0.03)
        assert not network.features[number].bias.any()
    assert network.head[3].weight.std().item() == pytest.approx(0.1, rel=0.01)


@pytest.mark.parametrize("name", ["vgg16.pth", "vgg16.safetensors"])
def test_convolutions_of_torchvision_s_file_are_taken_and_the_head_is_drawn(
    network: VggD, state: dict[str, torch.Tensor], tmp_path: Path, name: str
) -> None:
    write = save_file if name.endswith("safetensors") else torch.save
    write(state, tmp_path / name)
    network.start(tmp_path / name)
    assert [number for number, layer in enumerate(network.features) if isinstance(layer, nn.Conv2d)] == [*TORCHVISION]
    for number in TORCHVISION:
        layer = network.features[number]
        assert layer.weight.dtype == torch.float32
        assert bool((layer.weight == number / 64.0).all()) and bool((layer.bias == -number / 64.0).all())
    assert network.head[3].weight.std().item() == pytest.approx(0.01, rel=0.01)


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("features.0.weight", torch.zeros(64, 1, 3, 3)),
        ("features.28.bias", torch.zeros(511)),
        ("features.5.bias", torch.full((128,), float("nan"))),
        ("features.7.bias", torch.zeros(128, dtype=torch.int64)),
        ("features.7.bias", torch.zeros(128).to_sparse()),
        ("features.10.bias", [0.0] * 256),
        ("features.12.bias", None),
    ],
)
def test_weights_of_another_kind_are_refused_by_name(
    network: VggD, state: dict[str, torch.Tensor], tmp_path: Path, name: str, wrong: object
) -> None:
    path = tmp_path / "odd.pth"
    torch.save(state | {name: wrong}, path)
    with pytest.raises(BadInputError, match=rf"odd\.pth: {name} must be \(\d+,.* finite numbers, as in torchvision"):
        network.start(path)


def test_files_of_something_else_are_one_sentence_each(network: VggD, tmp_path: Path) -> None:
    (tmp_path / "object.pth").write_bytes(pickle.dumps(Path("x")))
    torch.save(list(range(5)), tmp_path / "list.pth")
    torch.save({"features.0.weight": torch.zeros(64, 3, 3, 3)}, tmp_path / "cut.pth")
    (tmp_path / "cut.pth").write_bytes((tmp_path / "cut.pth").read_bytes()[:4000])
    save_file({"other": torch.zeros(3)}, tmp_path / "other.safetensors")
    expected = {
        "object.pth": "is refused: it is damaged or holds other things than tensors",
        "list.pth": "holds a list; tensors with names would be right",
        "cut.pth": "cannot be read as a file of tensors",
        "other.safetensors": r"features\.0\.weight must be \(64, 3, 3, 3\) finite numbers",
        "nowhere.pth": "No such file",
        "nowhere.safetensors": "No such file",
    }
    for name, sentence in expected.items():
        with pytest.raises(BadInputError, match=f"{name}.*{sentence}") as caught:
            network.start(tmp_path / name)
        assert "\n" not in str(caught.value)


def test_the_small_network_has_its_widths_and_starts_from_scratch_only(tmp_path: Path) -> None:
    small = SmallVgg(64, 48, widths=(4, 8), hidden=16)
    assert small.arguments == {"height": 64, "width": 48, "widths": [4, 8], "hidden": 16}
    assert small.head[0].in_features == 8 * 16 * 12
    small.start(None)
    assert small.head[0].weight.std().item() == pytest.approx(0.01, rel=0.03)
    with pytest.raises(BadInputError, match=r"the small network starts from scratch; .*vgg16\.pth is of no use to it"):
        small.start(tmp_path / "vgg16.pth")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"widths": []}, "0 blocks"),
        ({"widths": [4] * 7}, "7 blocks that halve 64 x 64 px"),
        ({"widths": [4] * 100_000}, "100000 blocks"),
        ({"widths": [4, 0]}, "width of block 2 is 0"),
        ({"widths": [4, "8"]}, "width of block 2 is '8'"),
        ({"widths": [10**12]}, "width of block 1 is 1000000000000"),
        ({"hidden": 0}, "hidden is 0"),
        ({"hidden": 10**12}, "hidden is 1000000000000"),
    ],
)
def test_a_small_network_of_impossible_sizes_is_refused(arguments: dict[str, object], sentence: str) -> None:
    with pytest.raises(BadInputError, match=sentence):
        SmallVgg(**arguments)
