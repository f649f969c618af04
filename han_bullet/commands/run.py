"""`han-bullet run`: run a world, show its numbers, hold them against its expectations."""

from __future__ import annotations

import argparse
import contextlib
import os
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from han_bullet.commands.fault_option import HELP, fault
from han_bullet.commands.parsing import Commands, Parser, command, names, natural, output_folder, positive
from han_bullet.commands.ros_option import add_ros_options, open_bridge

if TYPE_CHECKING:
    from han_bullet.metrics import Metric
    from han_bullet.runner import RunResult


def add(commands: Commands[Parser]) -> None:
    """Add `run`."""
    parser = command(
        commands,
        "run",
        "run a world: cameras in, robot motion out",
        "  han-bullet run real2\n"
        "  han-bullet run real2 --seed 3 --check\n"
        "  han-bullet run sim1 --perception truth --no-video --out /tmp/sim1\n"
        "  han-bullet run real2 --without overtake,personal_walking\n"
        "  han-bullet run real2 --mirrored --check\n"
        "  han-bullet run my_world.yaml --cameras camera1,onboard --pass right\n"
        "  han-bullet run real3 --mqtt localhost\n"
        "  han-bullet run real2 --fault camera2=frozen@5 --fault camera1=dropped:0.5\n"
        "  han-bullet run real2 --fault all=black@3-6   (all cameras, from 3 s to 6 s)\n"
        "  han-bullet run real2 --ros --stay   (publish on ROS 1; go where rviz says, until Ctrl-C)",
    )
    add_option = parser.add_argument
    add_option("world", metavar="WORLD", help="a name from `han-bullet worlds` or a path to a YAML file")
    add_option("--seed", type=natural, default=0, help="decides starts, speeds, clothes, light and noise (default 0)")
    add_option(
        "--perception", choices=("cameras", "truth"), default="cameras", help="truth: the ablation without cameras"
    )
    add_option(
        "--localization",
        choices=("lidar", "truth"),
        default="lidar",
        help="truth: the ablation in which the simulator tells where the robot is",
    )
    add_option("--cameras", type=names, metavar="NAME,...", help="use only these cameras")
    add_option("--association", choices=("nnjpda", "nn", "gnn"), default="nnjpda", help="of detections to tracks")
    add_option(
        "--detector",
        default="default",
        metavar="NAME|FILE",
        help="a shipped model, hog, or a file (.npz, .mat, .onnx, .cfg)",
    )
    add_option("--classifier", default="default", metavar="NAME|FILE", help="a shipped CNN or a file of one")
    add_option("--threshold", type=float, metavar="T", help="on the score (default: the model's own)")
    add_option(
        "--without",
        type=names,
        default=(),
        metavar="LAYER,...",
        help="leave out these costmap layers; social: all but static, obstacle, inflation and body",
    )
    add_option("--pass", dest="pass_side", choices=("left", "right"), default="left", help="side on which to overtake")
    add_option("--mirrored", action="store_true", help="run the world's mirror image: left for right, --pass included")
    add_option("--workers", type=positive, default=os.cpu_count() or 1, metavar="N", help="camera processes; 1: none")
    add_option("--video", action=argparse.BooleanOptionalAction, help="write video.mp4 (default)")
    add_option("--gui", action="store_true", help="open PyBullet's window")
    add_option(
        "--mqtt", metavar="HOST[:PORT]", help="devices speak through this MQTT broker (default: in this process)"
    )
    add_option("--fault", type=fault, action="append", default=[], dest="faults", metavar="FAULT", help=HELP)
    add_option(
        "--out", type=output_folder, metavar="DIR", help="folder of the results (default runs/NAME of the world file)"
    )
    add_option("--check", action="store_true", help="exit 1 if an expectation of the world is not met")
    add_ros_options(parser)
    parser.set_defaults(handler=_run)


def _run(options: argparse.Namespace, console: Console) -> int:
    from han_bullet.world_file import find_world

    find_world(options.world)  # a wrong name is refused before anything is started
    if options.perception == "cameras" and options.workers > 1:
        from han_bullet.fork_server import worker_context

        worker_context()  # its server imports while this process imports the rest
    from han_bullet.costmap.layers import layers_meant
    from han_bullet.detector_choice import DetectorChoice
    from han_bullet.progress import ProgressBar
    from han_bullet.runner import RunOptions, run_world
    from han_bullet.world_file import load_world

    world = load_world(options.world)
    video = options.video if options.video is not None else not options.stay
    run_options = RunOptions(
        seed=options.seed,
        perception=options.perception,
        localization=options.localization,
        cameras=options.cameras,
        association=options.association,
        detector=DetectorChoice(options.detector, options.threshold, options.classifier),
        without=layers_meant(options.without),
        pass_side=options.pass_side,
        mirrored=options.mirrored,
        workers=options.workers,
        video=video,
        gui=options.gui,
        mqtt=options.mqtt,
        faults=tuple(options.faults),
    )
    folder = options.out or Path("runs") / find_world(options.world).stem
    with contextlib.ExitStack() as closing:
        bridge, onlookers = open_bridge(options, closing)
        bar = ProgressBar(world.name, world.duration, console)
        closing.callback(bar.close)  # also when the run does not begin
        result = run_world(options.world, run_options, folder, hooks=[bar, *onlookers], operator=bridge)
    _print_metrics(result, console)
    _print_faults(result, console)
    if result.gave_up is not None:
        console.print(f"[red]gave up[/]: {result.gave_up}", soft_wrap=True)
    failed = [check for check in result.checks if not check.passed]
    for check in failed:
        told = f"{check.metric} is {check.value}, expected {check.expected}"
        console.print(f"[red]not met[/]: {escape(told)}", soft_wrap=True)
    if result.orders:
        console.print(f"expectations not checked, as the robot was given orders: {len(result.orders)}", soft_wrap=True)
    if result.checks and not failed:
        console.print(f"[green]all {len(result.checks)} expectations met[/]")
    console.print(f"real-time factor {result.real_time_factor:.2f}; results in {folder}/", markup=False, soft_wrap=True)
    if video:
        console.print(f"video: {folder / 'video.mp4'}", markup=False, soft_wrap=True)
    return 1 if options.check and failed else 0


def _print_faults(result: RunResult, console: Console) -> None:
    """Print what the robot noticed of its sensors, if anything."""
    if not result.faults:
        return
    table = Table("sensor", "fault noticed", "from [s]", "until [s]", title_justify="left")
    for noticed in result.faults:
        until = "the end" if noticed.until is None else f"{noticed.until:.2f}"
        table.add_row(noticed.fault.sensor, noticed.fault.kind, f"{noticed.fault.since:.2f}", until)
    console.print(table)


def _print_metrics(result: RunResult, console: Console) -> None:
    """Print what a person wants to see, by subject; result.json has the rest."""
    table = Table(show_header=True, title_justify="left")
    table.add_column("metric")
    table.add_column("value", justify="right")
    table.add_column("unit")
    rows = _shown(result)
    for group in dict.fromkeys(group for group, _ in rows):
        table.add_row(f"[bold]{group}[/]", "", "")
        for metric in (metric for of_group, metric in rows if of_group == group):
            value = f"{metric.value:.3f}" if isinstance(metric.value, float) else str(metric.value)
            unit = "" if metric.unit == "1" else metric.unit
            table.add_row(escape(f"  {metric.name}"), "–" if metric.value is None else escape(value), unit)
        table.add_section()
    console.print(table)


def _shown(result: RunResult) -> list[tuple[str, Metric]]:
    """Return group and metric of the headlines that came to something, and of all that the world expects."""
    from han_bullet.metrics import DEFINITIONS, GROUPS

    expected, names = {check.metric for check in result.checks}, {metric.name for metric in result.metrics}
    rows: list[tuple[str, Metric]] = []
    for metric in result.metrics:
        name, dot, _ = metric.name.partition(".")
        detail = dot and name in names  # one person's part of a figure that stands there for all
        happened = metric.value is not None and metric.value != "none"
        if metric.name in expected or (DEFINITIONS[name].headline and happened and not detail):
            rows.append((GROUPS[name], metric))
    return sorted(rows, key=lambda row: list(dict.fromkeys(GROUPS.values())).index(row[0]))
