#!/usr/bin/python3
"""A ROS 1 node on behalf of a program that knows no ROS: it publishes, hears and serves raw messages.

The core starts it as `/usr/bin/python3 -s node.py --socket FD --slots FD --name NAME`; rospy and the standard library
are all it needs (Python 3.8 or later). What it does, the core tells it through the socket: see wire.py. It ends with
the socket.
"""

import argparse
import contextlib
import http.client
import logging
import os
import queue
import select
import signal
import socket
import threading
import time

import rosgraph
import roslib.message
import rospy
import wire
from master_watch import MasterWatch

COUNTED_EVERY = 0.1  # [s]: how soon the core knows that somebody listens, or nobody any more
ANSWER_WITHIN = 5.0  # [s] for the core to answer a service's request
SENT_WITHIN = 0.5  # [s]: for what waits for a subscriber when the core closes the socket
ENDS_WITHIN = 1.5  # [s]: after that it waits for a master or a subscriber that is mute
OF_ROSOUT = "/rosout_disable_topics_generation"  # a parameter that rospy asks for with the first line of its log
LARGEST_IMAGE = 16 * 1024 * 1024  # bytes: with a queue of 1, "the newest" needs room for a whole message


def _exit_in(seconds):
    """End the process after so many seconds [s] even where threads of rospy's still send to who does not read."""
    timer = threading.Timer(seconds, os._exit, (0,))
    timer.daemon = True
    timer.start()


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
        slots: For long bytes from there.
        name: Of the node.
    """

    def __init__(self, sock, slots, name):
        self._sock = sock
        self._slots = slots
        self._name = name
        self._sending = threading.Lock()
        self._publishers = {}  # topic: (publisher, raw type)
        self._joined = {}  # topic: how many have ever connected
        self._answers = {}  # id of a request: queue of its one answer
        self._requests = time.monotonic_ns()  # a later node has other numbers: no late reply can meet a wrong request
        self._done = threading.Event()
        self._params = {}
        self._watch = MasterWatch(name, self._on_master, self._done)

    def run(self):
        """Serve until the core closes the socket, or somebody ends the node."""
        threading.Thread(target=self._end_with_core, name="hang-up", daemon=True).start()
        rospy.core.add_preshutdown_hook(lambda reason: self._on_shutdown(reason))
        self._tell({"op": "ready", "name": self._name, "master": rosgraph.get_master_uri()})
        self._watch.start()
        threading.Thread(target=self._count, name="count", daemon=True).start()
        with contextlib.suppress(wire.Closed):
            while True:
                head, content = wire.receive(self._sock, self._slots)
                self._carry_out(head.pop("op"), head, content)
        if not self._done.is_set():
            self._done.set()
            self._wait_until_sent()
        _exit_in(ENDS_WITHIN)
        with contextlib.suppress(Exception):  # rospy leaves it with the master, which then keeps the name
            rosgraph.Master(self._name).unsubscribeParam(rospy.get_node_uri(), OF_ROSOUT)
        rospy.core.add_shutdown_hook(lambda reason: os._exit(0))  # all is withdrawn; rospy would wait 0.6 s more
        rospy.signal_shutdown("the core has ended")

    def _carry_out(self, operation, head, content):
        """Do what the core says; what cannot be done must not end the node."""
        try:
            OPERATIONS[operation](self, content, **head)
        except Exception as error:
            name = next(head[key] for key in ("topic", "service", "name", "request", "level") if key in head)
            self._tell({"op": "failed", "what": operation, "name": name, "why": str(error) or repr(error)})

    def _end_with_core(self):
        """End the process some time after the core has gone, whatever the other threads wait for."""
        poll = select.poll()
        poll.register(self._sock, 0)  # the hang-up alone
        poll.poll()
        _exit_in(ENDS_WITHIN + SENT_WITHIN)

    def _wait_until_sent(self):
        """Give the connections' own threads a little time for what their queues hold."""
        deadline = time.monotonic() + SENT_WITHIN
        connections = [one for publisher, _ in self._publishers.values() for one in publisher.impl.connections]
        while any(getattr(one, "_queue", ()) for one in connections) and time.monotonic() < deadline:
            time.sleep(0.01)
        time.sleep(0.05)  # what has left a queue a moment ago

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
        if known is None:
            raise ValueError(f"no package of this machine has the type {kind}")
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
        try:
            rospy.set_param(name, value)
        except (OSError, http.client.HTTPException):  # the master is gone; the watch sets it when it is back
            self._watch.doubt()
        except Exception:
            del self._params[name]
            raise

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
            for name, value in list(self._params.items()):
                rospy.set_param(name, value)
        self._tell({"op": "master", "there": there})

    def _on_shutdown(self, reason):
        """Another node has taken the name, or somebody has ended this one: the core is told not to start it again."""
        if not self._done.is_set():
            self._done.set()
            taken = "registered with same name" in str(reason)
            self._tell({"op": "ended", "why": "another node has taken the name" if taken else str(reason)})
            with contextlib.suppress(OSError):
                self._sock.shutdown(socket.SHUT_RD)  # frees the thread that reads

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
    parser.add_argument("--slots", type=int, required=True, metavar="FD", help="number of the open file of the memory")
    parser.add_argument("--name", required=True, help="of the node")
    options = parser.parse_args(rospy.myargv()[1:])
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the keyboard stops the core, which then closes the socket
    logging.raiseExceptions = False
    rospy.init_node(options.name, disable_signals=True, disable_rostime=True)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # until here the core has kept what was said
    with socket.socket(fileno=options.socket) as sock:
        Node(sock, wire.Slots(options.slots), rospy.get_name()).run()


if __name__ == "__main__":
    main()
