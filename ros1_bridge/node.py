#!/usr/bin/python3
"""A ROS 1 node on behalf of a program that knows no ROS: it publishes, hears and serves raw messages.

The core starts it as `/usr/bin/python3 -sE node.py --socket FD --name NAME`; rospy and the standard library are all it
needs (Python 3.8 or later). What it does, the core tells it through the socket: see wire.py. It ends with the socket.
"""

import argparse
import contextlib
import logging
import queue
import signal
import socket
import threading

import rosgraph
import roslib.message
import rospy
import wire
from master_watch import MasterWatch

COUNTED_EVERY = 0.1  # [s]: how soon the core knows that somebody listens, or nobody any more
ANSWER_WITHIN = 5.0  # [s] for the core to answer a service's request
LARGEST_IMAGE = 16 * 1024 * 1024  # bytes: with a queue of 1, "the newest" needs room for a whole message


def raw_type(name, md5, text=""):
    """Return a message class whose content is bytes; to ROS it is of the given type."""
    members = {"__slots__": (), "_type": name, "_md5sum": md5, "_full_text": text}
    return type("Raw", (rospy.AnyMsg,), members)


def raw(kind, content):
    """Return a message of a raw type."""
    message = kind()
    message._buff = content
    return message


class Node:
    """Carry out what the core says, and tell it what ROS says.

    Args:
        sock: To the core.
        name: Of the node.
    """

    def __init__(self, sock, name):
        self._sock = sock
        self._name = name
        self._sending = threading.Lock()
        self._publishers = {}  # topic: (publisher, raw type)
        self._joined = {}  # topic: how many have ever connected
        self._answers = {}  # id of a request: queue of its one answer
        self._requests = 0
        self._done = threading.Event()
        self._params = {}

    def run(self):
        """Serve until the core closes the socket."""
        self._tell({"op": "ready", "name": self._name, "master": rosgraph.get_master_uri()})
        rospy.core.add_preshutdown_hook(lambda reason: self._on_shutdown(reason))
        MasterWatch(self._name, self._on_master, self._done).start()
        threading.Thread(target=self._count, name="count", daemon=True).start()
        try:
            while True:
                head, content = wire.receive(self._sock)
                OPERATIONS[head.pop("op")](self, content, **head)
        except wire.Closed:
            self._done.set()
        rospy.signal_shutdown("the core has ended")

    # What the core says.

    def _advertise(self, _, topic, kind, md5, text, latch, size):
        of = raw_type(kind, md5, text)
        publisher = rospy.Publisher(topic, of, self._listener(topic), latch=latch, queue_size=size)
        self._publishers[topic] = publisher, of

    def _publish(self, content, topic):
        publisher, of = self._publishers[topic]
        if not rospy.is_shutdown():
            publisher.publish(raw(of, content))

    def _subscribe(self, _, topic, kind, md5, text, size):
        def take(message):
            self._tell({"op": "message", "topic": topic}, message._buff)

        rospy.Subscriber(topic, raw_type(kind, md5, text), take, queue_size=size, buff_size=LARGEST_IMAGE)

    def _serve(self, _, service, kind):
        known = roslib.message.get_service_class(kind)
        request, response = known._request_class, known._response_class
        raw_response = raw_type(response._type, response._md5sum)
        members = {
            "_type": known._type,
            "_md5sum": known._md5sum,
            "_request_class": raw_type(request._type, request._md5sum),
            "_response_class": raw_response,
        }
        rospy.Service(service, type("Served", (), members), lambda message: self._ask(service, message, raw_response))

    def _reply(self, content, request, error):
        waiting = self._answers.pop(request, None)
        if waiting is not None:
            waiting.put((error, content))

    def _param(self, _, name, value):
        self._params[name] = value
        rospy.set_param(name, value)

    def _log(self, _, level, text):
        {"info": rospy.loginfo, "warn": rospy.logwarn, "error": rospy.logerr}[level]("%s", text)

    # What ROS says.

    def _ask(self, service, message, response):
        """Let the core answer a service's request; called in a thread of rospy's."""
        with self._sending:
            self._requests += 1
            request = self._requests
        answer = self._answers[request] = queue.Queue(1)
        self._tell({"op": "request", "request": request, "service": service}, message._buff)
        try:
            error, content = answer.get(timeout=ANSWER_WITHIN)
        except queue.Empty:
            self._answers.pop(request, None)
            error, content = f"no answer within {ANSWER_WITHIN:g} s", b""
        if error:
            raise rospy.ServiceException(error)
        return raw(response, content)

    def _listener(self, topic):
        """Return what counts who connects to a topic."""
        node = self
        node._joined[topic] = 0

        class Listener(rospy.SubscribeListener):
            def peer_subscribe(self, name, publish, peer_publish):
                node._joined[topic] += 1

        return Listener()

    def _count(self):
        """Tell the core who listens, whenever that has changed."""
        told = {}
        while not self._done.wait(COUNTED_EVERY):
            now = {
                topic: self._joined[topic]
                for topic, (publisher, _) in list(self._publishers.items())
                if publisher.get_num_connections() > 0
            }
            if now != told:
                told = now
                self._tell({"op": "listeners", "topics": now})

    def _on_master(self, there):
        if there:
            for name, value in self._params.items():
                rospy.set_param(name, value)
        self._tell({"op": "master", "there": there})

    def _on_shutdown(self, reason):
        """Another node has taken the name, or somebody has killed this one: the core is told, and not started again."""
        if not self._done.is_set():
            self._tell({"op": "ended", "why": str(reason)})
            self._done.set()

    def _tell(self, head, *parts):
        """Send a frame to the core; it has gone if that fails, which the reading thread notices as well."""
        with self._sending, contextlib.suppress(wire.Closed):
            wire.send(self._sock, head, *parts)


OPERATIONS = {
    "advertise": Node._advertise,
    "publish": Node._publish,
    "subscribe": Node._subscribe,
    "serve": Node._serve,
    "reply": Node._reply,
    "param": Node._param,
    "log": Node._log,
}


def main():
    """Become a node and serve."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--socket", type=int, required=True, metavar="FD", help="number of the open socket to the core")
    parser.add_argument("--name", required=True, help="of the node")
    options = parser.parse_args(rospy.myargv()[1:])
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the keyboard stops the core, which then closes the socket
    logging.raiseExceptions = False
    rospy.init_node(options.name, disable_signals=True, disable_rostime=True)
    with socket.socket(fileno=options.socket) as sock:
        Node(sock, rospy.get_name()).run()


if __name__ == "__main__":
    main()
