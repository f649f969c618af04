"""`han-bullet explain`: why a finished run knew of somebody, or did not, and which layer moved its way."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape

from han_bullet.commands.parsing import Commands, Parser, command, output_folder

if TYPE_CHECKING:
    from han_bullet.explain.explanation import Explanation, PersonExplained, WayExplained

FINEST = 1e-6  # [m]: the files' last decimal


def add(commands: Commands[Parser]) -> None:
    """Add `explain`."""
    parser = command(
        commands,
        "explain",
        "ask a finished run why there is a track or none, and which layer moved the way",
        "  han-bullet explain runs/real2 --time 8\n  han-bullet explain runs/real2 --time 8 --plot real2_8s.png",
    )
    parser.add_argument("run", type=Path, metavar="RUN", help="folder that `han-bullet run` left")
    parser.add_argument("--time", type=float, required=True, metavar="T", help="of the run [s]")
    parser.add_argument("--plot", type=_png, metavar="FILE.png", help="also draw the moment, with a way per layer")
    parser.set_defaults(handler=_explain)


def _png(text: str) -> Path:
    """Read the name of a picture to write."""
    if Path(text).suffix.lower() != ".png":
        raise argparse.ArgumentTypeError(f"{text!r} does not end in .png")
    if Path(text).is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} is a folder; a file for the picture would be right")
    return output_folder(str(Path(text).parent)) / Path(text).name


def _explain(options: argparse.Namespace, console: Console) -> int:
    from han_bullet.explain.explainer import explain
    from han_bullet.explain.recorded_run import read_run
    from han_bullet.explain.replay import replay

    replayed = replay(read_run(options.run), options.time)
    explanation = explain(replayed)
    _print_head(explanation, console)
    _print_people(explanation, console)
    _print_way(explanation.way, console)
    if options.plot is not None:
        from han_bullet.explain.picture import draw

        draw(replayed, explanation, options.plot)
        console.print(f"picture: {options.plot}", markup=False, soft_wrap=True)
    return 0


def _print_head(explanation: Explanation, console: Console) -> None:
    title = f"[bold]{escape(explanation.world)}[/], seed {explanation.seed}, at {explanation.time:.2f} s"
    if explanation.difference is None:
        title += "; perception: truth"
    elif not explanation.warnings:
        title += f"; the replay agrees with tracks.csv to {max(explanation.difference, FINEST):.6f} m"
    console.print(title, soft_wrap=True)
    for warning in explanation.warnings:
        console.print(f"[yellow]not certain[/]: {escape(warning)}", soft_wrap=True)
    for fault in explanation.faults:
        told = f"{fault.sensor} was known to be {fault.kind} since {fault.since:.2f} s"
        console.print(f"[yellow]fault[/]: {told}", soft_wrap=True)


def _print_people(explanation: Explanation, console: Console) -> None:
    console.print("\n[bold]People[/]")
    for person in explanation.people:
        _print_person(person, console)
    for stray in explanation.strays:
        nearest = (
            "no person anywhere" if stray.nearest is None else f"{stray.nearest[0]} is {stray.nearest[1]:.2f} m away"
        )
        place = "({:.2f}, {:.2f})".format(*stray.place)
        console.print(f"[red]track {stray.track} at {place} stands for nobody[/]: {escape(nearest)}", soft_wrap=True)
        console.print(f"  {escape(stray.text)}", soft_wrap=True)
    if explanation.detections:
        console.print("boxes (x, y, width, height) of the cameras' last frames:")
    for box in explanation.detections:
        pixels = ", ".join(f"{number:.0f}" for number in box.box)
        where = "foot point ({:.2f}, {:.2f})".format(*box.foot_point)
        line = f"  {box.camera} at {box.time:.2f} s: ({pixels}), score {box.score:.1f}, {where}: {box.text}"
        console.print(escape(line), soft_wrap=True)


def _print_person(person: PersonExplained, console: Console) -> None:
    where = escape(f"{person.name} at ({person.place[0]:.2f}, {person.place[1]:.2f}), {person.posture}")
    if person.track is not None:
        console.print(f"[green]{where}: track {person.track}[/], {person.distance:.2f} m off", soft_wrap=True)
    else:
        console.print(f"[red]{where}: no track[/]", soft_wrap=True)
    for line in person.history:
        console.print(f"  {escape(line)}", soft_wrap=True)
    for sighting in person.sightings:
        when = "" if sighting.time is None else f" at {sighting.time:.2f} s"
        line = f"  {'+' if sighting.measured else '-'} {sighting.camera}{when}: {sighting.text}"
        console.print(escape(line), soft_wrap=True)


def _print_way(way: WayExplained, console: Console) -> None:
    from han_bullet.explain.sentences import NOTICED, details, has_effect, sides_of, verdict

    console.print(f"\n[bold]Way[/] (the robot is {way.status.value})", soft_wrap=True)
    if way.step is not None:
        since, step = way.step
        console.print(f"it cannot go on: since {since:.2f} s it {step.value}", soft_wrap=True)
    if not way.has_task:
        console.print("it has no task", soft_wrap=True)
        return
    if way.best is None:
        console.print("there is no free way", soft_wrap=True)
    else:
        sides = f"; it has {sides_of(way.sides)}" if way.sides else ""
        console.print(
            f"best way: {way.best_length:.2f} m long, costs {way.best_cost:.2f}{sides}", markup=False, soft_wrap=True
        )
    kept = way.kept_shift
    if kept is not None and abs(kept.largest) >= NOTICED:
        where = "up to {:.2f} m beside it near ({:.1f}, {:.1f})".format(abs(kept.largest), *kept.place)
        console.print(f"the robot keeps an older way, {where}, which costs {way.taken_cost:.2f}", soft_wrap=True)
    idle = [effect.layer for effect in way.layers if not has_effect(effect, way)]
    for effect in way.layers:
        if effect.layer not in idle:
            console.print(f"  {effect.layer}: {escape(details(effect, way))}", soft_wrap=True)
    console.print(f"  without effect: {', '.join(idle) or 'none'}", markup=False, soft_wrap=True)
    for line in verdict(way):
        console.print(f"[bold]{escape(line)}[/]", soft_wrap=True)
