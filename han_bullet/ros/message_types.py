"""ROS 1 messages without ROS: made, serialized and read by the library rosbags, with the md5 sums that ROS has."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from han_bullet.errors import BadInputError, quoted

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

# What the library does not bring: definitions as the packages have them.
MORE_DEFINITIONS = {
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms\n",
    "map_msgs/msg/OccupancyGridUpdate": "Header header\nint32 x\nint32 y\nuint32 width\nuint32 height\nint8[] data\n",
    "people_msgs/msg/Person": (
        "string              name\n"
        "geometry_msgs/Point position\n"
        "geometry_msgs/Point velocity\n"
        "float64             reliability\n"
        "string[]            tagnames\n"
        "string[]            tags\n"
    ),
    "people_msgs/msg/People": "Header header\npeople_msgs/Person[] people\n",
    "nav_msgs/msg/GetPlanRequest": (
        "geometry_msgs/PoseStamped start\ngeometry_msgs/PoseStamped goal\nfloat32 tolerance\n"
    ),
    "nav_msgs/msg/GetPlanResponse": "nav_msgs/Path plan\n",
}
WORTH_A_PIECE = 4096  # bytes; every type with a `data` of bytes has it last
_NOT_WHOLE: dict[str, Any] = {"bool": False, "float32": 0.0, "float64": 0.0, "string": ""}  # of the basic types


@dataclass(frozen=True)
class Definition:
    """What makes a type of message known to those who never heard of it.

    Attributes:
        name: As ROS 1 has it, such as "nav_msgs/Odometry".
        md5: Of the definition, by which two nodes know that they mean the same.
        text: The definition and those of all types within it.
    """

    name: str
    md5: str
    text: str


def make(name: str, /, **fields: Any) -> Any:
    """Return a message of a type, such as "nav_msgs/Odometry"; fields that are not given are zero or empty.

    Arrays of numbers are numpy arrays, shape (n,), of the field's own dtype.

    Raises:
        TypeError: The type has no such field.
    """
    kind, blanks = _kind(name)
    for key, blank in blanks:
        if key not in fields:
            fields[key] = blank()
    return kind(**fields)


def header(time: float, frame: str, sequence: int = 0) -> Any:
    """Return a std_msgs/Header of a time [s] in a frame."""
    return make("std_msgs/Header", seq=sequence, stamp=stamp(time), frame_id=frame)


def stamp(time: float) -> Any:
    """Return a time [s] as ROS has it; times before 0 become 0."""
    nanoseconds = max(round(time * 1e9), 0)
    return make("builtin_interfaces/Time", sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def seconds(ros_time: Any) -> float:
    """Return a stamp as [s]."""
    return float(ros_time.sec) + 1e-9 * float(ros_time.nanosec)


def type_of(message: Any) -> str:
    """Return the name of a message's type, such as "nav_msgs/Odometry"."""
    return str(message.__msgtype__).replace("/msg/", "/")


def serialize(message: Any) -> memoryview:
    """Return a message as the bytes that ROS 1 sends."""
    raw: memoryview = _typestore().serialize_ros1(message, message.__msgtype__)
    return raw


def serialized_parts(message: Any) -> list[memoryview]:
    """Return the same bytes in pieces: a message whose last field is long `data` of bytes is not copied for it."""
    data = getattr(message, "data", None)
    if not isinstance(data, np.ndarray) or data.itemsize > 1 or data.nbytes < WORTH_A_PIECE:
        return [serialize(message)]
    before = bytearray(serialize(dataclasses.replace(message, data=data[:0])))
    before[-4:] = data.nbytes.to_bytes(4, "little")  # the length of a sequence stands before it
    return [memoryview(before), np.ascontiguousarray(data).view(np.uint8).data]


def deserialize(name: str, raw: bytes | memoryview) -> Any:
    """Return the message of a type that some bytes are.

    Raises:
        BadInputError: They are none.
    """
    from rosbags.serde import SerdeError

    try:
        return _typestore().deserialize_ros1(raw, _long(name))
    except (SerdeError, ValueError, AssertionError, IndexError) as error:
        raise BadInputError(f"{len(raw)} bytes are no {name}: {quoted(error)}") from error


@functools.cache
def definition(name: str) -> Definition:
    """Return the definition of a type, such as "nav_msgs/Odometry"."""
    text, md5 = _typestore().generate_msgdef(_long(name), ros_version=1)
    return Definition(name, md5, text)


@functools.cache
def _typestore() -> Typestore:
    try:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError:
        raise BadInputError(
            "ROS messages need the package rosbags; `pip install 'han_bullet[ros]'` brings it"
        ) from None
    store = get_typestore(Stores.ROS1_NOETIC)
    for name, text in MORE_DEFINITIONS.items():
        if name not in store.types:
            store.register(get_types_from_msg(text, name))
    return store


@functools.cache
def _kind(name: str) -> tuple[type, tuple[tuple[str, Callable[[], Any]], ...]]:
    """Return a type's class, and for each of its fields what makes the value where none is given."""
    store, long = _typestore(), _long(name)
    return store.types[long], tuple((field, _blank(description)) for field, description in store.fielddefs[long][1])


def _blank(description: Any) -> Callable[[], Any]:
    from rosbags.interfaces import Nodetype

    kind, detail = description
    if kind is Nodetype.BASE:
        value = _NOT_WHOLE.get(detail[0], 0)
        return lambda: value
    if kind is Nodetype.NAME:
        return functools.partial(make, detail)
    (element, of), count = detail
    if element is Nodetype.BASE and of[0] != "string":
        return functools.partial(np.zeros, count, np.dtype(of[0]))
    return list


def _long(name: str) -> str:
    """Return how the library calls a type."""
    return name.replace("/", "/msg/") if "/msg/" not in name else name
