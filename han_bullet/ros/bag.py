"""Files of ROS 1 messages, written without ROS: bags for `rosbag play`, and MCAP files for Foxglove."""

from __future__ import annotations

import contextlib
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from han_bullet.atomic_file import appearing_whole
from han_bullet.errors import BadInputError
from han_bullet.ros.message_types import definition, serialize
from han_bullet.ros.topics import Topic

if TYPE_CHECKING:
    from mcap.writer import Writer as McapWriter
    from rosbags.rosbag1 import Writer as BagWriter

CALLER = "/han_bullet"  # the node that would have published
EARLIEST = 1  # [ns]; to ROS, time 0 is none, and `rosbag play` leaves out what was published then


class Bag(ABC):
    """A file that messages are written to; a topic is in it once it has a message.

    Args:
        topics: All that may come.
    """

    def __init__(self, topics: Iterable[Topic]) -> None:
        self.counts: dict[str, int] = {}  # topic -> its messages
        self._topics = {topic.name: topic for topic in topics}
        self._connections: dict[str, Any] = {}

    def write(self, topic: str, time: float, message: Any) -> None:
        """Add a message that was published at a time [s]."""
        if topic not in self._connections:
            self._connections[topic] = self._connect(self._topics[topic])
        self._put(self._connections[topic], round(time * 1e9), serialize(message))
        self.counts[topic] = self.counts.get(topic, 0) + 1

    @abstractmethod
    def _connect(self, topic: Topic) -> Any:
        """Write what is to be known of a topic; return what stands for it."""

    @abstractmethod
    def _put(self, connection: Any, nanoseconds: int, raw: memoryview) -> None:
        """Write a serialized message."""


class Ros1Bag(Bag):
    """A ROS 1 bag, version 2.0; a latched topic is latched again when it is played."""

    def __init__(self, topics: Iterable[Topic], writer: BagWriter) -> None:
        super().__init__(topics)
        self._writer = writer

    def _connect(self, topic: Topic) -> Any:
        known = definition(topic.type)
        return self._writer.add_connection(
            topic.name,
            topic.type.replace("/", "/msg/"),
            msgdef=known.text,
            md5sum=known.md5,
            callerid=CALLER,
            latching=int(topic.latched),
        )

    def _put(self, connection: Any, nanoseconds: int, raw: memoryview) -> None:
        self._writer.write(connection, max(nanoseconds, EARLIEST), raw)


class McapBag(Bag):
    """An MCAP file of the profile "ros1"."""

    def __init__(self, topics: Iterable[Topic], writer: McapWriter) -> None:
        super().__init__(topics)
        self._writer = writer
        self._schemas: dict[str, int] = {}  # type -> number

    def _connect(self, topic: Topic) -> int:
        known = definition(topic.type)
        if topic.type not in self._schemas:
            schema = self._writer.register_schema(known.name, "ros1msg", known.text.encode())
            self._schemas[topic.type] = schema
        metadata = {"callerid": CALLER, "latching": str(int(topic.latched)), "md5sum": known.md5}
        return self._writer.register_channel(topic.name, "ros1", self._schemas[topic.type], metadata)

    def _put(self, connection: int, nanoseconds: int, raw: memoryview) -> None:
        self._writer.add_message(connection, nanoseconds, bytes(raw), nanoseconds)


@contextlib.contextmanager
def open_bag(path: Path, topics: Iterable[Topic], *, mcap: bool = False) -> Iterator[Bag]:
    """Give a bag, or an MCAP file, to write to; it takes its place, or that of another, when it is finished.

    Raises:
        BadInputError: The packages that write it are missing.
    """
    bag_writer, mcap_writer = _writers()
    with appearing_whole(path) as temporary:
        opened = _mcap(temporary, topics, mcap_writer) if mcap else _ros1_bag(temporary, topics, bag_writer)
        with opened as bag:
            yield bag


def _writers() -> tuple[type[BagWriter], type[McapWriter]]:
    try:
        from mcap.writer import Writer as McapWriter
        from rosbags.rosbag1 import Writer as BagWriter
    except ImportError:
        raise BadInputError(
            "bags need the packages rosbags and mcap; `pip install 'han_bullet[ros]'` brings them"
        ) from None
    return BagWriter, McapWriter


@contextlib.contextmanager
def _ros1_bag(path: Path, topics: Iterable[Topic], of: type[BagWriter]) -> Iterator[Bag]:
    path.unlink(missing_ok=True)  # where an earlier one was killed; the library writes to new files only
    writer = of(path)
    writer.set_compression(of.CompressionFormat.LZ4)
    writer.compressor = _compressed
    with writer:
        yield Ros1Bag(topics, writer)


def _compressed(chunk: bytes) -> bytes:
    """Return a chunk as an LZ4 frame that ROS can read, whose roslz4 knows no other kind than this."""
    import lz4.frame

    independent = {"block_size": lz4.frame.BLOCKSIZE_MAX4MB, "block_linked": False}
    frame: bytes = lz4.frame.compress(chunk, 0, **independent, content_checksum=True, store_size=False)
    return frame


@contextlib.contextmanager
def _mcap(path: Path, topics: Iterable[Topic], of: type[McapWriter]) -> Iterator[Bag]:
    with path.open("wb") as file:
        writer = of(file)
        writer.start(profile="ros1", library="han_bullet")
        yield McapBag(topics, writer)
        writer.finish()  # type: ignore[no-untyped-call]
