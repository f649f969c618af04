"""`han-bullet train`: make the weights of the pedestrian detector."""

from __future__ import annotations

import argparse
from pathlib import Path

from rich.console import Console

from han_bullet.commands.parsing import Commands, Parser, command, natural, positive


def add(commands: Commands[Parser]) -> None:
    """Add `train`."""
    parser = command(
        commands,
        "train",
        "train a stage of the detector from the INRIA photographs",
        "  han-bullet train acf --data DIR\n"
        "  han-bullet train cnn --data DIR --acf runs/train/acf.npz --out runs/train/cnn.safetensors",
    )
    add_option = parser.add_argument
    add_option("stage", choices=("acf", "cnn"), help="acf: the boosted cascade; cnn: the classifier of its proposals")
    add_option("--data", type=Path, required=True, metavar="DIR", help="folder with inria/train_pos and train_neg")
    add_option("--out", type=Path, metavar="FILE", help="weights to write (default runs/train/)")
    add_option("--seed", type=natural, default=0, help="of every random choice (default 0)")
    add_option("--acf", default="default", metavar="NAME|FILE", help="cnn: whose proposals to learn from")
    add_option("--epochs", type=positive, help="cnn: passes over the samples (default: as shipped)")
    parser.set_defaults(handler=_train)


def _train(options: argparse.Namespace, console: Console) -> int:
    out = options.out or Path("runs/train") / {"acf": "acf.npz", "cnn": "cnn.safetensors"}[options.stage]
    out.parent.mkdir(parents=True, exist_ok=True)
    (_train_acf if options.stage == "acf" else _train_cnn)(options, out, console)
    console.print(f"weights in {out}", soft_wrap=True)
    return 0


def _train_acf(options: argparse.Namespace, out: Path, console: Console) -> None:
    from rich.progress import Progress

    from han_bullet.detection.training.acf_training import train_acf

    with Progress(console=console) as bar:
        task = bar.add_task("train acf", total=1.0)

        def report(line: str, done: float) -> None:
            bar.update(task, completed=done)
            bar.log(line)

        train_acf(options.data, out, options.seed, report)


def _train_cnn(options: argparse.Namespace, out: Path, console: Console) -> None:
    from han_bullet.detection.acf import AcfDetector, load_acf_model
    from han_bullet.detection.threads import use_one_thread
    from han_bullet.detection.training.cnn_training import EPOCHS, train_cnn

    use_one_thread()
    proposer = AcfDetector(load_acf_model(options.acf))
    train_cnn(options.data, proposer, out, options.seed, options.epochs or EPOCHS, report=console.log)
