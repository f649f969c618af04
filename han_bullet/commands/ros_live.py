"""`han-bullet ros-live`: the stack on a real robot, through ROS 1."""

from __future__ import annotations

import argparse
import contextlib
import logging
import os
import signal
import threading
from pathlib import Path

from rich.console import Console

from han_bullet.commands.parsing import Commands, Parser, command, positive


def add(commands: Commands[Parser]) -> None:
    """Add `ros-live`."""
    parser = command(
        commands,
        "ros-live",
        "run the stack on a real robot and real cameras, through ROS 1; Ctrl-C stops the robot and ends",
        "  han-bullet ros-live my_robot.yaml\n"
        "  han-bullet ros-live my_robot.yaml --workers 4 --wait\n\n"
        "the configuration, a YAML file, names world, cameras, calibrations and topics: docs/ros_live.md",
    )
    parser.add_argument("config", type=Path, metavar="CONFIG", help="YAML file; ros1_bridge/config has an example")
    parser.add_argument(
        "--workers", type=positive, default=os.cpu_count() or 1, metavar="N", help="processes that look for people"
    )
    parser.add_argument("--wait", action="store_true", help="wait for a ROS master that is not there yet")
    parser.set_defaults(handler=_run)


def _run(options: argparse.Namespace, console: Console) -> int:
    from han_bullet.device_channel import DeviceChannel, EmbeddedChannel
    from han_bullet.rehearsal import rehearse
    from han_bullet.ros.link import Link
    from han_bullet.ros.live import LiveLoop
    from han_bullet.ros.live_setup import load_live_setup
    from han_bullet.ros.live_stack import build_eyes, build_live_stack
    from han_bullet.ros.live_topics import LiveTopics

    setup = load_live_setup(options.config)
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    with contextlib.ExitStack() as closing:
        link = closing.enter_context(Link(patient=options.wait))
        devices: DeviceChannel = EmbeddedChannel()
        if setup.mqtt is not None:
            from han_bullet.mqtt_channel import MqttChannel

            devices = closing.enter_context(MqttChannel(setup.mqtt))
        eyes = closing.enter_context(build_eyes(setup, options.workers))
        ended = ends_by_signal()
        rehearse(build_live_stack(setup, eyes, EmbeddedChannel()), setup.world)  # while the eyes load what they need
        eyes.wait_until_ready()
        stack = build_live_stack(setup, eyes, devices)
        LiveLoop(setup, stack, eyes, link, LiveTopics(setup.world, stack, link), devices).run(ended.is_set)
    return 0


def ends_by_signal() -> threading.Event:
    """Return what Ctrl-C and SIGTERM set from now on, instead of interrupting whatever goes on."""
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    return ended
