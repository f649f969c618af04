"""`han-bullet detect | evaluate | train`: the pedestrian detector on pictures, its figures, its training."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.table import Table

from han_bullet.atomic_file import write_json
from han_bullet.commands.parsing import Commands, Parser, command, natural, positive


def add(commands: Commands[Parser]) -> None:
    """Add `detect`, `evaluate` and `train`."""
    _add_detect(commands)
    _add_evaluate(commands)
    _add_train(commands)


def _add_detect(commands: Commands[Parser]) -> None:
    parser = command(
        commands,
        "detect",
        "find upright people at least 100 px high in pictures; write detections.csv and pictures with boxes",
        "  han-bullet detect photo.jpg\n  han-bullet detect photos/ --threshold 60 --out boxes/",
    )
    add = parser.add_argument
    add("paths", nargs="+", type=Path, metavar="PATH", help="picture, or folder of pictures")
    add("--model", default="default", metavar="NAME|FILE", help="a shipped ACF model or a file of one")
    add("--threshold", type=float, metavar="T", help="on the ACF score (default: the model's own)")
    add("--out", type=Path, default=Path("runs/detect"), metavar="DIR", help="folder of the results")
    parser.set_defaults(handler=_detect)


def _detect(options: argparse.Namespace, console: Console) -> int:
    from rich.progress import track

    from han_bullet.pictures import detect_pictures, find_pictures

    pictures = find_pictures(options.paths)
    found = detect_pictures(
        track(pictures, description="detect", console=console), options.model, options.threshold, options.out
    )
    console.print(f"{found} people in {len(pictures)} pictures; boxes in {options.out}/", soft_wrap=True)
    return 0


def _add_evaluate(commands: Commands[Parser]) -> None:
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


def _add_train(commands: Commands[Parser]) -> None:
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
