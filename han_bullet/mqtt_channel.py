"""The network of devices as MQTT: an outer thing, and the only place that knows paho-mqtt."""

from __future__ import annotations

import logging
import socket
import threading
import uuid
from collections import deque
from types import TracebackType
from typing import TYPE_CHECKING, Any

from han_bullet.device_channel import MOST_WAITING, SIMULATED, DeviceChannel
from han_bullet.errors import BadInputError, quoted

if TYPE_CHECKING:
    from paho.mqtt.client import Client, MQTTMessage

TOPIC = "han_bullet/devices/{}/state"
DEFAULT_PORT = 1883
ANSWER_WITHIN = 3.0  # [s] for each of: connection, subscription
KEEP_ALIVE = 10  # [s]: a broker that vanished without a word is noticed after this
LONGEST_PAUSE = 4  # [s] between attempts to reconnect

_log = logging.getLogger(__name__)


class MqttChannel(DeviceChannel):
    """Publish to and subscribe at an MQTT broker: retained, QoS 1.

    paho's network thread only puts what arrives into a queue; `receive` empties it. While the broker is away nothing
    arrives and states are lost, which heals as devices repeat them; paho reconnects by itself.

    Args:
        address: Of the broker, HOST or HOST:PORT; [ADDRESS]:PORT for IPv6.

    Raises:
        BadInputError: paho-mqtt is not installed, or no broker answers there.
    """

    name = "mqtt"

    def __init__(self, address: str) -> None:
        self.session = f"{SIMULATED}-{uuid.uuid4().hex[:12]}"
        host, port = split_address(address)
        self._cure = f"start one there (mosquitto -p {port}), or give the HOST:PORT of one that runs"
        self._address = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
        self._waiting: deque[bytes] = deque(maxlen=MOST_WAITING)
        self._answered = threading.Event()
        self._refusal: str | None = None
        self._closing = False
        self._client = self._new_client()
        try:
            self._client.connect(host, port, keepalive=KEEP_ALIVE)
        except (OSError, ValueError) as error:
            raise self._unusable(quoted(error)) from None
        self._client.loop_start()
        answered = self._answered.wait(ANSWER_WITHIN)
        if not answered or self._refusal is not None:
            self.close()
            raise self._unusable(self._refusal or f"no answer within {ANSWER_WITHIN:g} s")

    def publish(self, device: str, payload: bytes) -> None:
        """Send a device's state if the broker is there."""
        if self._client.is_connected():
            self._client.publish(TOPIC.format(device), payload, qos=1, retain=True)

    def receive(self) -> tuple[bytes, ...]:
        """Return what has arrived since the last call."""
        return tuple(self._waiting.popleft() for _ in range(len(self._waiting)))  # what comes meanwhile waits

    def close(self) -> None:
        """Leave the broker; the last states stay there."""
        self._closing = True
        self._client.disconnect()
        self._client.loop_stop()

    def __enter__(self) -> MqttChannel:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _new_client(self) -> Client:
        try:
            from paho.mqtt.client import Client
            from paho.mqtt.enums import CallbackAPIVersion
        except ImportError:
            raise BadInputError("MQTT needs paho-mqtt, version 2: pip install 'paho-mqtt>=2,<3'") from None
        client = Client(CallbackAPIVersion.VERSION2)
        client.connect_timeout = ANSWER_WITHIN
        client.reconnect_delay_set(1, LONGEST_PAUSE)
        client.on_socket_open = _send_at_once
        client.on_connect = self._on_connect
        client.on_subscribe = self._on_subscribe
        client.on_disconnect = self._on_disconnect
        client.on_message = self._on_message
        return client

    def _on_connect(self, client: Client, _user: Any, _flags: Any, reason: Any, _properties: Any) -> None:
        if reason.is_failure:
            self._refuse(str(reason))
        else:
            client.subscribe(TOPIC.format("+"), qos=1)  # anew at each connection: the broker may have forgotten it

    def _on_subscribe(self, _client: Client, _user: Any, _message: int, reasons: Any, _properties: Any) -> None:
        if any(reason.is_failure for reason in reasons):
            self._refuse(f"subscription refused: {reasons[0]}")
            return
        if self._answered.is_set():
            _log.warning("MQTT broker %s is back", self._address)
        self._refusal = None  # one that refused and then took us again is told anew when it is gone
        self._answered.set()

    def _on_disconnect(self, _client: Client, _user: Any, _flags: Any, reason: Any, _properties: Any) -> None:
        if not self._closing and self._answered.is_set() and self._refusal is None:
            _log.warning("MQTT broker %s is gone (%s); devices stay as last heard of", self._address, reason)

    def _on_message(self, _client: Client, _user: Any, message: MQTTMessage) -> None:
        self._waiting.append(bytes(message.payload))

    def _refuse(self, reason: str) -> None:
        if self._answered.is_set():
            _log.warning("MQTT broker %s: %s", self._address, reason)
        self._refusal = reason
        self._answered.set()

    def _unusable(self, reason: str) -> BadInputError:
        return BadInputError(f"MQTT broker {self._address} cannot be used: {reason}; {self._cure}")


def split_address(address: str) -> tuple[str, int]:
    """Return host and port of HOST, HOST:PORT or [ADDRESS]:PORT.

    Raises:
        BadInputError: It is none of these.
    """
    host, colon, port = address.rpartition(":") if not address.endswith("]") else (address, "", "")
    if not colon:
        host, port = address, str(DEFAULT_PORT)
    if host.startswith("[") and host.endswith("]"):
        host = host[1:-1]
    elif ":" in host:
        host = ""
    if not host or not (port.isascii() and port.isdigit() and 0 < int(port) < 65536):
        raise BadInputError(f"address of the MQTT broker is {address!r}; HOST or HOST:PORT would be right")
    return host, int(port)


def _send_at_once(_client: Client, _user: Any, opened: Any) -> None:
    """Do not let the kernel collect small packets: a state is due at the next tick."""
    if isinstance(opened, socket.socket):
        opened.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
