"""`han-bullet evaluate`: the figures of the pedestrian detector on photographs."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from pathlib import Path

from rich import box
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from han_bullet.commands.parsing import Commands, Parser, command, output_folder


def add(commands: Commands[Parser]) -> None:
    """Add `evaluate`."""
    parser = command(
        commands,
        "evaluate",
        "miss rate and speed of the detector on the INRIA test photographs, with and without the CNN",
        "  han-bullet evaluate --data DIR\n"
        "  han-bullet evaluate --data DIR --model my_acf.npz --classifier my_cnn.safetensors --out runs/mine\n"
        "  han-bullet evaluate --data DIR --compare AcfInriaDetector.mat --out runs/compared\n"
        "  han-bullet evaluate --data DIR --model my_acf.npz --choose-threshold --out runs/mine",
    )
    add_option = parser.add_argument
    add_option("--data", type=Path, required=True, metavar="DIR", help="folder with inria/ or INRIAPerson/ in it")
    add_option("--model", default="default", metavar="NAME|FILE", help="a shipped ACF model or a file of one")
    add_option("--compare", nargs="+", default=[], metavar="NAME|FILE", help="other models, in the same table")
    add_option("--classifier", default="default", metavar="NAME|FILE", help="a shipped CNN or a file of one")
    add_option("--out", type=output_folder, metavar="DIR", help="write evaluation.json, .md and miss_rate.png")
    add_option(
        "--choose-threshold",
        action="store_true",
        help="choose the score that leaves 0.45 false positives per image; with --out, write the model with it",
    )
    parser.set_defaults(handler=_evaluate)


def _evaluate(options: argparse.Namespace, console: Console) -> int:
    (_choose_threshold if options.choose_threshold else _photographs)(options, console)
    return 0


def _choose_threshold(options: argparse.Namespace, console: Console) -> None:
    from han_bullet.inria_table import choose_threshold

    model = choose_threshold(options.data, options.model)
    console.print(f"score threshold {model.score_threshold:.2f}")
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        model.save(options.out / "acf.npz")
        console.print(f"model in {options.out / 'acf.npz'}", soft_wrap=True)


def _photographs(options: argparse.Namespace, console: Console) -> None:
    from han_bullet.detection.inria import load_test_photographs, photographs_note
    from han_bullet.evaluation_report import HEADINGS, LEGEND, cells, write_report
    from han_bullet.inria_table import evaluate_stages, load_stages

    images = load_test_photographs(options.data)
    note = photographs_note(options.data, images)
    detectors = load_stages([options.model, *options.compare], options.classifier)
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task("evaluate", total=len(images))
        rows = evaluate_stages(images, detectors, lambda done: bar.update(task, completed=done))
    _print_table(HEADINGS, map(cells, rows), console)
    console.print(f"{LEGEND}\n{note}", soft_wrap=True)
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        write_report(options.out, rows, note)
        console.print(f"figures in {options.out}/", soft_wrap=True)


def _print_table(headings: Sequence[str], rows: Iterable[Sequence[str]], console: Console) -> None:
    table = Table(*headings, box=box.SIMPLE_HEAD, show_edge=False)
    for row in rows:
        table.add_row(*row)
    console.print(table)
