"""From a model's name or file to a detector."""

import math

import pytest
import torch
from bars import WHITE, bar_model, found_at, image
from little_samples import small_network

from han_bullet.detection.cnn import save_network
from han_bullet.detection.hog_detector import HogDetector
from han_bullet.detection.loading import load_detector
from han_bullet.errors import BadInputError


def test_unknown_model_is_refused():
    with pytest.raises(BadInputError, match="acf_nowhere"):
        load_detector("acf_nowhere")


def test_model_without_a_score_threshold_is_used_with_one_that_is_given_and_refused_without(tmp_path):
    bar_model().save(tmp_path / "fresh.npz")
    with pytest.raises(BadInputError, match=r"fresh\.npz' has no score threshold; give --threshold or choose one"):
        load_detector(tmp_path / "fresh.npz", classifier=None)
    given = load_detector(tmp_path / "fresh.npz", threshold=20.0, classifier=None)
    assert found_at(given.detect(image((60, WHITE)))) == [72]


@pytest.mark.data
def test_toolbox_model_is_used_by_its_path(data_folder):
    loaded = load_detector(data_folder / "models" / "AcfInriaDetector.mat", classifier=None)
    assert loaded.threshold == 40.0
    assert loaded.proposer.model.score_threshold == 40.0


def test_hog_is_opencvs_detector_with_its_own_threshold_or_one_that_is_given():
    assert isinstance(load_detector("hog"), HogDetector)
    assert (load_detector("hog").threshold, load_detector("hog", threshold=0.5).threshold) == (0.0, 0.5)


@pytest.mark.parametrize("threshold", [math.nan, math.inf, -math.inf])
def test_a_threshold_that_is_no_finite_number_is_refused(threshold):
    with pytest.raises(BadInputError, match="finite score"):
        load_detector(threshold=threshold)


def test_a_classifier_of_ones_own_decides_instead_of_the_shipped_one(tmp_path):
    bar_model().save(tmp_path / "bars.npz")
    network = small_network()
    *_, bias = network.parameters()
    found = {}
    for name, values in {"nobody": (9.0, -9.0), "everybody": (-9.0, 9.0)}.items():
        with torch.no_grad():
            for weights in network.parameters():
                weights.zero_()
            bias.copy_(torch.tensor(values))
        save_network(network, tmp_path / f"{name}.safetensors")
        loaded = load_detector(tmp_path / "bars.npz", 20.0, tmp_path / f"{name}.safetensors")
        found[name] = found_at(loaded.detect(image((60, WHITE))))
    assert found == {"nobody": [], "everybody": [72]}


@pytest.mark.parametrize("name", ["hog", "nowhere.onnx", "nowhere.cfg"])
def test_a_classifier_for_a_detector_of_one_stage_is_refused(name):
    with pytest.raises(BadInputError, match=f"'{name}' finds people in one stage; a classifier, 'cnn_inria'"):
        load_detector(name, classifier="cnn_inria")
