"""Asking a ROS master whether it is there; no ROS is needed for these."""

from __future__ import annotations

import http.server
import socket
import threading
from collections.abc import Iterator

import pytest
from ros_master import free_port

from han_bullet.errors import BadInputError
from han_bullet.ros.master import is_there, master_uri, node_at, wait_for_master


@pytest.fixture
def mute_port() -> Iterator[int]:
    """A port that takes connections and never answers."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server.getsockname()[1]


@pytest.fixture
def web_port(request: pytest.FixtureRequest) -> Iterator[int]:
    """A port of a web server that is no master: it answers every question with the same text."""

    class Page(http.server.BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            self.send_response(200)
            self.end_headers()
            self.wfile.write(request.param)

        def log_message(self, *_: object) -> None:
            pass

    server = http.server.HTTPServer(("127.0.0.1", 0), Page)
    thread = threading.Thread(target=server.serve_forever, args=(0.01,))
    thread.start()
    yield server.server_port
    server.shutdown()
    thread.join()
    server.server_close()


def refusal(uri: str) -> str:
    with pytest.raises(BadInputError) as caught:
        wait_for_master(uri, patient=False)
    return str(caught.value)


def test_a_port_where_nobody_listens_is_refused_in_one_sentence() -> None:
    uri = f"http://127.0.0.1:{free_port()}"
    assert refusal(uri) == (
        f"no ROS master answers at {uri}; start one (roscore), name another by ROS_MASTER_URI, or give --wait"
    )


def test_a_port_that_never_answers_is_given_up(mute_port: int) -> None:
    assert "no ROS master answers" in refusal(f"http://127.0.0.1:{mute_port}")


def test_a_host_that_nobody_knows_is_refused() -> None:
    assert "no-such-host.invalid" in refusal("http://no-such-host.invalid:11311")


@pytest.mark.parametrize(
    "web_port",
    [
        b"<html>welcome</html>",
        b"not even markup",
        b"<?xml version='1.0'?><methodResponse><params><param><value>7</value></param></params></methodResponse>",
        b"",
    ],
    indirect=True,
)
def test_a_web_server_is_no_master(web_port: int) -> None:
    assert "no ROS master answers" in refusal(f"http://127.0.0.1:{web_port}")


@pytest.mark.parametrize(
    "uri",
    ["localhost:11311", "http://localhost", "http://localhost:99999", "ftp://localhost:11311", "http://[::1:1", "?"],
)
def test_what_is_no_address_is_refused_with_an_example(uri: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", uri)
    with pytest.raises(BadInputError) as caught:
        master_uri()
    assert repr(uri) in str(caught.value) and "such as http://localhost:11311" in str(caught.value)


@pytest.mark.parametrize("uri", [None, ""])
def test_without_the_variable_it_is_where_ros_has_it(uri: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_MASTER_URI", raising=False)
    if uri is not None:
        monkeypatch.setenv("ROS_MASTER_URI", uri)
    assert master_uri() == "http://localhost:11311"


def test_the_patient_say_whom_they_wait_for_and_can_be_stopped(caplog: pytest.LogCaptureFixture) -> None:
    uri, asked = f"http://127.0.0.1:{free_port()}", iter([False, False, True])
    wait_for_master(uri, patient=True, stopped=lambda: next(asked))
    assert caplog.messages == [f"waiting for a ROS master at {uri}"] and list(asked) == []


@pytest.mark.ros
def test_a_master_is_there_and_knows_only_nodes_that_live(ros_master: object) -> None:
    assert is_there(master_uri())
    assert node_at(master_uri(), "/nobody") is None
