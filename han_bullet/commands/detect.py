"""`han-bullet detect`: the pedestrian detector on pictures."""

from __future__ import annotations

import argparse
from pathlib import Path

from rich.console import Console

from han_bullet.commands.parsing import Commands, Parser, command


def add(commands: Commands[Parser]) -> None:
    """Add `detect`."""
    parser = command(
        commands,
        "detect",
        "find upright people at least 100 px high in pictures; write detections.csv and pictures with boxes",
        "  han-bullet detect photo.jpg\n  han-bullet detect photos/ --threshold 60 --out boxes/",
    )
    add_option = parser.add_argument
    add_option("paths", nargs="+", type=Path, metavar="PATH", help="picture, or folder of pictures")
    add_option("--model", default="default", metavar="NAME|FILE", help="a shipped ACF model or a file of one")
    add_option("--threshold", type=float, metavar="T", help="on the ACF score (default: the model's own)")
    add_option("--out", type=Path, default=Path("runs/detect"), metavar="DIR", help="folder of the results")
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
