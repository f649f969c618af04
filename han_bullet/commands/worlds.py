"""`han-bullet worlds`: list the worlds, check one, print the schema."""

from __future__ import annotations

import argparse

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from han_bullet.commands.parsing import Commands, Parser, command


def add(commands: Commands[Parser]) -> None:
    """Add `worlds`."""
    parser = command(
        commands,
        "worlds",
        "list the worlds, or check one and show what each of its cameras covers",
        "  han-bullet worlds\n  han-bullet worlds real2\n  han-bullet worlds my_world.yaml\n"
        "  han-bullet worlds --schema > world.schema.json",
    )
    parser.add_argument("world", nargs="?", help="name or YAML file; without it, list the shipped worlds")
    parser.add_argument("--schema", action="store_true", help="print the JSON Schema of world files")
    parser.set_defaults(handler=_worlds)


def _worlds(options: argparse.Namespace, console: Console) -> int:
    from han_bullet.world_file import json_schema, load_world, world_names

    if options.schema:
        console.print_json(data=json_schema())
        return 0
    if options.world is None:
        for name in world_names():
            console.print(f"[bold]{escape(name)}[/]  {escape(load_world(name).description)}", soft_wrap=True)
        return 0
    from han_bullet.checks import check_world
    from han_bullet.coverage import coverages
    from han_bullet.world_file import find_world

    world = load_world(options.world)
    check_world(world, str(find_world(options.world)))
    console.print(f"[bold]{escape(world.name)}[/]  {escape(world.description)}", soft_wrap=True)
    people = ", ".join(f"{p.name} ({p.behaviour.kind})" for p in world.people) or "nobody"
    console.print(f"people: {people}; task: {world.task.kind}; at most {world.duration:g} s", markup=False)
    table = Table(title="floor with a whole person in view (onboard: at the start)", title_justify="left")
    for heading in ("camera", r"area \[m²]", "share of floor", r"x \[m]", r"y \[m]"):
        table.add_column(heading, justify="left" if heading == "camera" else "right")
    for coverage in coverages(world):
        x, y = (f"{e[0]:.1f} to {e[1]:.1f}" if e else "-" for e in (coverage.x, coverage.y))
        table.add_row(escape(coverage.camera), f"{coverage.area:.1f}", f"{coverage.share:.0%}", x, y)
    console.print(table)
    return 0
