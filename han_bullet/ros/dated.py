"""Stamps on another clock: a robot's may have begun long before the loop's, which begins at 0."""

from __future__ import annotations

import dataclasses
from typing import Any

from han_bullet.ros.message_types import seconds, stamp, type_of

TIME = "builtin_interfaces/Time"


def dated(message: Any, epoch: float) -> Any:
    """Return a message whose times, and those of messages within it, are later by an epoch [s]; durations are not."""
    if type_of(message) == TIME:
        return stamp(seconds(message) + epoch)
    changes = {}
    for field in dataclasses.fields(message):
        value = getattr(message, field.name)
        if _is_message(value):
            changes[field.name] = dated(value, epoch)
        elif isinstance(value, list) and value and _is_message(value[0]):
            changes[field.name] = [dated(part, epoch) for part in value]
    return dataclasses.replace(message, **changes)


def _is_message(value: object) -> bool:
    return hasattr(value, "__msgtype__")
