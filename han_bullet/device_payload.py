"""What a networked device says of itself, as bytes on the network: one small JSON object per state."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Collection

from han_bullet.errors import BadInputError, quoted
from han_bullet.messages import DeviceMessage

LONGEST_PAYLOAD = 1024  # [bytes]: a state takes about 100; nobody has to parse megabytes to refuse them
SESSION = re.compile(r"[A-Za-z0-9_.:-]{0,64}")  # it stands in logs and tables


def write_payload(message: DeviceMessage) -> bytes:
    """Return a message as JSON in UTF-8; equal messages give equal bytes."""
    document = {"device": message.device, "time": message.time, "on": message.on, "session": message.session}
    return json.dumps(document, allow_nan=False).encode()


def read_payload(payload: bytes, known: Collection[str]) -> DeviceMessage:
    """Return the message that a payload holds; keys that we do not use are the sender's business.

    Args:
        payload: Anything at all; it comes from outside.
        known: Names of the world's devices.

    Raises:
        BadInputError: It is no state of a known device; says why.
    """
    document = _document(payload)
    device, time, on = (_required(document, key) for key in ("device", "time", "on"))
    session = document.get("session", "")
    if not isinstance(device, str) or device not in known:
        raise _refusal("device", device, f"one of {', '.join(sorted(known)) or 'none in this world'}")
    if not isinstance(on, bool):
        raise _refusal("on", on, "true or false")
    if not isinstance(session, str) or SESSION.fullmatch(session) is None:
        raise _refusal("session", session, "a string of at most 64 letters, digits and any of _.:-")
    return DeviceMessage(device, _seconds(time), on, session)


def _document(payload: bytes) -> dict[str, object]:
    if len(payload) > LONGEST_PAYLOAD:
        raise BadInputError(f"payload has {len(payload)} bytes; at most {LONGEST_PAYLOAD} would be right")
    try:
        document = json.loads(payload.decode())
    except RecursionError:
        raise BadInputError("payload is nested too deeply; one flat JSON object would be right") from None
    except ValueError as error:  # not UTF-8, not JSON, or a number of thousands of digits
        raise BadInputError(f"payload is no JSON in UTF-8: {quoted(error)}") from None
    if not isinstance(document, dict):
        raise BadInputError(f"payload is a JSON {type(document).__name__}; an object would be right")
    return document


def _required(document: dict[str, object], key: str) -> object:
    if key not in document:
        raise BadInputError(f"payload has no {key!r}; device, time and on are needed")
    return document[key]


def _seconds(time: object) -> float:
    """Return a stamp as a finite float [s]."""
    if isinstance(time, bool) or not isinstance(time, int | float):
        raise _refusal("time", time, "a number of seconds")
    try:
        seconds = float(time)
    except OverflowError:  # JSON's whole numbers have no end
        seconds = math.inf
    if not math.isfinite(seconds):
        raise _refusal("time", time, "a finite number of seconds")
    return seconds


def _refusal(key: str, value: object, right: str) -> BadInputError:
    return BadInputError(f"payload's {key} is {repr(value)[:60]}; {right} would be right")
