"""The second stage: crops, weights on disk, probabilities."""

import json
import resource
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from little_samples import small_network
from safetensors.torch import load_file, save_file

from han_bullet import assets
from han_bullet.detection.cnn import (
    LEAST_PROBABILITY,
    Classifier,
    as_batch,
    crop,
    load_classifier,
    load_network,
    save_network,
)
from han_bullet.detection.network import CropNetwork
from han_bullet.detection.squeezenet import SqueezeTrunk
from han_bullet.detection.vgg import SmallVgg
from han_bullet.errors import BadInputError

IMAGE = np.random.default_rng(0).integers(0, 256, (480, 640, 3), dtype=np.uint8)
BOXES = np.array([[100.0, 100.0, 41.0, 100.0], [300.0, 50.0, 82.0, 200.0], [-10.0, 380.0, 61.5, 150.0]])


@pytest.fixture
def network() -> SmallVgg:
    return small_network()


def refusal(path: Path) -> str:
    """Return the one sentence in which a file is refused."""
    with pytest.raises(BadInputError, match=f"{path.name} is not a pedestrian classifier") as caught:
        load_network(path)
    message = str(caught.value)
    assert "\n" not in message and len(message) < 500
    return message


def test_crop_is_the_64_by_128_window_around_a_person_of_100_px_resized_to_the_input():
    window = IMAGE[86:214, 88:152]  # 14 px above and below the box of 100, 11.5 px beside the box of 41
    for rows, columns in ((64, 64), (112, 56)):
        expected = cv2.resize(window, (columns, rows), interpolation=cv2.INTER_AREA)
        np.testing.assert_array_equal(crop(IMAGE, BOXES[:1], (rows, columns))[0], expected)


def test_crop_with_a_margin_has_the_same_in_its_middle_at_the_same_scale():
    tight = crop(IMAGE, np.array([[200.0, 100.0, 82.0, 200.0]]), (128, 64))[0]
    wide = crop(IMAGE, np.array([[200.0, 100.0, 82.0, 200.0]]), (128, 64), margin=1.25)[0]
    assert wide.shape == (160, 80, 3)
    np.testing.assert_array_equal(wide[16:-16, 8:-8], tight)


def test_crop_does_not_depend_on_the_width_of_the_box():
    wide = np.array([[100.0 - 9.5, 100.0, 60.0, 100.0]])
    np.testing.assert_array_equal(crop(IMAGE, wide, (64, 64)), crop(IMAGE, BOXES[:1], (64, 64)))


def test_crop_over_the_edge_repeats_the_last_row_and_column():
    image = np.zeros((200, 200, 3), np.uint8)
    image[-1], image[:, 0] = 200, 100
    cut = crop(image, np.array([[-20.5, 150.0, 41.0, 100.0]]), (64, 64))[0]
    assert (cut[:20, :32] == 100).all()
    assert (cut[45:, 40:] == 200).all()


@given(st.floats(-800, 1400), st.floats(-800, 1400), st.floats(1, 900))
def test_any_box_gives_a_crop_with_colours_of_the_image(x, y, height):
    image = np.full((60, 80, 3), 77, np.uint8)
    assert (crop(image, np.array([[x, y, 0.41 * height, height]]), (64, 48)) == 77).all()


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


def test_a_classifier_takes_crops_of_its_network_s_size():
    classifier = Classifier(SmallVgg(48, 32, widths=(4, 8), hidden=8))
    assert classifier.size == (48, 32)
    crops = crop(IMAGE, BOXES, (48, 32))
    assert classifier.probabilities(IMAGE, BOXES).tobytes() == classifier.probabilities_of_crops(crops).tobytes()


def test_a_batch_has_the_numbers_of_the_crops_with_colours_first():
    crops = IMAGE[:8, :12].reshape(2, 4, 12, 3)
    batch = as_batch(crops)
    assert batch.shape == (2, 3, 4, 12) and batch.dtype == torch.float32
    np.testing.assert_array_equal(batch.permute(0, 2, 3, 1).numpy(), crops)


@pytest.mark.parametrize(
    "kind", [lambda: SmallVgg(64, 48, (4, 8), 8), lambda: SqueezeTrunk(64, 64, 8)], ids=["small", "squeezenet"]
)
def test_saved_network_comes_back_with_half_precision_weights(kind: Callable[[], CropNetwork], tmp_path: Path):
    original = kind()
    save_network(original, tmp_path / "net.safetensors")
    loaded = load_network(tmp_path / "net.safetensors")
    assert type(loaded) is type(original)
    assert loaded.arguments == original.arguments
    for name, weight in original.state_dict().items():
        assert torch.equal(loaded.state_dict()[name], weight.half().float()), name


def test_loading_leaves_the_random_state_of_torch_alone(network, tmp_path: Path):
    save_network(network, tmp_path / "net.safetensors")
    state = torch.random.get_rng_state()
    load_network(tmp_path / "net.safetensors")
    assert torch.equal(torch.random.get_rng_state(), state)


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


RIGHT = {"height": 32, "width": 32, "widths": [4, 4], "hidden": 8}


def described(network: SmallVgg, path: Path, description: str) -> Path:
    """Write a network's weights with another description."""
    save_network(network, path)
    save_file(load_file(path), path, {"network": description})
    return path


def test_the_right_description_by_hand_is_taken(network, tmp_path: Path):
    description = json.dumps({"architecture": "small", "arguments": RIGHT})
    assert load_network(described(network, tmp_path / "net.safetensors", description)).arguments == RIGHT


@pytest.mark.parametrize(
    "description",
    ["", "[1", "3", "[" * 100_000, json.dumps({"architecture": "small"}), json.dumps({"arguments": RIGHT})],
    ids=["nothing", "half", "number", "deep", "no arguments", "no architecture"],
)
def test_weights_with_a_malformed_description_are_refused(network, description, tmp_path: Path):
    refusal(described(network, tmp_path / "odd.safetensors", description))


@pytest.mark.parametrize("architecture", ["vgg", "resnet", "", None, 3, ["small"], {"small": 1}])
def test_another_architecture_is_refused(network, architecture, tmp_path: Path):
    description = json.dumps({"architecture": architecture, "arguments": RIGHT})
    message = refusal(described(network, tmp_path / "odd.safetensors", description))
    if isinstance(architecture, str):
        assert f"its network is {architecture!r}; vgg-d, squeezenet, small would be right" in message


@pytest.mark.parametrize("arguments", [3, None, "small", [32, 32], {}, {"depth": 3}, RIGHT | {"depth": 3}])
def test_arguments_of_another_form_are_refused(network, arguments, tmp_path: Path):
    description = json.dumps({"architecture": "small", "arguments": arguments})
    refusal(described(network, tmp_path / "odd.safetensors", description))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *((name, value) for name in ("height", "width") for value in (0, -32, 32.0, "32", 10**9, True, None, [32])),
        *(("hidden", value) for value in (0, -8, 9, "8", 10**18, None)),
        *(
            ("widths", value)
            for value in ([], [4], [4, 5], [4, 0], ["4", 4], [4, 10**15], [4] * 100_000, "44", None, 4)
        ),
    ],
)
def test_a_size_that_does_not_fit_the_weights_is_refused(network, name, value, tmp_path: Path):
    description = json.dumps({"architecture": "small", "arguments": RIGHT | {name: value}})
    refusal(described(network, tmp_path / "odd.safetensors", description))


def test_a_huge_network_without_its_weights_takes_no_memory(network, tmp_path: Path):
    description = json.dumps({"architecture": "vgg-d", "arguments": {"height": 1024, "width": 1024}})  # 9 GB
    path = described(network, tmp_path / "odd.safetensors", description)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    refusal(path)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000  # [kB]


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


def test_shipped_classifier_is_below_4_megabytes_and_its_card_is_about_it():
    folder = assets.models_folder()
    network = load_network(folder / "cnn_inria.safetensors")
    size = (folder / "cnn_inria.safetensors").stat().st_size
    assert size < 4e6
    card = (folder / "cnn_inria.md").read_text(encoding="utf-8")
    assert "`han-bullet train cnn" in card
    assert f"{size / 1e6:.1f} MB" in card
    assert f"input {network.height} x {network.width} RGB" in card
    assert f"{sum(weight.numel() for weight in network.parameters()) / 1e6:.2f} million weights" in card
    assert f"from probability {LEAST_PROBABILITY} on" in card


def test_shipped_classifier_takes_flat_walls_and_noise_for_no_people():
    wall = np.full((480, 640, 3), 150, np.uint8)
    classifier = load_classifier("cnn_inria")
    assert (classifier.probabilities(wall, BOXES) < classifier.least_probability).all()
    assert (classifier.probabilities(IMAGE, BOXES) < classifier.least_probability).all()
