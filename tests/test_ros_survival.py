"""What the link and the node survive: masters, nodes, subscribers and cores that die, freeze or come back."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
import xmlrpc.client
from collections.abc import Iterator
from typing import Any

import numpy as np
import psutil
import pytest
from mosquitto import until
from ros_master import Client, Master, ros_client

from han_bullet.errors import BadInputError
from han_bullet.ros import link as link_module
from han_bullet.ros.link import Link
from han_bullet.ros.master import node_at
from han_bullet.ros.message_types import deserialize, make
from ros1_bridge.wire import SLOTS, UNREAD

pytestmark = pytest.mark.ros
MIB = 1024 * 1024
IMAGES = 150  # of 0.9 MB each, 132 MB in all


@pytest.fixture
def link(ros_master: Master, monkeypatch: pytest.MonkeyPatch) -> Iterator[Link]:
    """A link with topics both ways, a service and a parameter; a node that dies is started again soon."""
    monkeypatch.setattr(link_module, "SHORT_LIFE", 0.1)
    with Link() as link:
        link.advertise("/count", "std_msgs/Int32", size=10)
        link.advertise("/map", "std_msgs/String", latched=True)
        link.subscribe("/goal", "std_msgs/Int32", size=10)
        link.serve("/clear", "std_srvs/Empty")
        link.set_param("/robot_description", "<robot/>")
        link.publish("/map", make("std_msgs/String", data="of the house"))
        yield link


@contextlib.contextmanager
def counting(link: Link) -> Iterator[None]:
    """A loop that publishes, answers its services, and must never stop."""
    over = threading.Event()
    failures: list[Exception] = []

    def count() -> None:
        number = 0
        while not over.wait(0.005):
            try:
                link.publish("/count", make("std_msgs/Int32", data=number))
            except Exception as error:
                failures.append(error)
            number += 1

    thread = threading.Thread(target=count)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
        assert not failures


def hears(client: Client, at_least: int = 3) -> bool:
    """Whether a client that has subscribed goes on hearing the count."""
    client.collected("/count")
    heard: list[int] = []
    until(lambda: heard.extend(one["data"] for one in client.collected("/count")) or len(heard) >= at_least)
    assert heard == sorted(heard)
    return True


def everything_works(link: Link, master: Master) -> bool:
    """Whether a new client finds topics, service and parameter, and is heard."""
    with ros_client(master) as client:
        client.subscribe("/count", "std_msgs/Int32")
        assert client.wait_for_message("/map", "std_msgs/String") == {"data": "of the house"}
        assert hears(client)
        until(lambda: client.param("/robot_description") == "<robot/>")
        client.publish("/goal", "std_msgs/Int32", {"data": 5})
        requests: list[int] = []
        goals: list[int] = []

        def take() -> bool:
            for incoming in link.received():
                if incoming.name == "/goal":
                    goals.append(deserialize("std_msgs/Int32", incoming.raw).data)
                elif incoming.request is not None:
                    requests.append(incoming.request)
                    link.reply(incoming.request, make("std_msgs/Empty"))
            return bool(goals and requests)

        answers = threading.Thread(target=until, args=(take,))
        answers.start()
        assert client.call("/clear", "std_srvs/Empty") == {}
        answers.join()
    assert goals == [5] and len(requests) == 1
    return True


def memory(process_id: int) -> int:
    """Bytes that a process has in memory."""
    return int(psutil.Process(process_id).memory_info().rss)


def image(number: int) -> Any:
    pixels = np.full(640 * 480 * 3, number % 256, dtype=np.uint8)
    return make("sensor_msgs/Image", height=number, width=640, step=1920, encoding="rgb8", data=pixels)


def is_alive(process_id: int) -> bool:
    with contextlib.suppress(psutil.NoSuchProcess):
        return bool(psutil.Process(process_id).status() != psutil.STATUS_ZOMBIE)
    return False


def nodes_of(process_id: int) -> list[int]:
    """Nodes that a process has started and that live."""
    children = psutil.Process(process_id).children()
    return [one.pid for one in children if is_alive(one.pid) and "node.py" in " ".join(one.cmdline())]


def test_the_master_dies_and_a_new_one_is_told_everything(
    ros_master: Master, link: Link, caplog: pytest.LogCaptureFixture
) -> None:
    with ros_client(ros_master) as old, counting(link):
        old.subscribe("/count", "std_msgs/Int32")
        assert hears(old)
        ros_master.stop()
        until(lambda: "the ROS master is gone" in caplog.messages)
        assert hears(old)
        ros_master.start()
        until(lambda: "the ROS master is there again" in caplog.messages)
        assert hears(old)
        assert everything_works(link, ros_master)
    assert link.restarts == 0 and link.ended is None


def test_what_is_announced_while_the_master_is_gone_comes_with_the_new_one(
    ros_master: Master, link: Link, caplog: pytest.LogCaptureFixture
) -> None:
    with counting(link):
        ros_master.stop()
        until(lambda: "the ROS master is gone" in caplog.messages)
        link.set_param("/late", 7)
        link.advertise("/later", "std_msgs/Int32", latched=True)
        link.publish("/later", make("std_msgs/Int32", data=8))
        ros_master.start()
        until(lambda: "the ROS master is there again" in caplog.messages)
        with ros_client(ros_master) as client:
            assert client.wait_for_message("/later", "std_msgs/Int32") == {"data": 8}
            until(lambda: client.param("/late") == 7)
        assert everything_works(link, ros_master)
    assert link.restarts == 0


def test_the_node_is_killed_and_a_new_one_takes_its_place(ros_master: Master, link: Link) -> None:
    with ros_client(ros_master) as old, counting(link):
        old.subscribe("/count", "std_msgs/Int32")
        old.subscribe("/map", "std_msgs/String")
        until(lambda: old.collected("/map") == [{"data": "of the house"}])
        before, listeners = link.process_id, link.listeners("/count")
        os.kill(before, signal.SIGKILL)
        until(lambda: link.restarts == 1)
        until(lambda: old.collected("/map") == [{"data": "of the house"}])
        assert hears(old) and everything_works(link, ros_master)
        assert link.process_id != before and not psutil.pid_exists(before)
        until(lambda: link.listeners("/count") > listeners)  # a listener of the new node is a new listener
    assert link.ended is None


def test_the_node_is_killed_while_there_is_no_master(ros_master: Master, link: Link) -> None:
    with counting(link):
        ros_master.stop()
        os.kill(link.process_id, signal.SIGKILL)
        until(lambda: not is_alive(link.process_id))
        ros_master.start()
        until(lambda: link.restarts == 1)
        assert everything_works(link, ros_master)


def test_the_newest_message_is_latched_by_the_new_node(ros_master: Master, link: Link) -> None:
    os.kill(link.process_id, signal.SIGKILL)
    link.publish("/map", make("std_msgs/String", data="of the garden"))
    until(lambda: link.restarts == 1)
    with ros_client(ros_master) as client:
        assert client.wait_for_message("/map", "std_msgs/String") == {"data": "of the garden"}


def request(link: Link, client: Client) -> tuple[int, threading.Thread]:
    """The number of a request that waits for its answer, and the thread in which the client waits."""

    def call() -> None:
        with contextlib.suppress(RuntimeError):
            client.call("/clear", "std_srvs/Empty")

    thread = threading.Thread(target=call)
    thread.start()
    numbers: list[int] = []
    until(lambda: numbers.extend(one.request or 0 for one in link.received()) or bool(numbers))
    return numbers[0], thread


def test_a_request_to_a_node_that_died_is_not_taken_for_one_to_the_new_one(ros_master: Master, link: Link) -> None:
    with ros_client(ros_master) as one, ros_client(ros_master) as other:
        early, first = request(link, one)
        os.kill(link.process_id, signal.SIGKILL)
        until(lambda: link.restarts == 1)
        late, second = request(link, other)
        assert early != late
        link.reply(late)
        first.join()
        second.join()


def test_a_subscriber_that_reads_nothing_costs_no_memory_and_blocks_nobody(ros_master: Master, link: Link) -> None:
    link.advertise("/image", "sensor_msgs/Image")
    with ros_client(ros_master) as frozen, ros_client(ros_master) as other, counting(link):
        frozen.subscribe("/image", "sensor_msgs/Image")
        other.subscribe("/count", "std_msgs/Int32")
        until(lambda: link.listeners("/image") == 1)
        link.publish("/image", image(0))
        until(lambda: bool(frozen.collected("/image")))
        frozen.freeze()
        before = memory(link.process_id), memory(os.getpid())
        for number in range(1, IMAGES):
            link.publish("/image", image(number))
            until(lambda: not link._waiting["/image"])  # the node has it, and must drop what it cannot send
        assert hears(other)
        assert memory(link.process_id) < before[0] + 40 * MIB and memory(os.getpid()) < before[1] + 40 * MIB
        frozen.thaw()
        heard: list[int] = []
        until(lambda: heard.extend(one["height"] for one in frozen.collected("/image")) or heard[-1:] == [IMAGES - 1])
        assert heard == sorted(heard) and len(heard) < IMAGES / 2
        assert not frozen.close()
    assert link.restarts == 0


def test_a_node_that_reads_nothing_costs_no_memory_and_blocks_nobody(ros_master: Master, link: Link) -> None:
    link.advertise("/image", "sensor_msgs/Image")
    node = psutil.Process(link.process_id)
    with counting(link):
        node.suspend()
        before = memory(os.getpid())
        for number in range(IMAGES):
            link.publish("/image", image(number))
            link.log("info", "x" * 1000)
        assert memory(os.getpid()) < before + 40 * MIB
        node.resume()
        assert everything_works(link, ros_master)
    assert link.restarts == 0


def test_both_ways_are_full_and_flow_again(ros_master: Master, link: Link) -> None:
    link.advertise("/image", "sensor_msgs/Image")
    link.subscribe("/images", "sensor_msgs/Image")
    blank = {"height": 480, "width": 640, "step": 1920, "data": bytes(640 * 480 * 3)}
    with ros_client(ros_master) as client, counting(link):
        client.publish("/images", "sensor_msgs/Image", blank)
        node = psutil.Process(link.process_id)
        node.suspend()
        for number in range(20):
            client.publish("/images", "sensor_msgs/Image", blank)
            link.publish("/image", image(number))
        node.resume()
        assert everything_works(link, ros_master)
    assert link.restarts == 0


def test_a_node_that_reads_nothing_is_ended_with_the_link(ros_master: Master, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link_module, "ENDS_WITHIN", 0.3)
    with Link() as link:
        link.advertise("/image", "sensor_msgs/Image", size=100)
        psutil.Process(link.process_id).suspend()
        for number in range(2 * SLOTS):
            link.publish("/image", image(number))
        until(lambda: os.pread(link._node.slots.file, SLOTS, 0) == UNREAD * SLOTS)  # the next one blocks the sender
    assert link._sender.is_alive() is False and not is_alive(link.process_id)


def test_a_mute_master_blocks_nobody(ros_master: Master, link: Link) -> None:
    with ros_client(ros_master) as client, counting(link):
        client.subscribe("/count", "std_msgs/Int32")
        assert hears(client)
        ros_master.freeze()
        assert hears(client)
        link.set_param("/late", 7)
        ros_master.thaw()
        until(lambda: client.param("/late") == 7)
        assert hears(client)
        assert everything_works(link, ros_master)


def test_a_link_closes_whose_node_waits_for_a_master(ros_master: Master) -> None:
    with Link() as link:
        ros_master.freeze()
        link.set_param("/late", 7)
    assert not is_alive(link.process_id)
    ros_master.thaw()


def test_a_name_that_is_taken_is_refused(ros_master: Master, link: Link) -> None:
    with pytest.raises(BadInputError, match=r"has a node /han_bullet already; stop it first"):
        Link()
    with counting(link):
        assert everything_works(link, ros_master)


def test_a_node_that_died_without_a_word_does_not_keep_its_name(ros_master: Master) -> None:
    with ros_client(ros_master, "han_bullet") as client:
        client.kill()
        with Link() as link, ros_client(ros_master) as other:
            link.advertise("/count", "std_msgs/Int32")
            other.subscribe("/count", "std_msgs/Int32")
            with counting(link):
                assert hears(other)
        with contextlib.suppress(OSError):
            client.close()


def test_another_node_takes_the_name_and_keeps_it(ros_master: Master, link: Link) -> None:
    process = link.process_id
    with counting(link), ros_client(ros_master, "han_bullet") as other:
        until(lambda: link.ended is not None)
        assert link.ended == "another node has taken the name"
        until(lambda: not is_alive(process))
        assert other.node("/han_bullet") is not None and other.param("/robot_description") == "<robot/>"
        link.log("info", "nobody hears it")
        assert link.listeners("/count") == 0
    assert link.restarts == 0


def test_another_node_takes_the_name_while_ours_is_dead(link: Link, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link_module, "node_at", lambda uri, name: "http://127.0.0.1:1")
    os.kill(link.process_id, signal.SIGKILL)
    until(lambda: link.ended is not None)
    assert link.ended == "another node has taken the name" and link.restarts == 0


def test_a_node_that_somebody_ends_stays_ended(ros_master: Master, link: Link) -> None:
    address = node_at(ros_master.uri, "/han_bullet")
    assert address is not None
    with contextlib.suppress(OSError):  # it ends before it answers
        xmlrpc.client.ServerProxy(address).shutdown("/somebody", "it is in the way")
    until(lambda: link.ended is not None)
    assert "it is in the way" in str(link.ended)
    until(lambda: not is_alive(link.process_id))
    assert link.restarts == 0


CORE = """
import sys, time
from han_bullet.ros.link import Link
link = Link()
link.advertise("/count", "std_msgs/Int32")
print(link.process_id, "rospy" in sys.modules, flush=True)
time.sleep(600)
"""


@contextlib.contextmanager
def core() -> Iterator[tuple[subprocess.Popen[str], int]]:
    """A process with a link, and the number of its node's process."""
    process = subprocess.Popen([sys.executable, "-c", CORE], stdout=subprocess.PIPE, text=True)
    assert process.stdout
    try:
        number, has_rospy = process.stdout.readline().split()
        assert has_rospy == "False"
        yield process, int(number)
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def test_the_node_ends_with_a_core_that_is_killed(ros_master: Master) -> None:
    with core() as (process, node):
        assert is_alive(node)
        process.kill()
        until(lambda: not is_alive(node))
    assert node_at(ros_master.uri, "/han_bullet") is None


def test_the_node_ends_with_a_core_that_is_killed_while_the_master_is_mute(ros_master: Master) -> None:
    with core() as (process, node):
        ros_master.freeze()
        process.kill()
        until(lambda: not is_alive(node))
        ros_master.thaw()


STARTING = """
import threading
from han_bullet.ros import node_process
from han_bullet.ros.link import Link
node_process.wire.receive = lambda socket: threading.Event().wait()  # to this process the node is never ready
try:
    Link(patient=True)
except KeyboardInterrupt:
    print("given up", flush=True)
"""


@contextlib.contextmanager
def starting() -> Iterator[subprocess.Popen[str]]:
    """A process that waits for a master, or for its node."""
    command = [sys.executable, "-c", STARTING]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def test_ctrl_c_while_it_waits_for_a_master_is_obeyed(ros_master: Master) -> None:
    ros_master.stop()
    with starting() as process:
        assert process.stdout
        assert process.stdout.readline() == f"waiting for a ROS master at {ros_master.uri}\n"
        process.send_signal(signal.SIGINT)
        assert process.stdout.readline() == "given up\n"


def test_ctrl_c_while_the_node_starts_leaves_none_behind(ros_master: Master) -> None:
    with starting() as process, ros_client(ros_master) as client:
        assert process.stdout
        until(lambda: client.node("/han_bullet") is not None)
        (node,) = nodes_of(process.pid)
        process.send_signal(signal.SIGINT)
        assert process.stdout.readline() == "given up\n"
        until(lambda: not is_alive(node))


def test_a_link_that_is_closed_while_its_node_is_started_again_leaves_none_behind(
    ros_master: Master, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Link() as link:
        ros_master.stop()
        os.kill(link.process_id, signal.SIGKILL)
        until(lambda: not is_alive(link.process_id))
        ros_master.start()
    assert not nodes_of(os.getpid())
