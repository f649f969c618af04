"""`han-bullet ros-robot`: the simulator alone, as a robot behind ROS 1."""

from __future__ import annotations

import argparse
import logging
import math
from pathlib import Path

from rich.console import Console

from han_bullet.commands.parsing import Commands, Parser, command, natural, output_folder


def add(commands: Commands[Parser]) -> None:
    """Add `ros-robot`."""
    parser = command(
        commands,
        "ros-robot",
        "the simulator alone, as a robot behind ROS 1: its sensors are topics, and it obeys /cmd_vel",
        "  han-bullet ros-robot real2\n"
        "  han-bullet ros-robot real2 --seed 3 --pace 0.5   (half as fast as real time)\n\n"
        "drive it with `han-bullet ros-live`, or whatever publishes /cmd_vel; Ctrl-C ends it, or the world's duration",
    )
    parser.add_argument("world", metavar="WORLD", help="a name from `han-bullet worlds` or a path to a YAML file")
    parser.add_argument("--seed", type=natural, default=0, help="decides starts, speeds, clothes, light and noise")
    parser.add_argument("--pace", type=_pace, default=1.0, metavar="FACTOR", help="of real time (default 1)")
    parser.add_argument("--wait", action="store_true", help="wait for a ROS master that is not there yet")
    parser.add_argument("--out", type=output_folder, metavar="DIR", help="for trace.csv (default runs/ros_robot/NAME)")
    parser.set_defaults(handler=_run)


def _run(options: argparse.Namespace, console: Console) -> int:
    from han_bullet.world_file import find_world

    file = find_world(options.world)
    from han_bullet.checks import check_world
    from han_bullet.commands.ros_live import ends_by_signal
    from han_bullet.recorder import TraceRecorder
    from han_bullet.ros.link import Link
    from han_bullet.ros.sim_robot import SimulatedRobot
    from han_bullet.sim.renderer import InProcessRenderer
    from han_bullet.sim.simulator import Simulator
    from han_bullet.variation import vary
    from han_bullet.world_file import load_world, save_world

    logging.basicConfig(level=logging.INFO, format="%(message)s")
    world = vary(load_world(options.world), options.seed)
    check_world(world, f"{file} (seed {options.seed})")
    folder = options.out or Path("runs") / "ros_robot" / file.stem
    with Link(name="/han_bullet_robot", patient=options.wait) as link:
        folder.mkdir(parents=True, exist_ok=True)
        save_world(world, folder / "world.yaml", f"{world.name} as seed {options.seed} makes it")
        renderer, trace = InProcessRenderer(world, options.seed), TraceRecorder(folder / "trace.csv", world)
        ended = ends_by_signal()
        try:
            with Simulator(world, renderer=renderer, seed=options.seed) as simulator:
                SimulatedRobot(world, simulator, link, trace).run(ended.is_set, options.pace)
        finally:
            trace.close()
            renderer.close()
    console.print(f"where everybody was: {folder / 'trace.csv'}", markup=False, soft_wrap=True)
    return 0


def _pace(text: str) -> float:
    try:
        pace = float(text)
    except ValueError:
        pace = math.nan
    if not 0.0 < pace < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is no pace; a positive number such as 0.5 would be right")
    return pace
