"""`han-bullet train acf | cnn`: make the detector's weights from photographs."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from han_bullet.commands.parsing import Commands, Parser, command, natural, positive

Report = Callable[[str, float], None]
ENDINGS = {"acf": ".npz", "cnn": ".safetensors"}
MEASURED_BY = {"acf": "--model", "cnn": "--classifier"}  # options of `evaluate`


def add(commands: Commands[Parser]) -> None:
    """Add `train` with a subcommand for each stage."""
    parser = command(
        commands,
        "train",
        "train a stage of the detector from the INRIA photographs",
        "  han-bullet train acf --data DIR\n"
        "  han-bullet train cnn --data DIR --acf runs/train/acf.npz --recipe extended",
    )
    stages = parser.add_subparsers(metavar="STAGE", required=True, parser_class=Parser)
    _add_acf(stages)
    _add_cnn(stages)


def _add_acf(stages: Commands[Parser]) -> None:
    parser = command(
        stages,
        "acf",
        "train the boosted cascade of the first stage, in four stages that each learn from the last one's mistakes",
        "  han-bullet train acf --data DIR\n"
        "  han-bullet train acf --data DIR --boosting discrete --depth 2 --misplaced 0  # the original",
    )
    _add_common(parser, "acf")
    add = parser.add_argument
    add("--boosting", choices=("gentle", "discrete"), default="gentle", help="discrete: AdaBoost, as the original")
    add("--depth", type=positive, default=3, help="of each tree (default 3; the original: 2)")
    add("--misplaced", type=natural, default=1, help="wrong windows around each person (default 1; the original: 0)")
    parser.set_defaults(handler=_train_acf)


def _add_cnn(stages: Commands[Parser]) -> None:
    parser = command(
        stages,
        "cnn",
        "train the classifier of the first stage's proposals",
        "  han-bullet train cnn --data DIR                     # the paper's recipe\n"
        "  han-bullet train cnn --data DIR --recipe extended   # as the shipped weights\n"
        "  han-bullet train cnn --data DIR --network vgg-d --weights vgg16.pth",
    )
    _add_common(parser, "cnn")
    add = parser.add_argument
    add("--acf", default="default", metavar="NAME|FILE", help="whose proposals to learn from")
    add(
        "--network",
        choices=("squeezenet", "vgg-d", "small"),
        default="squeezenet",
        help="squeezenet from ImageNet weights in DIR/squeezenet; vgg-d, the paper's; small, narrow and from scratch",
    )
    add(
        "--weights",
        type=Path,
        metavar="FILE",
        help="ImageNet weights; vgg-d: torchvision's VGG-16 (.pth)",
    )
    add(
        "--recipe",
        choices=("paper", "extended"),
        default="paper",
        help="what to train on, and how (default paper)",
    )
    add("--epochs", type=positive, help="passes over the samples (default: the recipe's)")
    add("--learning-rate", type=float, metavar="RATE", help="default: the recipe's")
    add("--deviation", type=float, help="of the fully connected layers' initial weights (default 0.01; the paper: 0.1)")
    add("--bf16", action="store_true", help="multiply in bfloat16: faster on processors that have it")
    add("--resume", action="store_true", help="go on from the checkpoint of an interrupted training")
    parser.set_defaults(handler=_train_cnn)


def _add_common(parser: Parser, stage: str) -> None:
    ending, default = ENDINGS[stage], Path(f"runs/train/{stage}{ENDINGS[stage]}")

    def weights(text: str) -> Path:
        path = Path(text)
        if path.is_dir() or path.suffix != ending:
            what = "is a folder" if path.is_dir() else f"ends in {path.suffix!r}" if path.suffix else "has no ending"
            raise argparse.ArgumentTypeError(f"{text!r} {what}; a file for the weights, {ending}, would be right")
        return path

    add = parser.add_argument
    add("--data", type=Path, required=True, metavar="DIR", help="folder with INRIA's photographs (docs/detector.md)")
    add("--out", type=weights, default=default, metavar="FILE", help=f"weights to write (default {default})")
    add("--seed", type=natural, default=0, help="of every random choice (default 0)")


def _train_acf(options: argparse.Namespace, console: Console) -> int:
    from han_bullet.detection.training.acf_training import AcfTrainingOptions, train_acf
    from han_bullet.detection.training.boosting import DiscreteAdaBoost, GentleBoost

    boosting = GentleBoost() if options.boosting == "gentle" else DiscreteAdaBoost()
    training = AcfTrainingOptions(boosting=boosting, depth=options.depth, misplaced=options.misplaced)

    def train(report: Report) -> None:
        train_acf(options.data, options.out, options.seed, report, training)

    return _run("acf", options, console, train)


def _train_cnn(options: argparse.Namespace, console: Console) -> int:
    from han_bullet.detection.acf import AcfDetector, load_acf_model
    from han_bullet.detection.network import FULLY_CONNECTED_DEVIATION
    from han_bullet.detection.threads import use_one_thread
    from han_bullet.detection.training.cnn_training import CnnTraining, train_cnn
    from han_bullet.detection.training.recipe import EXTENDED, PAPER

    use_one_thread()
    recipe = EXTENDED if options.recipe == "extended" else PAPER
    recipe = replace(
        recipe,
        epochs=options.epochs or recipe.epochs,
        learning_rate=recipe.learning_rate if options.learning_rate is None else options.learning_rate,
    )
    deviation = FULLY_CONNECTED_DEVIATION if options.deviation is None else options.deviation
    training = CnnTraining(options.network, options.weights, options.seed, options.bf16, options.resume, deviation)
    proposer = AcfDetector(load_acf_model(options.acf))

    def train(report: Report) -> None:
        train_cnn(options.data, proposer, options.out, recipe, training, report)

    return _run("cnn", options, console, train)


def _run(stage: str, options: argparse.Namespace, console: Console, train: Callable[[Report], None]) -> int:
    """Train with a progress bar; write the log and the model card beside the weights."""
    from rich.progress import Progress, TimeElapsedColumn

    from han_bullet.model_card import TrainingLog, write_model_card

    with (
        _folder(options.out.parent),
        TrainingLog(options.out.with_suffix(".log"), getattr(options, "resume", False)) as log,
        Progress(*Progress.get_default_columns(), TimeElapsedColumn(), console=console) as bar,
    ):
        task = bar.add_task(f"train {stage}", total=1.0)

        def report(line: str, done: float) -> None:
            bar.update(task, completed=done)
            if line:
                log.write(line)
                bar.console.print(line, soft_wrap=True, highlight=False, markup=False)

        before = _written_at(options.out)
        try:
            train(report)
        finally:
            if _written_at(options.out) != before:  # an earlier card is of other weights
                options.out.with_suffix(".md").unlink(missing_ok=True)
    measuring = f"han-bullet evaluate --data DIR {MEASURED_BY[stage]} {options.out.name}"
    card = write_model_card(options.out, f"train {stage}", measuring, options.seed, options.data, log)
    console.print(
        f"weights in {options.out}, their card in {card}, the log in {log.path}", markup=False, soft_wrap=True
    )
    return 0


@contextmanager
def _folder(folder: Path) -> Iterator[None]:
    """Make a folder and those above it; take away again what was made if nothing has been written in the end."""
    made = [place for place in (folder, *folder.parents) if not place.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    try:
        yield
    finally:
        for place in made:
            if not any(place.iterdir()):
                place.rmdir()


def _written_at(path: Path) -> int:
    return path.stat().st_mtime_ns if path.exists() else 0
