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
        on_change: Called with whether the master is there, when that changes or it has forgotten everything.
        done: Set when the node ends.
    """

    def __init__(self, name, on_change, done):
        super().__init__(name="master-watch", daemon=True)
        self._name = name
        self._on_change = on_change
        self._done = done
        self._there = True

    def run(self):
        """Look until the node ends."""
        master = rosgraph.Master(self._name)
        while not self._done.wait(EVERY):
            try:
                known = master.lookupNode(self._name) == rospy.get_node_uri()
            except rosgraph.MasterError:
                known = False
            except Exception:  # refused, timed out, half an answer: it is not there
                if self._there:
                    self._there = False
                    self._on_change(False)
                continue
            if known and self._there:
                continue
            try:
                if not known:
                    _register_again(master)
            except Exception:  # gone again meanwhile
                continue
            self._there = True
            self._on_change(True)


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
