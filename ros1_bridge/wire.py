"""How the core and the node talk: frames of a JSON head and raw bytes over a socket; standard library, Python 3.8.

Core to node ("op" of the head):
    advertise   topic, kind (of message), md5, text, latch, size (of the queue)
    publish     topic; bytes: the serialized message
    subscribe   topic, kind, md5, text, size
    serve       service, kind
    reply       request, error (null: none); bytes: the serialized response
    param       name, value
    log         level ("info", "warn", "error"), text
Node to core:
    ready       name, master
    listeners   topics: {topic: how many have ever connected}, only of topics with somebody connected now
    message     topic; bytes: the serialized message
    request     request (its number), service; bytes: the serialized request
    master      there: whether the master answers
    failed      what (an operation of the core's), name (of its topic, service, ...), why
    ended       why: another node has taken the name, or somebody ended this one; it must not be started again
Either side ends the other by closing the socket. Long bytes of the core's lie in memory that both have: the head then
has slot: [number, size], and no bytes follow; see Slots.
"""

from __future__ import annotations

import json
import os
import socket
import struct
from typing import Any

SIZES = struct.Struct("<II")  # of the head and of the bytes
LARGEST = 256 * 1024 * 1024  # bytes of one part; more is no frame of ours
SLOTS = 8  # frames whose bytes wait in memory; those of more go through the socket, which then makes their sender wait
SLOT_SIZE = 4 * 1024 * 1024  # bytes: an image of 1280 x 1024 pixels
WORTH_A_SLOT = 128 * 1024  # bytes; about what a socket takes at once
MEMORY = "/dev/shm"
READ, UNREAD = b"\0", b"\1"


class Closed(Exception):
    """The other side has gone."""


class Slots:
    """Memory that two processes have, for long bytes: a socket would carry them in many pieces, each with a wait.

    One side puts, the other takes, in the same order. Slots are used in turn; before them each has a byte that says
    whether it is still to be read.

    Args:
        file: Number of the open file that is the memory, the same on both sides.
    """

    def __init__(self, file: int) -> None:
        self.file = file
        self._next = 0

    @classmethod
    def create(cls) -> Slots:
        """Return new memory, of which only what is used is taken."""
        return cls(os.open(MEMORY, os.O_TMPFILE | os.O_RDWR, 0o600))

    def put(self, size: int, parts: tuple[bytes | memoryview, ...]) -> int | None:
        """Put bytes into the next slot and return its number.

        None: it is still to be read, there is no room for so many, or no memory.
        """
        number = self._next
        place = (number + 1) * SLOT_SIZE
        if size > SLOT_SIZE or os.pread(self.file, 1, number) == UNREAD:
            return None
        try:
            for part in parts:
                place += os.pwrite(self.file, part, place)
            os.pwrite(self.file, UNREAD, number)
        except OSError:
            return None
        self._next = (number + 1) % SLOTS
        return number

    def take(self, number: int, size: int) -> bytes:
        """Return what lies in a slot, which is then free."""
        content = os.pread(self.file, size, (number + 1) * SLOT_SIZE)
        os.pwrite(self.file, READ, number)
        return content

    def __del__(self) -> None:
        """Give the memory back, as far as this side has it, when no thread can be writing there any more."""
        os.close(self.file)


def send(sock: socket.socket, head: dict[str, Any], *parts: bytes | memoryview, slots: Slots | None = None) -> None:
    """Send a head, a dictionary, and bytes in any number of parts, if they are long by a slot; raises Closed."""
    size = sum(memoryview(part).nbytes for part in parts)
    slot = slots.put(size, parts) if slots is not None and size >= WORTH_A_SLOT else None
    if slot is not None:
        head, size, parts = {**head, "slot": [slot, size]}, 0, ()
    text = json.dumps(head).encode()
    try:
        sock.sendall(SIZES.pack(len(text), size) + text)
        for part in parts:
            sock.sendall(part)
    except OSError as error:
        raise Closed(str(error)) from error


def receive(sock: socket.socket, slots: Slots | None = None) -> tuple[dict[str, Any], bytes]:
    """Return the next (head, bytes); raises Closed."""
    text, size = SIZES.unpack(_exactly(sock, SIZES.size))
    if text > LARGEST or size > LARGEST:
        raise Closed(f"a frame of {text} and {size} bytes")
    head, content = json.loads(_exactly(sock, text).decode()), bytes(_exactly(sock, size))
    if "slot" in head and slots is not None:
        content = slots.take(*head.pop("slot"))
    return head, content


def _exactly(sock: socket.socket, count: int) -> bytearray:
    data = bytearray(count)
    view = memoryview(data)
    while view.nbytes:
        try:
            got = sock.recv_into(view)
        except OSError as error:
            raise Closed(str(error)) from error
        if got == 0:
            raise Closed("end of the stream")
        view = view[got:]
    return data
