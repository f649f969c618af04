"""A costmap as a stream of whole grids and windows, and a subscriber as rviz is one."""

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.costmap.grid import Costmap
from han_bullet.ros.costmap_stream import WHOLE_EVERY, CostmapStream
from han_bullet.ros.message_types import deserialize, serialize, type_of
from han_bullet.ros.occupancy import occupancy
from han_bullet.ros.topics import COSTMAP, COSTMAP_UPDATES, Outgoing


def costmap(cost: np.ndarray, x: float = 0.0) -> Costmap:
    return Costmap(cost.astype(np.uint8), np.zeros_like(cost, np.uint8), np.array([x, 0.0]), 0.1)


class Subscriber:
    """What rviz's Map display does with both topics."""

    def __init__(self) -> None:
        self.cells: np.ndarray | None = None

    def hear(self, outgoing: Outgoing | None) -> None:
        if outgoing is None:
            return
        message: Any = deserialize(type_of(outgoing.message), bytes(serialize(outgoing.message)))
        if outgoing.topic == COSTMAP:
            self.cells = message.data.reshape(message.info.height, message.info.width).copy()
            return
        assert self.cells is not None
        window = slice(message.y, message.y + message.height), slice(message.x, message.x + message.width)
        self.cells[window] = message.data.reshape(message.height, message.width)


shapes = st.sampled_from([(3, 4), (3, 4), (3, 4), (5, 2)])
cells = st.lists(st.tuples(st.integers(0, 11), st.integers(0, 255)), max_size=4)


@given(st.lists(st.tuples(shapes, cells, st.sampled_from([0.2, 0.2, 2.0]), st.booleans()), max_size=12))
def test_who_applies_what_is_sent_always_has_the_whole_grid(steps: list[Any]) -> None:
    stream, subscriber, time = CostmapStream(), Subscriber(), 0.0
    cost = np.zeros((3, 4), np.uint8)
    for shape, changes, passed, forgets in steps:
        time += passed
        cost = cost if cost.shape == shape else np.zeros(shape, np.uint8)
        for place, value in changes:
            cost.flat[place % cost.size] = value
        if forgets:  # somebody new: here it is this very subscriber
            stream.forget()
            subscriber = Subscriber()
        subscriber.hear(stream.next(costmap(cost.copy()), time, windows=True))
        assert subscriber.cells is not None
        np.testing.assert_array_equal(subscriber.cells, occupancy(cost))


def topic(outgoing: Outgoing | None) -> str | None:
    return None if outgoing is None else outgoing.topic


def test_only_the_first_is_whole_and_where_nothing_changes_nothing_is_sent() -> None:
    stream, cost = CostmapStream(), np.zeros((4, 4), np.uint8)
    assert topic(stream.next(costmap(cost), 0.0, windows=True)) == COSTMAP
    assert stream.next(costmap(cost), 0.2, windows=True) is None
    cost[1, 2] = 100
    outgoing = stream.next(costmap(cost), 0.4, windows=True)
    assert outgoing is not None and outgoing.topic == COSTMAP_UPDATES
    assert outgoing.message.data.tolist() == [39]


def test_a_grid_of_another_size_or_place_is_sent_whole() -> None:
    stream, cost = CostmapStream(), np.zeros((4, 4), np.uint8)
    stream.next(costmap(cost), 0.0, windows=True)
    assert topic(stream.next(costmap(cost, x=1.0), 0.2, windows=True)) == COSTMAP
    assert topic(stream.next(costmap(np.zeros((4, 5)), x=1.0), 0.4, windows=True)) == COSTMAP


def test_a_window_that_got_lost_is_made_good_within_five_seconds() -> None:
    stream, cost = CostmapStream(), np.zeros((4, 4), np.uint8)
    stream.next(costmap(cost), 0.0, windows=True)
    assert stream.next(costmap(cost), WHOLE_EVERY - 0.2, windows=True) is None
    assert topic(stream.next(costmap(cost), WHOLE_EVERY, windows=True)) == COSTMAP


def test_who_does_not_listen_to_windows_gets_whole_grids() -> None:
    stream, cost = CostmapStream(), np.zeros((4, 4), np.uint8)
    stream.next(costmap(cost), 0.0, windows=False)
    cost[0, 0] = 7
    assert topic(stream.next(costmap(cost), 0.2, windows=False)) == COSTMAP
