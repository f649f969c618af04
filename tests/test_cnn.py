"""The second stage: crops, weights on disk, probabilities."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from safetensors.torch import load_file, save_file

from han_bullet import assets
from han_bullet.detection.cnn import Classifier, crop, load_classifier, load_network, save_network
from han_bullet.detection.networks import SmallVgg, SqueezeTrunk, decode_squeezenet
from han_bullet.errors import BadInputError

IMAGE = np.random.default_rng(0).integers(0, 256, (480, 640, 3), dtype=np.uint8)
BOXES = np.array([[100.0, 100.0, 41.0, 100.0], [300.0, 50.0, 82.0, 200.0], [-10.0, 380.0, 61.5, 150.0]])


@pytest.fixture
def network() -> SmallVgg:
    with torch.random.fork_rng():
        torch.manual_seed(3)
        small = SmallVgg(widths=(4, 8), hidden=8)
        small.start()
    return small


def test_crop_is_the_64_by_128_window_around_a_person_of_100_px_squeezed_to_a_square():
    window = IMAGE[86:214, 88:152]  # 14 px above and below the box of 100, 11.5 px beside the box of 41
    expected = cv2.resize(window, (64, 64), interpolation=cv2.INTER_AREA)
    np.testing.assert_array_equal(crop(IMAGE, BOXES[:1])[0], expected)


def test_crop_does_not_depend_on_the_width_of_the_box():
    wide = np.array([[100.0 - 9.5, 100.0, 60.0, 100.0]])
    np.testing.assert_array_equal(crop(IMAGE, wide), crop(IMAGE, BOXES[:1]))


def test_crop_over_the_edge_repeats_the_last_row_and_column():
    image = np.zeros((200, 200, 3), np.uint8)
    image[-1], image[:, 0] = 200, 100
    cut = crop(image, np.array([[-20.5, 150.0, 41.0, 100.0]]))[0]
    assert (cut[:20, :32] == 100).all()
    assert (cut[45:, 40:] == 200).all()


@given(st.floats(-800, 1400), st.floats(-800, 1400), st.floats(1, 900))
def test_any_box_gives_a_crop_with_colours_of_the_image(x, y, height):
    image = np.full((60, 80, 3), 77, np.uint8)
    assert (crop(image, np.array([[x, y, 0.41 * height, height]])) == 77).all()


def test_probabilities_lie_in_zero_to_one_and_repeat_to_the_last_bit(network):
    classifier = Classifier(network)
    first, second = classifier.probabilities(IMAGE, BOXES), classifier.probabilities(IMAGE, BOXES)
    assert first.shape == (3,)
    assert first.dtype == np.float64
    assert ((first > 0.0) & (first < 1.0)).all()
    assert first.tobytes() == second.tobytes()


def test_no_boxes_give_no_probabilities(network):
    assert Classifier(network).probabilities(IMAGE, np.zeros((0, 4))).shape == (0,)


def test_dropout_is_off_when_classifying(network):
    assert Classifier(network.train()).probabilities(IMAGE, BOXES).std() != 0.0
    assert not network.training


def test_least_probability_above_one_is_refused_with_its_value(network):
    with pytest.raises(BadInputError, match=r"1\.5"):
        Classifier(network, least_probability=1.5)


@pytest.mark.parametrize("kind", [lambda: SmallVgg((4, 8), 8), lambda: SqueezeTrunk(8)])
def test_saved_network_comes_back_with_half_precision_weights(kind, tmp_path: Path):
    original = kind()
    save_network(original, tmp_path / "net.safetensors")
    loaded = load_network(tmp_path / "net.safetensors")
    assert type(loaded) is type(original)
    for name, weight in original.state_dict().items():
        assert torch.equal(loaded.state_dict()[name], weight.half().float()), name


def test_missing_classifier_is_refused_with_the_shipped_names():
    with pytest.raises(BadInputError, match=r"'cnn_nowhere' is neither a file nor one of the shipped: cnn_inria"):
        load_classifier("cnn_nowhere")


def test_default_is_the_shipped_classifier():
    probabilities = [load_classifier(name).probabilities(IMAGE, BOXES) for name in ("default", "cnn_inria")]
    assert probabilities[0].tobytes() == probabilities[1].tobytes()


def test_saving_a_network_leaves_nothing_beside_it(network, tmp_path: Path):
    for _ in range(2):
        save_network(network, tmp_path / "net.safetensors")
    assert list(tmp_path.iterdir()) == [tmp_path / "net.safetensors"]


@pytest.mark.parametrize("content", [b"", b"no tensors", b"\x80\x04pickle", (10**9).to_bytes(8, "little") + b"{}"])
def test_file_that_is_no_safetensors_is_refused_by_name(content, tmp_path: Path):
    path = tmp_path / "broken.safetensors"
    path.write_bytes(content)
    with pytest.raises(BadInputError, match=r"broken\.safetensors"):
        load_classifier(path)


@pytest.mark.parametrize(
    "description",
    [
        "",
        "[1",
        "3",
        json.dumps({"architecture": "vgg"}),
        json.dumps({"architecture": "resnet", "arguments": {}}),
        json.dumps({"architecture": "vgg", "arguments": {"widths": [4, 8], "hidden": 9}}),
        json.dumps({"architecture": "vgg", "arguments": {"depth": 3}}),
        json.dumps({"architecture": "vgg", "arguments": 3}),
    ],
)
def test_weights_with_a_wrong_description_are_refused(network, description, tmp_path: Path):
    path = tmp_path / "odd.safetensors"
    save_network(network, path)
    save_file(load_file(path), path, {"network": description})
    with pytest.raises(BadInputError, match=r"odd\.safetensors"):
        load_network(path)


def test_weights_without_a_description_are_refused(network, tmp_path: Path):
    path = tmp_path / "bare.safetensors"
    save_file(network.state_dict(), path)
    with pytest.raises(BadInputError, match=r"bare\.safetensors.*network"):
        load_network(path)


def test_weights_that_are_not_finite_are_refused_by_name(network, tmp_path: Path):
    network.head[0].bias.data[0] = float("nan")
    save_network(network, tmp_path / "nan.safetensors")
    with pytest.raises(BadInputError, match=r"head\.0\.bias.*finite"):
        load_network(tmp_path / "nan.safetensors")


def test_deep_compressed_layer_decodes_codes_and_runs(tmp_path: Path):
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


def test_truncated_compressed_file_is_refused_by_name(tmp_path: Path):
    (tmp_path / "short.net").write_bytes(b"\x05\x00\x00\x00" * 26)
    with pytest.raises(BadInputError, match=r"short\.net"):
        decode_squeezenet(tmp_path / "short.net", [(2, 3, 1, 1)])


def test_shipped_classifier_is_below_3_megabytes_and_has_its_card():
    folder = assets.models_folder()
    assert (folder / "cnn_inria.safetensors").stat().st_size < 3e6
    assert "han-bullet train cnn" in (folder / "cnn_inria.md").read_text(encoding="utf-8")


def test_shipped_classifier_takes_flat_walls_and_noise_for_no_people():
    wall = np.full((480, 640, 3), 150, np.uint8)
    classifier = load_classifier("cnn_inria")
    assert (classifier.probabilities(wall, BOXES) < classifier.least_probability).all()
    assert (classifier.probabilities(IMAGE, BOXES) < classifier.least_probability).all()
