"""`han-bullet evaluate`: the figures of the pedestrian detector on photographs."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.table import Table

from han_bullet.atomic_file import write_json
from han_bullet.commands.parsing import Commands, Parser, command


def add(commands: Commands[Parser]) -> None:
    """Add `evaluate`."""
    parser = command(
        commands,
        "evaluate",
        "miss rate of the detector on the INRIA test photographs, with and without the CNN",
        "  han-bullet evaluate --data DIR\n  han-bullet evaluate --data DIR --model my_acf.npz --out runs/mine",
    )
    add_option = parser.add_argument
    add_option("--data", type=Path, required=True, metavar="DIR", help="folder with inria/test and inria/gt.json")
    add_option("--model", default="default", metavar="NAME|FILE", help="a shipped ACF model or a file of one")
    add_option("--out", type=Path, metavar="DIR", help="also write evaluation.json there")
    add_option(
        "--choose-threshold",
        action="store_true",
        help="choose the score that leaves 0.45 false positives per image; with --out, write the model with it",
    )
    parser.set_defaults(handler=_evaluate)


def _evaluate(options: argparse.Namespace, console: Console) -> int:
    from rich.progress import Progress

    from han_bullet.inria_table import choose_threshold, evaluate_stages

    if options.choose_threshold:
        model = choose_threshold(options.data, options.model)
        console.print(f"score threshold {model.score_threshold:.2f}")
        if options.out:
            options.out.mkdir(parents=True, exist_ok=True)
            model.save(options.out / "acf.npz")
        return 0
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task("evaluate", total=1.0)
        rows = evaluate_stages(options.data, options.model, lambda done: bar.update(task, completed=done))
    table = Table("detector", "threshold", "TP", "FP", "FN", "log-average miss rate", "frames per second")
    for row in rows:
        threshold = "all" if row.threshold is None else f"{row.threshold:.1f}"
        counts = (str(row.true_positives), str(row.false_positives), str(row.false_negatives))
        table.add_row(row.detector, threshold, *counts, f"{row.miss_rate:.2%}", f"{row.frames_per_second:.1f}")
    console.print(table)
    console.print(
        "287 of the 288 INRIA test photographs, rebuilt from copies with inpainted lines; see docs/detector.md"
    )
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        write_json(options.out / "evaluation.json", {"rows": [asdict(row) for row in rows]})
        console.print(f"figures in {options.out / 'evaluation.json'}", soft_wrap=True)
    return 0
