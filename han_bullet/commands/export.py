"""`han-bullet export`: a finished run as a bag for ROS 1 or as MCAP for Foxglove, made without ROS."""

from __future__ import annotations

import argparse
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from han_bullet.commands.parsing import Commands, Parser, command, output_folder
from han_bullet.errors import BadInputError

BAG, MCAP = ".bag", ".mcap"


def add(commands: Commands[Parser]) -> None:
    """Add `export`."""
    parser = command(
        commands,
        "export",
        "write a finished run as a ROS 1 bag or as MCAP for Foxglove; needs no ROS",
        "  han-bullet export runs/real2 real2.bag\n"
        "  han-bullet export runs/real2 real2.mcap\n"
        "  han-bullet export runs/real2 real2.bag --images\n"
        "  rosbag play real2.bag   (where there is ROS: a master, and `rosparam set use_sim_time true`)",
    )
    parser.add_argument("run", type=Path, metavar="RUN", help="folder that `han-bullet run` left")
    parser.add_argument("file", type=_file, metavar="FILE.bag|FILE.mcap", help="an older file is replaced")
    parser.add_argument("--mcap", action="store_true", help="write MCAP whatever the file's name ends in")
    parser.add_argument(
        "--images", action="store_true", help="with the cameras' pictures, which the simulator takes again"
    )
    parser.set_defaults(handler=_export)


def _file(text: str) -> Path:
    """Read the path of a file to write."""
    if Path(text).is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} is a folder; a file ending in {BAG} or {MCAP} would be right")
    return output_folder(str(Path(text).parent)) / Path(text).name


def _is_mcap(path: Path, wanted: bool) -> bool:
    """Tell whether MCAP is wanted.

    Raises:
        BadInputError: Neither the file's ending nor the option tells, or they contradict.
    """
    ending = path.suffix.lower()
    if wanted and ending == BAG:
        raise BadInputError(f"file {str(path)!r} ends in {BAG}, and --mcap is given; one of the two would be right")
    if not wanted and ending not in (BAG, MCAP):
        raise BadInputError(f"file {str(path)!r} ends in neither {BAG} nor {MCAP}; one of them, or --mcap, is needed")
    return wanted or ending == MCAP


def _export(options: argparse.Namespace, console: Console) -> int:
    mcap = _is_mcap(options.file, options.mcap)
    from han_bullet.explain.recorded_run import read_run
    from han_bullet.ros.export import export

    run = read_run(options.run)
    bar = Progress(
        TextColumn("[bold]{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.1f} of {task.total:.1f} s"),
        TimeElapsedColumn(),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )
    with bar:
        task = bar.add_task(escape(run.world.name), total=run.truths[-1].time)
        exported = export(
            run,
            options.file,
            mcap=mcap,
            images=options.images,
            progress=lambda time: bar.update(task, completed=time),
        )
    messages, topics = sum(exported.counts.values()), len(exported.counts)
    size = exported.size / 1e6
    console.print(
        f"{options.file}: {exported.duration:.2f} s, {messages} messages of {topics} topics, {size:.1f} MB",
        markup=False,
        soft_wrap=True,
    )
    if run.sees and not options.images:
        console.print("without the cameras' images; --images takes them again", soft_wrap=True)
    return 0
