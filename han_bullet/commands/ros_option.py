"""The options of `run` that concern ROS 1, and what they open."""

from __future__ import annotations

import argparse
import contextlib
import signal
from collections.abc import Iterator
from typing import TYPE_CHECKING

from han_bullet.commands.parsing import Parser
from han_bullet.errors import BadInputError

if TYPE_CHECKING:
    from han_bullet.episode import Hook
    from han_bullet.ros.bridge import RosBridge


def add_ros_options(parser: Parser) -> None:
    """Add --ros and what goes with it."""
    add_option = parser.add_argument
    add_option("--ros", action="store_true", help="publish on ROS 1 and take orders from there (docs/ros.md)")
    add_option("--wait", action="store_true", help="with --ros: wait for a ROS master that is not there yet")
    add_option(
        "--stay",
        action="store_true",
        help="with --ros: at most as fast as real time, and after the task wait for orders, until Ctrl-C; no video "
        "unless --video",
    )


def open_bridge(options: argparse.Namespace, closing: contextlib.ExitStack) -> tuple[RosBridge | None, list[Hook]]:
    """Return what gives the robot orders from ROS, and what looks on; nothing of it without --ros.

    Raises:
        BadInputError: There is no ROS, no master, or an option is alone.
    """
    if not options.ros:
        for name in ("wait", "stay"):
            if getattr(options, name):
                raise BadInputError(f"--{name} was given without --ros; --ros --{name} would be right")
        return None, []
    from han_bullet.pace import Pace
    from han_bullet.ros.bridge import RosBridge
    from han_bullet.ros.link import Link

    bridge = RosBridge(closing.enter_context(Link(patient=options.wait)), stays=options.stay)
    if not options.stay:
        return bridge, [bridge]
    closing.enter_context(_ended_by_signals(bridge))
    return bridge, [bridge, Pace()]


@contextlib.contextmanager
def _ended_by_signals(bridge: RosBridge) -> Iterator[None]:
    """Let Ctrl-C, and SIGTERM as roslaunch sends it, end the run after this tick; a second one stops the program."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def stop(number: int, frame: object) -> None:
        bridge.leave()
        for each, handler in before.items():
            signal.signal(each, handler)

    for number in before:
        signal.signal(number, stop)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
