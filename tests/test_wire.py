"""Frames between core and node: what is sent arrives in order and whole, through the socket or through memory."""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import Iterator

import pytest

from ros1_bridge.wire import READ, SLOT_SIZE, SLOTS, UNREAD, WORTH_A_SLOT, Closed, Slots, receive, send

LONG = WORTH_A_SLOT
Pair = tuple[socket.socket, socket.socket]


@pytest.fixture
def sockets() -> Iterator[Pair]:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        yield ours, theirs


def content(number: int, size: int = LONG) -> bytes:
    return bytes([number]) * size


def flags(slots: Slots) -> bytes:
    return os.pread(slots.file, SLOTS, 0)


def test_short_bytes_go_through_the_socket_and_long_ones_through_memory(sockets: Pair) -> None:
    slots = Slots.create()
    for size in (0, LONG - 1):
        send(sockets[0], {"op": "publish"}, content(1, size), slots=slots)
        assert flags(slots) == b""
        assert receive(sockets[1], slots) == ({"op": "publish"}, content(1, size))
    send(sockets[0], {"op": "publish"}, content(1), memoryview(content(2)), slots=slots)
    assert flags(slots) == UNREAD + READ * (SLOTS - 1)
    assert receive(sockets[1], slots) == ({"op": "publish"}, content(1) + content(2))
    assert flags(slots) == READ * SLOTS


def test_more_frames_than_slots_arrive_in_order_and_whole_at_whoever_reads_late(sockets: Pair) -> None:
    slots, numbers = Slots.create(), range(3 * SLOTS)

    def say() -> None:
        for number in numbers:
            send(sockets[0], {"number": number}, content(number), slots=slots)

    sender = threading.Thread(target=say)
    sender.start()
    while flags(slots) != UNREAD * SLOTS:
        assert sender.is_alive()
    for number in numbers:  # the ninth lies in the socket, which makes its sender wait
        assert receive(sockets[1], slots) == ({"number": number}, content(number))
    sender.join()
    assert flags(slots) == READ * SLOTS


def test_what_is_too_long_for_a_slot_goes_through_the_socket(sockets: Pair) -> None:
    slots = Slots.create()
    said = content(7, SLOT_SIZE + 1)
    sender = threading.Thread(target=send, args=(sockets[0], {}, said), kwargs={"slots": slots})
    sender.start()
    assert receive(sockets[1], slots) == ({}, said)
    sender.join()


def test_without_memory_left_it_goes_through_the_socket(sockets: Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "pwrite", full)
    send(sockets[0], {}, content(5), slots=Slots.create())
    assert receive(sockets[1]) == ({}, content(5))


def test_who_has_gone_is_told_of(sockets: Pair) -> None:
    sockets[1].close()
    with pytest.raises(Closed):
        send(sockets[0], {}, content(1, 10))
