"""Notice that the master has gone or come back, and register again: rospy itself never does."""

import threading

import rosgraph
import rospy
from rospy.impl.registration import RegManager, get_registration_listeners, get_service_manager, get_topic_manager

EVERY = 0.5  # [s]


class MasterWatch(threading.Thread):
    """Ask the master now and then whether it knows this node.

    Args:
        name: Of the node.
        on_change: Called with whether the master is there: when that changes, and when one has been told everything.
        done: Set when the node ends.
    """

    def __init__(self, name, on_change, done):
        super().__init__(name="master-watch", daemon=True)
        self._name = name
        self._on_change = on_change
        self._done = done
        self._there = True
        self._knows_us = None  # number of the master's process that has been told everything

    def doubt(self):
        """Tell the master everything once more, since something did not reach it."""
        self._knows_us = None

    def run(self):
        """Look until the node ends."""
        master = rosgraph.Master(self._name)
        self._knows_us = _process(master)
        while not self._done.wait(EVERY):
            try:
                self._look(master)
            except Exception:  # refused, half an answer, gone again while it was told: it is not there
                if self._there:
                    self._there = False
                    self._on_change(False)

    def _look(self, master):
        process, ours = master.getPid(), rospy.get_node_uri()
        known = _address(master, self._name)
        if known not in (None, ours):
            return rospy.signal_shutdown("another node has taken the name")
        if known is None or process != self._knows_us:
            _register_again(master)
            self._knows_us = process
            self._there = False
        if not self._there:
            self._on_change(True)
            self._there = True


def _process(master):
    try:
        return master.getPid()
    except Exception:
        return None


def _address(master, name):
    """Return where the master says that a node is; None if it does not know it."""
    try:
        return master.lookupNode(name)
    except rosgraph.MasterError:
        return None


def _register_again(master):
    """Tell a new master all that the old one knew of this node."""
    uri = rospy.get_node_uri()
    registration = next(one for one in get_registration_listeners().listeners if isinstance(one, RegManager))
    for topic, kind in get_topic_manager().get_publications():
        master.registerPublisher(topic, kind, uri)
    for topic, kind in get_topic_manager().get_subscriptions():
        registration.publisher_update(topic, master.registerSubscriber(topic, kind, uri))
    for service, service_uri in get_service_manager().get_services():
        master.registerService(service, service_uri, uri)
