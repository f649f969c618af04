"""The TV over a real broker, started by each test on a port of its own."""

import json
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from mosquitto import Broker, until
from paho.mqtt.client import Client
from paho.mqtt.enums import CallbackAPIVersion

from han_bullet.cli import main
from han_bullet.device_payload import read_payload, write_payload
from han_bullet.errors import BadInputError
from han_bullet.explain.recorded_run import read_run
from han_bullet.explain.replay import replay
from han_bullet.messages import DeviceMessage
from han_bullet.mqtt_channel import MqttChannel, split_address

ON = write_payload(DeviceMessage("tv", 1.0, True, "living_room"))
TOPIC = "han_bullet/devices/tv/state"
RUN = ("run", "real3", "--perception", "truth", "--no-video")


class HomeAutomation:
    """A client that is none of ours, as mosquitto_pub and mosquitto_sub are."""

    def __init__(self, broker: Broker) -> None:
        self.heard: list[tuple[str, bytes, bool]] = []
        self._client = Client(CallbackAPIVersion.VERSION2)
        self._client.on_message = lambda _c, _u, m: self.heard.append((m.topic, bytes(m.payload), m.retain))
        self._client.connect("127.0.0.1", broker.port)
        self._client.loop_start()

    def publish(self, payload: bytes, *, retain: bool = True) -> None:
        self._client.publish(TOPIC, payload, qos=1, retain=retain).wait_for_publish(30.0)

    def subscribe(self) -> None:
        self._client.subscribe("han_bullet/#", qos=1)

    def close(self) -> None:
        self._client.disconnect()
        self._client.loop_stop()


@pytest.fixture
def home(broker: Broker) -> Iterator[HomeAutomation]:
    client = HomeAutomation(broker)
    yield client
    client.close()


def arrived(channel: MqttChannel, count: int) -> list[bytes]:
    payloads: list[bytes] = []

    def enough() -> bool:
        payloads.extend(channel.receive())
        return len(payloads) >= count

    until(enough)
    return payloads


@pytest.mark.mosquitto
def test_what_is_published_comes_back_from_the_broker_in_order(broker: Broker) -> None:
    with MqttChannel(broker.address) as channel:
        for number in range(20):
            channel.publish("tv", b"%d" % number)
        assert arrived(channel, 20) == [b"%d" % number for number in range(20)]


@pytest.mark.mosquitto
def test_a_state_is_retained_under_the_devices_topic(broker: Broker, home: HomeAutomation) -> None:
    with MqttChannel(broker.address) as channel:
        channel.publish("tv", ON)
        arrived(channel, 1)
    home.subscribe()
    until(lambda: len(home.heard) == 1)
    assert home.heard == [(TOPIC, ON, True)]


@pytest.mark.mosquitto
def test_two_runs_on_one_broker_sign_differently(broker: Broker) -> None:
    with MqttChannel(broker.address) as one, MqttChannel(broker.address) as other:
        assert one.session != other.session


@pytest.mark.mosquitto
def test_a_broker_that_dies_is_told_and_found_again_when_it_is_back(
    broker: Broker, caplog: pytest.LogCaptureFixture
) -> None:
    with MqttChannel(broker.address) as channel:
        broker.stop()
        until(lambda: any("is gone" in line for line in caplog.messages))
        channel.publish("tv", b"lost")
        assert channel.receive() == ()
        broker.start()
        until(lambda: any("is back" in line for line in caplog.messages))
        channel.publish("tv", b"heard")
        assert arrived(channel, 1) == [b"heard"]


@pytest.mark.mosquitto
def test_a_broker_that_refused_for_a_while_is_told_anew_when_it_is_gone(
    broker: Broker, caplog: pytest.LogCaptureFixture
) -> None:
    with MqttChannel(broker.address):
        broker.stop()
        broker.start("allow_anonymous false")
        until(lambda: any("Not authorized" in line for line in caplog.messages))
        broker.stop()
        broker.start()
        until(lambda: any("is back" in line for line in caplog.messages))
        caplog.clear()
        broker.stop()
        until(lambda: any("is gone" in line for line in caplog.messages))


@pytest.mark.mosquitto
def test_a_broker_that_wants_a_password_is_refused_with_its_reason(broker: Broker) -> None:
    broker.stop()
    broker.start("allow_anonymous false")
    with pytest.raises(BadInputError, match="Not authorized"):
        MqttChannel(broker.address)


@pytest.mark.mosquitto
def test_a_run_over_mqtt_hears_its_television_and_says_how(
    broker: Broker, home: HomeAutomation, tmp_path: Path
) -> None:
    stale = DeviceMessage("tv", 99.0, True, "simulator-of_yesterday")
    home.publish(write_payload(stale))
    assert main([*RUN, "--mqtt", broker.address, "--out", str(tmp_path / "run")]) == 0
    result = json.loads((tmp_path / "run/result.json").read_text())
    assert result["devices"] == "mqtt"
    assert result["device_messages"]["ignored"] == 1 and result["device_messages"]["new"] >= 1
    (delay,) = [metric["value"] for metric in result["metrics"] if metric["name"] == "replan_delay.tv"]
    assert delay is not None
    recorded = read_run(tmp_path / "run")
    replayed = replay(recorded, recorded.truths[-1].time)
    assert replayed.differs_since is None and replayed.tick.decision.scene.devices[0].on
    home.subscribe()
    until(lambda: len(home.heard) == 1)
    last = read_payload(home.heard[0][1], ["tv"])
    assert last.on and last.session.startswith("simulator-")


@pytest.mark.mosquitto
def test_a_real_television_that_is_on_sends_the_robot_round_the_couch_though_the_simulated_one_stays_off(
    broker: Broker, home: HomeAutomation, tmp_path: Path
) -> None:
    values = {}
    for state in ("off", "on"):
        home.publish(ON.replace(b"true", b"true" if state == "on" else b"false"))
        out = tmp_path / state
        assert main(["run", "real3_off", *RUN[2:], "--mqtt", broker.address, "--out", str(out)]) == 0
        metrics = json.loads((out / "result.json").read_text())["metrics"]
        values[state] = {metric["name"]: metric["value"] for metric in metrics}
        assert values[state]["outcome"] == "arrived"
    assert values["off"]["transit_time_off.tv"] > 1.0
    assert values["on"]["transit_time_off.tv"] == 0.0


@pytest.mark.mosquitto
def test_a_run_passes_over_what_is_no_message_and_what_comes_too_late(
    broker: Broker, home: HomeAutomation, tmp_path: Path
) -> None:
    from han_bullet.episode import Hook, Tick
    from han_bullet.runner import RunOptions, run_world

    class Noise(Hook):
        def record(self, tick: Tick) -> None:
            if tick.truth.time == pytest.approx(1.0):
                newer, older = (DeviceMessage("tv", time, time < 6.0, "living_room") for time in (6.0, 5.0))
                for payload in (b"\xff", b"{}", write_payload(newer), write_payload(older)):
                    home.publish(payload, retain=False)

    run_world("real3_off", RunOptions(perception="truth", video=False, mqtt=broker.address), tmp_path, [Noise()])
    result = json.loads((tmp_path / "result.json").read_text())
    assert result["outcome"] == "arrived" and all(check["passed"] for check in result["checks"])
    assert (result["device_messages"]["refused"], result["device_messages"]["late"]) == (2, 1)


@pytest.mark.mosquitto
def test_a_run_whose_broker_dies_goes_on(broker: Broker, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    from han_bullet.episode import Hook, Tick
    from han_bullet.runner import RunOptions, run_world

    class Fate(Hook):
        def record(self, tick: Tick) -> None:
            if tick.truth.time == pytest.approx(1.0):
                broker.stop()
                until(lambda: any("is gone" in line for line in caplog.messages))

    options = RunOptions(perception="truth", video=False, mqtt=broker.address)
    result = run_world("real3", options, tmp_path / "run", [Fate()])
    (outcome,) = [metric.value for metric in result.metrics if metric.name == "outcome"]
    assert outcome == "arrived"
    assert any("device tv is silent" in line for line in caplog.messages)


def complaint(capsys: pytest.CaptureFixture[str], address: str, out: Path) -> str:
    assert main([*RUN, "--mqtt", address, "--out", str(out)]) == 2
    assert not out.exists()
    captured = capsys.readouterr()
    assert captured.err.startswith("han-bullet: ") and captured.err.count("\n") == 1
    return captured.err


def test_where_no_broker_is_a_run_ends_before_it_begins(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    with socket.socket() as taken:  # bound, but nobody listens
        taken.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        message = complaint(capsys, address, tmp_path / "run")
    assert f"MQTT broker {address} cannot be used" in message and "refused" in message
    assert f"start one there (mosquitto -p {address.split(':')[1]}), or give the HOST:PORT of one that runs" in message


def test_who_accepts_but_does_not_answer_is_no_broker(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"127.0.0.1:{silent.getsockname()[1]}"
        assert "no answer within 3 s" in complaint(capsys, address, tmp_path / "run")


def test_without_paho_a_run_says_how_to_get_it(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in [name for name in sys.modules if name.split(".")[0] == "paho"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "paho", None)
    assert "pip install 'paho-mqtt" in complaint(capsys, "127.0.0.1", tmp_path / "run")


@pytest.mark.parametrize(
    ("address", "host", "port"),
    [
        ("broker", "broker", 1883),
        ("10.0.0.2:8883", "10.0.0.2", 8883),
        ("[::1]", "::1", 1883),
        ("[fe80::1]:1884", "fe80::1", 1884),
    ],
)
def test_an_address_is_a_host_with_or_without_a_port(address: str, host: str, port: int) -> None:
    assert split_address(address) == (host, port)


@pytest.mark.parametrize("address", ["", ":1883", "broker:", "broker:x", "broker:0", "broker:65536", "::1", "a:1:2"])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(BadInputError, match="HOST or HOST:PORT would be right"):
        split_address(address)
