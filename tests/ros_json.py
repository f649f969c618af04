"""Lines of JSON in which bytes are {"base64": ...}; both Pythons of the tests of ROS have this module."""

from __future__ import annotations

import base64
import json
from typing import Any


def write_json(value: object) -> str:
    """A line of JSON."""
    return json.dumps(value, default=lambda raw: {"base64": base64.b64encode(raw).decode()})


def read_json(line: str) -> Any:
    """The inverse of `write_json`."""
    return json.loads(line, object_hook=lambda d: base64.b64decode(d["base64"]) if list(d) == ["base64"] else d)
