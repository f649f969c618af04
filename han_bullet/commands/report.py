"""`han-bullet report`: pages that tell a stranger how runs and sweeps went, and the paper's figures."""

from __future__ import annotations

import argparse
from pathlib import Path

from rich.console import Console

from han_bullet.commands.parsing import Commands, Parser, command, output_folder
from han_bullet.errors import BadInputError


def add(commands: Commands[Parser]) -> None:
    """Add `report`."""
    parser = command(
        commands,
        "report",
        "write report.html, one self-contained page, into the folder of a run or of a sweep",
        "  han-bullet report runs/real2\n"
        "  han-bullet report runs/sweep --baseline truth\n"
        "  han-bullet report runs/real1 runs/real2       # a page in each\n"
        "  han-bullet report --figures runs/figures      # the paper's figures, from our layers, planner and detector",
    )
    add_option = parser.add_argument
    add_option("runs", nargs="*", type=Path, metavar="RUNS", help="folder of a run or of a sweep")
    add_option(
        "--baseline",
        metavar="VARIANT",
        help="variant of a sweep that others are compared with (default: cameras, else the first)",
    )
    add_option("--figures", type=output_folder, metavar="DIR", help="write the paper's figures as PNG and SVG files")
    parser.set_defaults(handler=_report)


def _report(options: argparse.Namespace, console: Console) -> int:
    if not options.runs and options.figures is None:
        raise BadInputError("report needs the folder of a run or of a sweep, or --figures DIR; see report --help")
    for folder in options.runs:
        console.print(f"report: {_write(folder, options.baseline)}", markup=False, soft_wrap=True)
    if options.figures is not None:
        from han_bullet.report.paper_figures import write_figures

        options.figures.mkdir(parents=True, exist_ok=True)
        for path in write_figures(options.figures):
            console.print(f"figure: {path}", markup=False, soft_wrap=True)
    return 0


def _write(folder: Path, baseline: str | None) -> Path:
    from han_bullet.run_folder import is_run

    if is_run(folder):
        if baseline is not None:
            raise BadInputError(
                f"--baseline {baseline}: {str(folder)!r} is a single run, which has no variants; with the folder of a "
                "sweep it would be right"
            )
        from han_bullet.report.run_page import write_run_page

        return write_run_page(folder)
    from han_bullet.report.sweep_files import is_sweep

    if not is_sweep(folder):
        raise BadInputError(
            f"{str(folder)!r} is neither a run (a folder with result.json) nor a sweep (a folder with rows/*.parquet)"
        )
    from han_bullet.report.sweep_page import write_sweep_page

    return write_sweep_page(folder, baseline)
