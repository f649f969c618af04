import json
import math
import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.device_payload import LONGEST_PAYLOAD, SESSION, read_payload, write_payload
from han_bullet.errors import BadInputError
from han_bullet.messages import DeviceMessage

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.sampled_from(["device", "time", "on", "session", "x"]), inner),
)


def payload(**changes: object) -> bytes:
    document = {"device": "tv", "time": 2.5, "on": True, "session": "ha"} | changes
    return json.dumps({key: value for key, value in document.items() if value is not ...}).encode()


def refusal(data: bytes) -> str:
    with pytest.raises(BadInputError) as refused:
        read_payload(data, ["tv", "radio"])
    return str(refused.value)


@settings(deadline=None)
@given(
    time=st.floats(allow_nan=False, allow_infinity=False),
    on=st.booleans(),
    session=st.from_regex(SESSION, fullmatch=True),
)
def test_what_is_written_is_read_again(time: float, on: bool, session: str) -> None:
    message = DeviceMessage("tv", time, on, session)
    assert read_payload(write_payload(message), ["tv"]) == message


def test_a_payload_written_by_hand_needs_three_keys_and_may_have_others() -> None:
    assert read_payload(b'{"on": true, "time": 3, "device": "tv", "brand": "X"}', ["tv"]) == DeviceMessage(
        "tv", 3.0, True
    )


def test_the_messages_that_the_documentation_shows_are_read() -> None:
    text = (
        (Path(__file__).parent.parent / "docs/devices.md").read_text().replace('\\"', '"').replace("$(date +%s)", "17")
    )
    shown = [read_payload(line.encode(), ["tv"]) for line in re.findall(r'\{"device.*?\}', text)]
    assert [(message.time, message.on) for message in shown] == [(12.35, True), (17.0, True)]


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "no JSON"),
        (b"on", "no JSON"),
        (payload()[:-1], "no JSON"),
        (b"\xff\xfe\x00", "no JSON in UTF-8"),
        (payload().decode().encode("utf-16"), "no JSON in UTF-8"),
        (b"[true]", "list; an object"),
        (b"[" * 1000, "nested too deeply"),
        (b'{"time": ' + b"9" * 900 + b', "on": true, "device": "tv"}', "finite"),
        (b" " * LONGEST_PAYLOAD + b"{}", "1026 bytes; at most 1024"),
        (payload(on=...), "no 'on'"),
        (payload(time=...), "no 'time'"),
        (payload(device=...), "no 'device'"),
        (payload(on="ON"), "'ON'; true or false"),
        (payload(on=1), "1; true or false"),
        (payload(on=None), "None; true or false"),
        (payload(time="2.5"), "'2.5'; a number of seconds"),
        (payload(time=True), "True; a number of seconds"),
        (payload(time=math.nan), "nan; a finite number"),
        (payload(time=-math.inf), "-inf; a finite number"),
        (payload(device="oven"), "'oven'; one of radio, tv"),
        (payload(device=["tv"]), "['tv']; one of radio, tv"),
        (payload(session=7), "7; a string"),
        (payload(session="x" * 65), "a string of at most 64"),
        (payload(session="a,b"), "'a,b'; a string of at most 64 letters"),
        (payload(session="a\n"), "letters, digits"),
    ],
)
def test_a_malformed_payload_is_refused_with_the_reason(data: bytes, reason: str) -> None:
    assert reason in refusal(data)


@settings(deadline=None)
@given(st.binary(max_size=1100) | JSON.map(lambda value: json.dumps(value).encode()))
def test_any_bytes_give_a_whole_message_or_a_reason(data: bytes) -> None:
    try:
        message = read_payload(data, ["tv"])
    except BadInputError as refused:
        assert 0 < len(str(refused)) < 400
    else:
        assert message.device == "tv" and math.isfinite(message.time) and isinstance(message.on, bool)
