"""The default network: its sizes, and the weights from which it starts."""

from pathlib import Path

import numpy as np
import pytest
import torch

from han_bullet.detection.squeezenet import SqueezeTrunk, _side_after_trunk, decode_squeezenet
from han_bullet.errors import BadInputError


@pytest.mark.parametrize(("height", "width"), [(112, 56), (64, 64), (128, 64), (97, 33), (224, 51), (21, 22)])
def test_what_is_left_of_a_side_is_what_torch_leaves_of_it(height: int, width: int) -> None:
    network = SqueezeTrunk(height, width, hidden=2).eval()
    with torch.inference_mode():
        features = network.features(torch.zeros(1, 3, height, width))
        logits = network(torch.zeros(2, 3, height, width))
    assert features.shape == (1, 512, _side_after_trunk(height), _side_after_trunk(width))
    assert logits.shape == (2, 2)


def test_the_default_has_6_x_3_cells_of_512_numbers_and_1_7_million_weights() -> None:
    network = SqueezeTrunk()
    assert (network.height, network.width) == (112, 56)
    assert network.head[0].in_features == 512 * 6 * 3
    assert sum(weight.numel() for weight in network.features.parameters()) == 538_240
    assert sum(weight.numel() for weight in network.head.parameters()) == 9216 * 128 + 128 + 128 * 2 + 2


@pytest.mark.parametrize(("height", "width"), [(5, 64), (64, 20), (12, 12)])
def test_an_input_of_which_nothing_is_left_is_refused(height: int, width: int) -> None:
    with pytest.raises(BadInputError, match=f"{height} x {width} px leaves nothing"):
        SqueezeTrunk(height, width)


@pytest.mark.parametrize("hidden", [0, -1, 10**9, "128"])
def test_hidden_layers_of_no_size_are_refused(hidden: int) -> None:
    with pytest.raises(BadInputError, match=r"hidden is .*; a whole number from 1 to 65536"):
        SqueezeTrunk(hidden=hidden)


def test_it_does_not_start_without_imagenet_weights() -> None:
    with pytest.raises(BadInputError, match=r"squeezenet starts from ImageNet weights.*compressed_SqueezeNet\.net"):
        SqueezeTrunk(hidden=2).start(None)


def write_compressed(path: Path, shapes: list[tuple[int, ...]], layers: int) -> None:
    """Write every weight as its own code, 1 + number % 200 over 1000, and biases of half the layer's number."""
    counts = np.zeros(26, "<u4")
    codebook = np.arange(256, dtype="<f4") / 1000
    content = b""
    for number, shape in enumerate(shapes[:layers]):
        counts[number] = count = int(np.prod(shape))
        codes = (1 + np.arange(count) % 200).astype(np.uint8)
        bias = np.full(shape[0], 0.5 * number, "<f4")
        content += codebook.tobytes() + bias.tobytes() + codes.tobytes() + bytes((count + 1) // 2)
    path.write_bytes(counts.tobytes() + content)


def test_starting_takes_the_convolutions_for_rgb_and_draws_the_rest(tmp_path: Path) -> None:
    network = SqueezeTrunk(hidden=64)
    convolutions = [layer for layer in network.features.modules() if isinstance(layer, torch.nn.Conv2d)]
    shapes = [tuple(layer.weight.shape) for layer in convolutions]
    assert len(shapes) == 22
    write_compressed(tmp_path / "tiny.net", shapes, 22)
    network.start(tmp_path / "tiny.net", deviation=0.05)
    in_file = (1 + np.arange(96 * 3 * 49) % 200).reshape(96, 3, 7, 7).astype(np.float32) / 1000
    np.testing.assert_allclose(convolutions[0].weight.detach().numpy(), in_file[:, ::-1], rtol=1e-6)
    flat = convolutions[21].weight.detach().numpy().ravel()
    np.testing.assert_allclose(flat, (1 + np.arange(flat.size) % 200) / 1000, rtol=1e-6)
    assert [layer.bias[0].item() for layer in convolutions] == [0.5 * number for number in range(22)]
    assert network.head[0].weight.std().item() == pytest.approx(0.05, rel=0.02)


def test_a_file_with_fewer_layers_is_refused_by_name(tmp_path: Path) -> None:
    network = SqueezeTrunk(hidden=2)
    shapes = [tuple(layer.weight.shape) for layer in network.features.modules() if isinstance(layer, torch.nn.Conv2d)]
    write_compressed(tmp_path / "few.net", shapes, 5)
    with pytest.raises(BadInputError, match=r"few\.net is not a deep-compressed SqueezeNet"):
        network.start(tmp_path / "few.net")


def test_deep_compressed_layer_decodes_codes_and_runs(tmp_path: Path) -> None:
    codebook = np.arange(256, dtype="<f4") * 0.5
    bias = np.array([1.0, -1.0], "<f4")
    counts = np.zeros(26, "<u4")
    counts[0] = 3
    codes = bytes([2, 4, 6])
    runs = bytes([0x20, 0x01])  # runs 0, 2, 1: weights number 0, 3 and 5
    path = tmp_path / "tiny.net"
    path.write_bytes(counts.tobytes() + codebook.tobytes() + bias.tobytes() + codes + runs)
    (weight, decoded_bias), *_ = decode_squeezenet(path, [(2, 3, 1, 1)])
    np.testing.assert_array_equal(weight.ravel(), [1.0, 0.0, 0.0, 2.0, 0.0, 3.0])
    np.testing.assert_array_equal(decoded_bias, bias)


@pytest.mark.parametrize("content", [b"", b"\x05\x00\x00\x00" * 26, b"\xff" * 5000])
def test_truncated_compressed_file_is_refused_by_name(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "short.net").write_bytes(content)
    with pytest.raises(BadInputError, match=r"short\.net"):
        decode_squeezenet(tmp_path / "short.net", [(2, 3, 1, 1)])
    with pytest.raises(BadInputError, match=r"nowhere\.net"):
        decode_squeezenet(tmp_path / "nowhere.net", [(2, 3, 1, 1)])


def test_weights_that_are_not_finite_are_refused_with_their_layer(tmp_path: Path) -> None:
    write_compressed(tmp_path / "nan.net", [(2, 3, 1, 1), (4, 2, 1, 1)], 2)
    content = bytearray((tmp_path / "nan.net").read_bytes())
    second = 26 * 4 + 1024 + 2 * 4 + 6 + 3  # behind counts, and codebook, biases, codes and runs of the first layer
    content[second : second + 4] = np.float32(np.nan).tobytes()
    (tmp_path / "nan.net").write_bytes(bytes(content))
    assert len(decode_squeezenet(tmp_path / "nan.net", [(2, 3, 1, 1)])) == 1
    with pytest.raises(BadInputError, match=r"nan\.net .*weights of layer 2 are not all finite"):
        decode_squeezenet(tmp_path / "nan.net", [(2, 3, 1, 1), (4, 2, 1, 1)])


@pytest.mark.data
def test_activations_of_the_imagenet_network_are_about_as_large_as_the_head_expects(data_folder: Path) -> None:
    network = SqueezeTrunk(hidden=2)
    network.start(data_folder / "squeezenet" / "compressed_SqueezeNet.net")
    crops = torch.from_numpy(np.random.default_rng(0).uniform(0, 255, (4, 3, 112, 56)).astype(np.float32))
    with torch.inference_mode():
        activations = network.features(crops - 117.0) / 100.0
    assert 0.1 < activations.std().item() < 3.0
