"""The benchmark of the networks' forward passes, on networks small enough to be quick."""

import pytest

from benchmarks.network_forward import TIMED, forward_times, networks, rows
from han_bullet.detection.vgg import SmallVgg


def test_every_network_is_timed_in_every_round_but_not_while_it_warms_up() -> None:
    times = forward_times([SmallVgg(32, 32, (4,), 8), SmallVgg(48, 32, (4,), 8)], rounds=3)
    assert [len(taken) for taken in times] == [3 * TIMED, 3 * TIMED]
    assert min(map(min, times)) > 0.0


def test_a_line_has_weights_times_in_milliseconds_and_the_paper_s() -> None:
    small = SmallVgg(32, 32, (4, 4), 8)
    lines = rows([("small", small), ("vgg-d", small)], [[0.004, 0.002, 0.003]] * 2)
    assert lines[0][:3] == ("small", "32 x 32", "0.0")
    assert lines[0][3:5] == pytest.approx((3.0, 2.0))
    assert [line[5] for line in lines] == ["-", "-"]
    lines = rows([("vgg-d", SmallVgg(64, 64, (4,), 8)), ("small", SmallVgg(64, 64, (4,), 8))], [[0.1]] * 2)
    assert lines[0][5] == pytest.approx(48.5) and lines[1][5] == "-"


def test_the_paper_s_network_is_compared_at_both_of_its_sizes() -> None:
    compared = [(name, network.height, network.width) for name, network in networks()]
    assert compared == [("squeezenet", 112, 56), ("small", 64, 64), ("vgg-d", 64, 64), ("vgg-d", 224, 224)]
