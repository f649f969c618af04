"""What the networks share: their input's size, the fully connected layers' first weights."""

import pytest
import torch
from bars import RedNetwork
from torch import nn

from han_bullet.detection.network import CropNetwork, check_sizes, draw_fully_connected
from han_bullet.errors import BadInputError


@pytest.mark.parametrize("size", [0, -3, 11, 2.0, "2", None, True, 10**30, float("nan")])
def test_a_size_that_is_no_whole_number_in_range_is_refused_by_name_and_value(size: object) -> None:
    with pytest.raises(BadInputError) as caught:
        check_sizes(10, rows=3, columns=size)
    assert str(caught.value) == f"columns is {size!r}; a whole number from 1 to 10 would be right"


def test_sizes_in_range_are_taken() -> None:
    check_sizes(10, rows=1, columns=10)


@pytest.mark.parametrize(("height", "width"), [(0, 64), (64, -64), (1025, 64), (64, 10**12), ("64", 64)])
def test_an_input_of_no_size_or_a_huge_one_is_refused(height: int, width: int) -> None:
    with pytest.raises(BadInputError, match="whole number from 1 to 1024"):
        CropNetwork(height, width, {})


def test_a_network_knows_what_it_was_made_with() -> None:
    network = RedNetwork()
    assert (network.height, network.width, network.arguments) == (64, 64, {"height": 64, "width": 64})


@pytest.mark.parametrize("deviation", [0.01, 0.1])
def test_fully_connected_weights_are_gaussian_with_the_deviation_asked_for_and_biases_zero(deviation: float) -> None:
    head = nn.Sequential(nn.Linear(400, 200), nn.ReLU(), nn.Linear(200, 2))
    with torch.random.fork_rng():
        torch.manual_seed(0)
        draw_fully_connected(head, deviation)
    weights = head[0].weight
    assert weights.std().item() == pytest.approx(deviation, rel=0.02)  # of 80,000 numbers
    assert abs(weights.mean().item()) < 0.02 * deviation
    assert (weights.abs() < deviation).float().mean().item() == pytest.approx(0.683, abs=0.01)
    assert not head[0].bias.any() and not head[2].bias.any()
