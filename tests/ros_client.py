"""A rospy client that does what lines of JSON on its stdin say, under the system's python3; see ros_master.py.

Types that this machine's ROS does not have (people_msgs) are made from the definition that their publisher sends.
"""

from __future__ import annotations

import os
import sys
import time
from typing import Any

import genpy
import genpy.dynamic
import rosgraph
import roslib.message
import rospy
from ros_json import read_json, write_json

MOST = 100 * 1024 * 1024  # bytes of a message: so that a queue of one holds the newest


class Client:
    """What can be asked of it: the public methods."""

    def __init__(self) -> None:
        self._publishers: dict[str, Any] = {}
        self._collected: dict[str, list[Any]] = {}

    def wait_for_message(self, topic: str, kind: str, timeout: float) -> Any:
        return as_dict(known(rospy.wait_for_message(topic, class_of(kind), timeout), kind))

    def subscribe(self, topic: str, kind: str) -> None:
        collected = self._collected[topic] = []
        rospy.Subscriber(topic, class_of(kind), collected.append, buff_size=MOST)
        self._kinds = {**getattr(self, "_kinds", {}), topic: kind}

    def collected(self, topic: str) -> list[Any]:
        count = len(self._collected[topic])
        taken, self._collected[topic][:count] = self._collected[topic][:count], []
        return [as_dict(known(message, self._kinds[topic])) for message in taken]

    def advertise(self, topic: str, kind: str) -> None:
        if topic not in self._publishers:
            self._publishers[topic] = rospy.Publisher(topic, class_of(kind), queue_size=100)

    def publish(self, topic: str, kind: str, message: Any, timeout: float) -> None:
        self.advertise(topic, kind)
        deadline = time.monotonic() + timeout
        while self._publishers[topic].get_num_connections() == 0:
            if time.monotonic() > deadline:
                raise TimeoutError(f"nobody listens to {topic}")
            time.sleep(0.01)
        self._publishers[topic].publish(filled(class_of(kind)(), message))

    def call(self, service: str, kind: str, request: Any, timeout: float) -> Any:
        rospy.wait_for_service(service, timeout)
        of = roslib.message.get_service_class(kind)
        return as_dict(rospy.ServiceProxy(service, of)(filled(of._request_class(), request)))

    def set_param(self, name: str, value: object) -> None:
        rospy.set_param(name, value)

    def param(self, name: str) -> Any:
        return rospy.get_param(name, None)

    def topics(self) -> list[Any]:
        return rospy.get_published_topics()

    def node(self, name: str) -> Any:
        try:
            return rosgraph.Master(rospy.get_name()).lookupNode(name)
        except rosgraph.MasterError:
            return None


def class_of(kind: str) -> Any:
    return roslib.message.get_message_class(kind) or rospy.AnyMsg


def known(message: Any, kind: str) -> Any:
    """A message, read by what its publisher says about its type if this machine does not know that."""
    if not isinstance(message, rospy.AnyMsg):
        return message
    header = message._connection_header
    made = genpy.dynamic.generate_dynamic(kind, header["message_definition"])[kind]
    assert (header["type"], header["md5sum"]) == (kind, made._md5sum), header
    return made().deserialize(message._buff)


def as_dict(value: Any) -> Any:
    """A message as dictionaries and lists; times are [s]."""
    if isinstance(value, genpy.Message):
        return {slot: as_dict(getattr(value, slot)) for slot in value.__slots__}
    if isinstance(value, genpy.TVal):
        return value.to_sec()
    return [as_dict(one) for one in value] if isinstance(value, (list, tuple)) else value


def filled(message: Any, values: Any) -> Any:
    """A message with the fields that a dictionary gives."""
    for slot, value in values.items():
        kind = message._slot_types[message.__slots__.index(slot)]
        setattr(message, slot, _field(kind, value))
    return message


def _field(kind: str, value: Any) -> Any:
    if kind in ("time", "duration"):
        return (genpy.Time if kind == "time" else genpy.Duration).from_sec(value)
    if kind.endswith("]") and isinstance(value, list):
        return [_field(kind.split("[")[0], one) for one in value]
    if kind == "Header":
        kind = "std_msgs/Header"
    return filled(roslib.message.get_message_class(kind)(), value) if "/" in kind else value


def main(name: str) -> None:
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what rospy prints is no answer
    rospy.init_node(
        name or "client", anonymous=not name, disable_signals=True, disable_rosout=True,
        disable_rostime=True,
    )  # fmt: skip
    client = Client()
    print(write_json({"value": None}), file=answers, flush=True)
    for line in sys.stdin:
        arguments = read_json(line)
        try:
            answer = {"value": getattr(client, arguments.pop("do"))(**arguments)}
        except Exception as error:
            answer = {"error": f"{type(error).__name__}: {error}"}
        print(write_json(answer), file=answers, flush=True)
    rospy.core.add_shutdown_hook(lambda reason: os._exit(0))  # all is withdrawn; rospy would wait 0.6 s more
    rospy.signal_shutdown("the test is over")
