"""`han-bullet sweep`: many runs over processes or machines, a row for each, and a table of what was met."""

from __future__ import annotations

import argparse
import importlib.util
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from han_bullet.commands.parsing import Commands, Parser, command, names, output_folder, positive
from han_bullet.errors import BadInputError

LIBRARIES = ("distributed", "pyarrow")  # of the extra [sweep]
NOT_RUN = 3
WORDS = """words of a variant, joined by +:
  cameras | truth             perception; cameras unless said otherwise
  camera:NAME                 only this camera; several: camera:a+camera:b
  nnjpda | nn | gnn           association of detections to tracks
  threshold:SCORE             least score of the detector; threshold:none for none
  without:LAYER               leave out a costmap layer; several: without:a+without:b;
                              without:social: all but static, obstacle, inflation and body
  pass:SIDE                   overtake left or right
  told-pose                   the simulator tells where the robot is, instead of localization by laser
  mirrored                    the world's mirror image, passing on the other side
  scale:NAME*FACTOR           a value that the paper leaves open, times a factor"""


def add(commands: Commands[Parser]) -> None:
    """Add `sweep`."""
    parser = command(
        commands,
        "sweep",
        "run worlds x variants x seeds, over processes or machines; started again, it goes on where it stopped",
        "  han-bullet sweep\n"
        "  han-bullet sweep real1,real2 --seeds 0-19 --variants cameras,truth\n"
        "  han-bullet sweep real2 --seeds 0-4,7 --variants cameras,cameras+nn,truth+without:overtake --out runs/why\n"
        "  han-bullet sweep my_world.yaml --variants camera:camera1,threshold:40+pass:right --processes 2\n"
        "  han-bullet sweep --seeds 0-9 --variants truth --sensitivity --out runs/sensitivity\n"
        "  han-bullet sweep --seeds 0-99 --scheduler tcp://10.0.0.1:8786 --out runs/night\n\n" + WORDS,
    )
    add_option = parser.add_argument
    add_option(
        "worlds",
        type=names,
        nargs="?",
        metavar="WORLD,...",
        help="names from `han-bullet worlds` or paths of YAML files (default: all shipped worlds)",
    )
    add_option("--seeds", type=seeds, default=seeds("0-9"), metavar="N-M,...", help="for example 0-19, 3 or 0-4,7")
    add_option("--variants", type=names, default=("cameras",), metavar="V,...", help="see below (default cameras)")
    add_option("--out", type=output_folder, default=Path("runs/sweep"), metavar="DIR", help="default runs/sweep")
    add_option(
        "--sensitivity",
        action="store_true",
        help="each variant also with each value that the paper leaves open x 0.5, x 2",
    )
    place = parser.add_mutually_exclusive_group()
    place.add_argument("--processes", type=positive, metavar="N", help="of this machine (default: one per core)")
    place.add_argument("--scheduler", metavar="ADDRESS", help="use a dask cluster instead, e.g. tcp://10.0.0.1:8786")
    add_option("--fresh", action="store_true", help="do again what --out holds already")
    parser.set_defaults(handler=_sweep)


def seeds(text: str) -> tuple[int, ...]:
    """Read numbers and ranges separated by commas; the end of a range belongs to it."""
    found: list[int] = []
    for part in names(text):
        first, dash, last = part.partition("-")
        if not first.isdigit() or (dash and not last.isdigit()) or (dash and int(last) < int(first)):
            raise argparse.ArgumentTypeError(f"{part!r} is neither a seed nor a range of seeds, like 3 or 0-19")
        found += range(int(first), int(last if dash else first) + 1)
    if not found:
        raise argparse.ArgumentTypeError(f"{text!r} holds no seed; 0-19 or 0-4,7 would be right")
    return tuple(found)


def _sweep(options: argparse.Namespace, console: Console) -> int:
    missing = [library for library in LIBRARIES if importlib.util.find_spec(library) is None]
    if missing:
        raise BadInputError(f"han-bullet sweep needs {' and '.join(missing)}: pip install 'han_bullet[sweep]'")
    from han_bullet.fork_server import worker_context
    from han_bullet.world_file import find_world, world_names

    worlds = options.worlds or world_names()
    for world in worlds:
        find_world(world)  # a wrong name is refused before anything is started
    if options.scheduler is None:
        worker_context()  # its server imports while this process imports the rest
    from han_bullet.sweep.plan import plan_sweep
    from han_bullet.sweep.variants import scaled_variants

    further = [one for variant in options.variants for one in scaled_variants(variant)] if options.sensitivity else []
    plan = plan_sweep(worlds, options.seeds, [*options.variants, *further])
    from han_bullet.sweep.bar import SweepBar
    from han_bullet.sweep.running import run_sweep

    bar = SweepBar(console)
    try:
        rows = run_sweep(
            plan,
            options.out,
            processes=options.processes,
            scheduler=options.scheduler,
            fresh=options.fresh,
            onlooker=bar,
        )
    finally:
        bar.close()
    console.print(_table(rows))
    errors = [row for row in rows if row["error"] is not None]
    for row in errors:
        console.print(f"[red]not run[/]: {escape(row['folder'])}: {escape(row['error'])}", soft_wrap=True)
    done = f"{len(rows) - len(errors)} of {len(plan)} runs are done; results in {options.out}/"
    console.print(done, markup=False, soft_wrap=True)
    return NOT_RUN if errors else 0


def _table(rows: Sequence[dict[str, Any]]) -> Table:
    """Return how often each world with each variant met its expectations, and where it did not."""
    table = Table()
    for heading in ("world", "variant", "met", "not met"):
        table.add_column(heading, justify="right" if heading == "met" else "left", overflow="fold")
    groups: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault((row["world"], row["variant"]), []).append(row)
    for (world, variant), group in groups.items():
        met = sum(row["passed"] for row in group)
        table.add_row(escape(world), variant, f"{met} of {len(group)}", escape("\n".join(_unmet(group))))
    return table


def _unmet(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Return a line per metric that was not met: how often, and the first seed where, with its value."""
    where: dict[str, list[str]] = {}
    for row in rows:
        if not row["passed"]:
            for what in (row["failed"] or "not run").split("; "):
                where.setdefault(what.split(" = ")[0], []).append(f"seed {row['seed']}: {what}")
    return [found[0] + (f", and in {len(found) - 1} more" if len(found) > 1 else "") for found in where.values()]
