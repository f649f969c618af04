import json
from pathlib import Path

from han_bullet.device_channel import MOST_WAITING, EmbeddedChannel
from han_bullet.runner import RunOptions, run_world


def test_what_is_published_inside_the_process_arrives_once_in_order_and_at_once() -> None:
    channel = EmbeddedChannel()
    assert channel.receive() == ()
    channel.publish("tv", b"1")
    channel.publish("radio", b"2")
    assert channel.receive() == (b"1", b"2")
    assert channel.receive() == ()


def test_of_a_flood_the_newest_payloads_are_kept() -> None:
    channel = EmbeddedChannel()
    for number in range(MOST_WAITING + 5):
        channel.publish("tv", b"%d" % number)
    payloads = channel.receive()
    assert len(payloads) == MOST_WAITING and payloads[-1] == b"%d" % (MOST_WAITING + 4)


def test_inside_the_process_the_robot_plans_anew_in_the_tick_in_which_the_television_goes_on(tmp_path: Path) -> None:
    files = []
    for name in ("one", "again"):
        result = run_world("real3", RunOptions(perception="truth", video=False), tmp_path / name)
        assert {metric.name: metric.value for metric in result.metrics}["replan_delay.tv"] == 0.0
        files.append((tmp_path / name / "trace.csv").read_bytes())
    assert files[0] == files[1]
    written = json.loads((tmp_path / "one/result.json").read_text())
    assert written["devices"] == "embedded"
    counts = written["device_messages"]
    assert counts["new"] == 2 and counts["repeated"] > 10
    assert counts["late"] == counts["ignored"] == counts["refused"] == 0
