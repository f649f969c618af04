"""`han-bullet evaluate`: the figures of the pedestrian detector on photographs and on rendered sequences."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from han_bullet.commands.parsing import Commands, Parser, command, output_folder, positive
from han_bullet.errors import BadInputError

if TYPE_CHECKING:
    from han_bullet.detector_figures import FiguresRow
    from han_bullet.evaluation_report import WeightsFile

Result = TypeVar("Result")
FRAMES = 500  # of each rendered sequence


def add(commands: Commands[Parser]) -> None:
    """Add `evaluate`."""
    parser = command(
        commands,
        "evaluate",
        "miss rate and speed of the detector, with and without the CNN, on the INRIA test photographs or on renderings",
        "  han-bullet evaluate --data DIR\n"
        "  han-bullet evaluate --data DIR --model my_acf.npz --classifier my_cnn.safetensors --out runs/mine\n"
        "  han-bullet evaluate --data DIR --compare AcfInriaDetector.mat hog --out runs/compared\n"
        "  han-bullet evaluate --data DIR --model my_acf.npz --choose-threshold --out runs/mine\n"
        "  han-bullet evaluate --rendered --frames 200",
    )
    add_option = parser.add_argument
    add_option("--data", type=Path, metavar="DIR", help="folder of the photographs, with inria/ or INRIAPerson/ in it")
    add_option("--rendered", action="store_true", help="instead: a ceiling camera's and the robot's rendered sequence")
    add_option("--frames", type=positive, metavar="N", help=f"of each rendered sequence (default {FRAMES})")
    add_option(
        "--model", default="default", metavar="NAME|FILE", help="a shipped ACF model, hog, or a file, as of detect"
    )
    add_option("--compare", nargs="+", default=[], metavar="NAME|FILE", help="others in the table; hog: OpenCV's")
    add_option("--classifier", default="default", metavar="NAME|FILE", help="a shipped CNN or a file of one")
    add_option("--out", type=output_folder, metavar="DIR", help="write evaluation.json, .md and the curves as pictures")
    add_option(
        "--choose-threshold",
        action="store_true",
        help="choose the score that leaves 0.45 false positives per photograph; with --out, write the model with it",
    )
    parser.set_defaults(handler=_evaluate)


def _evaluate(options: argparse.Namespace, console: Console) -> int:
    if (options.data is None) != options.rendered:
        raise BadInputError("evaluate needs either --data DIR with photographs or --rendered; see evaluate --help")
    if options.frames and not options.rendered:
        raise BadInputError("--frames is for --rendered; of photographs, all are looked at")
    if options.choose_threshold:
        _choose_threshold(options, console)
    elif options.rendered:
        _rendered(options, console)
    else:
        _photographs(options, console)
    return 0


def _choose_threshold(options: argparse.Namespace, console: Console) -> None:
    from han_bullet.detection.inria import load_test_photographs
    from han_bullet.inria_table import choose_threshold

    _check_choice(options)
    images = load_test_photographs(options.data)
    model = _with_bar(len(images), console, lambda report: choose_threshold(images, options.model, report))
    console.print(f"score threshold {model.score_threshold:.2f}")
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        model.save(options.out / "acf.npz")
        console.print(f"model in {options.out / 'acf.npz'}", markup=False, soft_wrap=True)


def _check_choice(options: argparse.Namespace) -> None:
    """Refuse what the choice of a threshold would not look at."""
    from han_bullet.detection.model_files import has_one_stage

    if options.rendered:
        raise BadInputError("--choose-threshold is for photographs: --data DIR instead of --rendered")
    if options.compare or options.classifier != "default":
        raise BadInputError("--choose-threshold looks at --model alone, without --compare and --classifier")
    if has_one_stage(options.model):
        raise BadInputError(f"model is {options.model!r}; only ACF models have a threshold to choose")


def _photographs(options: argparse.Namespace, console: Console) -> None:
    from han_bullet.detection.inria import load_test_photographs, photographs_note
    from han_bullet.detection.stages import load_stages
    from han_bullet.evaluation_report import LEGEND, PHOTOGRAPHS
    from han_bullet.inria_table import evaluate_photographs

    images = load_test_photographs(options.data)
    detectors = load_stages([options.model, *options.compare], options.classifier)
    rows = _with_bar(len(images), console, lambda report: evaluate_photographs(images, detectors, report))
    notes = {"figures": LEGEND, "images": photographs_note(options.data, images)}
    _show(rows, PHOTOGRAPHS, notes, options, console)


def _rendered(options: argparse.Namespace, console: Console) -> None:
    from han_bullet.detection.stages import load_stages
    from han_bullet.evaluation_report import RENDERED, RENDERED_LEGEND
    from han_bullet.rendered_table import SEQUENCES, evaluate_rendered

    detectors = load_stages([options.model, *options.compare], options.classifier)
    frames = options.frames or FRAMES
    total = len(SEQUENCES) * frames
    rows = _with_bar(total, console, lambda report: evaluate_rendered(frames, detectors, report))
    note = f"{frames} rendered frames of each sequence; people cut, hidden, small or seen steeply are ignored"
    notes = {"figures": RENDERED_LEGEND, "images": note}
    _show(rows, RENDERED, notes, options, console)


def _with_bar(total: int, console: Console, work: Callable[[Callable[[int], None]], Result]) -> Result:
    """Do work that reports how many images are done."""
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task("evaluate", total=total)
        return work(lambda done: bar.update(task, completed=done))


def _show(
    rows: Sequence[FiguresRow],
    headings: Sequence[str],
    notes: Mapping[str, str],
    options: argparse.Namespace,
    console: Console,
) -> None:
    from han_bullet.evaluation_report import write_report

    for name in dict.fromkeys(row.images for row in rows):
        console.print(_table([row for row in rows if row.images == name], headings))
    console.print(f"\n{notes['figures']}\n{notes['images']}", soft_wrap=True)
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        write_report(options.out, rows, headings, notes, _weights_files(options))
        console.print(f"figures in {options.out}/", markup=False, soft_wrap=True)


def _weights_files(options: argparse.Namespace) -> list[WeightsFile]:
    """Return which weights the figures are of."""
    from han_bullet.detection.model_files import classifier_file, is_hog, proposer_file
    from han_bullet.evaluation_report import WeightsFile
    from han_bullet.provenance import sha256

    files = []
    for model in (options.model, *options.compare):
        file = None if is_hog(model) else proposer_file(model)
        files.append(WeightsFile("model", model, str(file) if file else None, sha256(file) if file else None))
    classifier = classifier_file(options.classifier)
    return [*files, WeightsFile("classifier", options.classifier, str(classifier), sha256(classifier))]


def _table(rows: Sequence[FiguresRow], headings: Sequence[str]) -> Table:
    """Return the table of one set of images, without columns that would say the same in each line."""
    from han_bullet.evaluation_report import cells

    same = {"images"} | ({"model"} if len({row.model for row in rows}) == 1 else set())
    shown = [heading for heading in headings if heading not in same]
    title = f"{rows[0].images}, {rows[0].model}" if "model" in same else rows[0].images
    columns = [heading.replace(" ", "\n") for heading in shown]
    table = Table(*columns, title=title, title_justify="left", box=None, padding=(0, 1, 0, 0))
    for line in cells(rows, shown):
        table.add_row(*line)
    return table
