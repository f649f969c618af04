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
Either side ends the other by closing the socket.
"""

from __future__ import annotations

import json
import socket
import struct
from typing import Any

SIZES = struct.Struct("<II")  # of the head and of the bytes
LARGEST = 256 * 1024 * 1024  # bytes of one part; more is no frame of ours


class Closed(Exception):
    """The other side has gone."""


def send(sock: socket.socket, head: dict[str, Any], *parts: bytes | memoryview) -> None:
    """Send a head, a dictionary, and bytes in any number of parts; raises Closed."""
    text = json.dumps(head).encode()
    size = sum(memoryview(part).nbytes for part in parts)
    try:
        sock.sendall(SIZES.pack(len(text), size) + text)
        for part in parts:
            sock.sendall(part)
    except OSError as error:
        raise Closed(str(error)) from error


def receive(sock: socket.socket) -> tuple[dict[str, Any], bytes]:
    """Return the next (head, bytes); raises Closed."""
    text, size = SIZES.unpack(_exactly(sock, SIZES.size))
    if text > LARGEST or size > LARGEST:
        raise Closed(f"a frame of {text} and {size} bytes")
    return json.loads(_exactly(sock, text).decode()), bytes(_exactly(sock, size))


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
