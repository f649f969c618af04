import logging

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.device_channel import SIMULATED
from han_bullet.device_payload import write_payload
from han_bullet.known_devices import KnownDevices
from han_bullet.messages import Device, DeviceMessage

TV = Device("tv", np.array([0.0, 3.0]), on=False)
OURS, OTHERS = "simulator-a", "simulator-b"


def says(time: float, on: bool, session: str = OURS, device: str = "tv") -> bytes:
    return write_payload(DeviceMessage(device, time, on, session))


@pytest.fixture
def known(caplog: pytest.LogCaptureFixture) -> KnownDevices:
    caplog.set_level(logging.DEBUG, "han_bullet.known_devices")
    return KnownDevices([TV], session=OURS)


def is_on(known: KnownDevices) -> bool:
    (device,) = known.states
    return device.on


def test_a_new_state_is_a_change_and_its_repetition_is_none(
    known: KnownDevices, caplog: pytest.LogCaptureFixture
) -> None:
    assert known.update([says(1.0, True)], 1.0)
    state = known.states[0]
    for second in (1.0, 2.0, 3.0):
        assert not known.update([says(second, True)], second)
    assert known.states[0] is state
    assert known.counts["new"] == 1 and known.counts["repeated"] == 3
    assert caplog.messages.count("device tv: still on") == 3


def test_on_and_off_again_within_a_tick_is_no_change(known: KnownDevices) -> None:
    assert not known.update([says(1.0, False), says(1.01, True), says(1.02, False)], 1.05)
    assert not is_on(known) and known.counts["new"] == 3


def test_a_late_message_is_ignored_and_told(known: KnownDevices, caplog: pytest.LogCaptureFixture) -> None:
    known.update([says(2.0, True)], 2.0)
    assert not known.update([says(1.5, False)], 2.1)
    assert is_on(known) and known.counts["late"] == 1
    assert "device tv: stamp 1.5 s is late, 2 s came before" in caplog.messages


def test_a_late_message_does_not_break_the_silence(known: KnownDevices, caplog: pytest.LogCaptureFixture) -> None:
    known.update([says(2.0, True)], 2.0)
    known.update([says(1.0, True)], 5.0)
    known.update([], 5.1)
    assert any("silent" in line for line in caplog.messages)


def test_a_lost_message_heals_with_the_next_repetition(known: KnownDevices) -> None:
    known.update([says(0.0, False)], 0.0)
    lost = says(0.6, True)
    assert not known.update([], 0.6) and lost
    assert known.update([says(1.6, True)], 1.6)
    assert is_on(known)


def test_malformed_messages_are_counted_told_in_one_line_a_tick_and_break_nothing(
    known: KnownDevices, caplog: pytest.LogCaptureFixture
) -> None:
    assert known.update([b"\xff", b"{}", says(1.0, True), says(1.0, True, device="oven"), b"[]"], 1.0)
    assert is_on(known) and known.counts["refused"] == 4
    (line,) = [record for record in caplog.records if record.levelno == logging.WARNING]
    assert "refused: 4; the first: payload is no JSON in UTF-8" in line.getMessage()


def test_what_a_broker_kept_of_an_earlier_run_is_ignored_whatever_its_stamp(known: KnownDevices) -> None:
    assert not known.update([says(99.0, True, OTHERS)], 0.0)
    assert known.counts["ignored"] == 1
    assert known.update([says(0.5, True)], 0.5)
    assert not known.update([says(100.0, False, OTHERS)], 0.6)
    assert is_on(known)


def test_a_real_device_takes_over_from_the_simulated_one_with_stamps_of_its_own(
    known: KnownDevices, caplog: pytest.LogCaptureFixture
) -> None:
    known.update([says(5.0, False)], 5.0)
    assert known.update([says(3.0, True, "living_room")], 5.1)
    assert "device tv: 'living_room' speaks for it now, not 'simulator-a'" in caplog.messages
    assert not known.update([says(6.0, False)], 6.0)
    assert is_on(known) and known.counts["ignored"] == 1


def test_a_real_device_that_spoke_before_the_simulated_one_keeps_its_say(known: KnownDevices) -> None:
    assert known.update([says(1.7e9, True, "living_room"), says(0.0, False)], 0.0)
    assert is_on(known)


def test_a_real_device_that_starts_anew_may_begin_with_earlier_stamps(known: KnownDevices) -> None:
    known.update([says(1.7e12, True, "boot_1")], 0.0)
    assert known.update([says(3.0, False, "boot_2")], 1.0)
    assert not known.update([says(2.0, True, "boot_2")], 1.1)
    assert known.counts["late"] == 1


def test_a_silent_device_is_told_once_and_again_only_after_it_was_heard(
    known: KnownDevices, caplog: pytest.LogCaptureFixture
) -> None:
    known.update([says(0.0, True)], 0.0)
    times = [0.05 * tick for tick in range(1, 201)]
    for time in times:
        known.update([], time)
    silent = "device tv is silent for more than 3 s; taken to be on"
    assert caplog.messages.count(silent) == 1 and is_on(known)
    (fault,) = known.faults
    assert (fault.sensor, fault.kind) == ("tv", "silent") and 3.0 < fault.since < 3.1
    known.update([says(10.5, True)], 10.5)
    assert caplog.messages.count("device tv is heard again") == 1 and known.faults == ()
    for time in times:
        known.update([], 10.5 + time)
    assert caplog.messages.count(silent) == 2


def test_a_device_that_is_never_heard_is_told_as_silent(known: KnownDevices, caplog: pytest.LogCaptureFixture) -> None:
    for second in range(10):
        known.update([], float(second))
    assert [record.levelno for record in caplog.records] == [logging.WARNING]


PAYLOADS = st.lists(
    st.binary(max_size=200)
    | st.builds(says, st.floats(allow_nan=False, allow_infinity=False), st.booleans(), st.text("ab", max_size=2))
    | st.builds(says, st.floats(0.0, 9.0), st.booleans(), st.sampled_from([OURS, OTHERS, SIMULATED])),
    max_size=8,
)


@settings(deadline=None)
@given(st.lists(PAYLOADS, max_size=5))
def test_whatever_arrives_nothing_is_raised_and_a_change_is_told_exactly_when_the_state_differs(
    ticks: list[list[bytes]],
) -> None:
    known = KnownDevices([TV], session=OURS)
    for time, payloads in enumerate(ticks):
        before = is_on(known)
        assert known.update(payloads, float(time)) == (is_on(known) != before)
    assert sum(known.counts.values()) == sum(map(len, ticks))
