"""Ask a ROS master whether it is there, without ROS: its interface is XML-RPC, which the standard library speaks."""

from __future__ import annotations

import http.client
import logging
import os
import time
import xmlrpc.client
from collections.abc import Callable
from typing import Any
from urllib.parse import urlsplit
from xml.parsers.expat import ExpatError

from han_bullet.errors import BadInputError

USUAL_URI = "http://localhost:11311"
ANSWER_WITHIN = 1.0  # [s]
ASKED_EVERY = 0.2  # [s], while it is waited for

_log = logging.getLogger(__name__)


class _Transport(xmlrpc.client.Transport):
    """A transport that does not wait for ever at a port where nobody answers."""

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = ANSWER_WITHIN
        return connection


def master_uri() -> str:
    """Return where the master is said to be: the environment variable ROS_MASTER_URI, or ROS's own default.

    Raises:
        BadInputError: It is no address.
    """
    uri = os.environ.get("ROS_MASTER_URI") or USUAL_URI
    try:
        parts = urlsplit(uri)
        usable = parts.scheme == "http" and bool(parts.hostname) and parts.port is not None
    except ValueError:
        usable = False
    if not usable:
        raise BadInputError(f"ROS_MASTER_URI is {uri!r}; http://HOST:PORT would be right, such as {USUAL_URI}")
    return uri


def is_there(uri: str) -> bool:
    """Tell whether a ROS master answers."""
    return _asked(uri, "getPid", "/han_bullet_probe") is not None


def node_at(uri: str, name: str) -> str | None:
    """Return the address of the node that has a name, if it has one and answers."""
    found = _asked(uri, "lookupNode", "/han_bullet_probe", name)
    if not isinstance(found, str) or _asked(found, "getPid", "/han_bullet_probe") is None:
        return None
    return found


def wait_for_master(uri: str, *, patient: bool, stopped: Callable[[], bool] = lambda: False) -> None:
    """Return once a master answers; at once or, if patient, when it comes or the waiting is stopped.

    Raises:
        BadInputError: There is none, and nobody wants to wait.
    """
    if is_there(uri):
        return
    if not patient:
        raise BadInputError(
            f"no ROS master answers at {uri}; start one (roscore), name another by ROS_MASTER_URI, or give --wait"
        )
    _log.warning("waiting for a ROS master at %s", uri)
    while not (stopped() or is_there(uri)):
        time.sleep(ASKED_EVERY)


def _asked(uri: str, method: str, *arguments: str) -> object:
    """Return what the other side answers with success, or None."""
    try:
        with xmlrpc.client.ServerProxy(uri, transport=_Transport()) as proxy:
            answer = getattr(proxy, method)(*arguments)
    except (OSError, http.client.HTTPException, xmlrpc.client.Error, ExpatError, ValueError):
        return None
    ok = isinstance(answer, list) and len(answer) == 3 and answer[0] == 1
    return answer[2] if ok else None
