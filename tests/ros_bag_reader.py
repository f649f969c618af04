"""Tell as JSON what ROS reads in a bag, under the system's python3."""

from __future__ import annotations

import array
import json
import sys
import zlib
from typing import Any

MANY = 10_000  # signed bytes


def main() -> None:
    with rosbag.Bag(sys.argv[1]) as bag:
        counts: dict[str, int] = {}
        last: dict[str, Any] = {}
        latching, foreign = {}, []
        for topic, message, _, heading in bag.read_messages(return_connection_header=True):
            counts[topic] = counts.get(topic, 0) + 1
            last[topic] = message
            latching[topic] = heading["latching"].decode()
            own = roslib.message.get_message_class(heading["type"].decode())
            if own is not None and own._md5sum != heading["md5sum"].decode():
                foreign.append(topic)
        told = {
            "counts": counts,
            "latching": latching,
            "foreign_md5": foreign,
            "last": {topic: as_dict(message) for topic, message in last.items()},
            "compression": bag.get_compression_info().compression,
            "chunks": len(bag._chunks),
        }
    json.dump(told, sys.stdout)


def as_dict(value: Any) -> Any:
    """A message as dictionaries and lists; times are [s], and of many cells it is their checksum."""
    if isinstance(value, genpy.Message):
        return {slot: as_dict(getattr(value, slot)) for slot in value.__slots__}
    if isinstance(value, genpy.TVal):
        return value.to_sec()
    if isinstance(value, tuple) and len(value) > MANY:
        return zlib.crc32(bytes(array.array("b", value)))
    return [as_dict(one) for one in value] if isinstance(value, (list, tuple)) else value


if __name__ == "__main__":
    import genpy
    import rosbag
    import roslib.message

    main()
