"""`han-bullet detect`: the pedestrian detector on pictures, videos and a camera."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from han_bullet.commands.parsing import Commands, Parser, command, output_folder
from han_bullet.errors import BadInputError

if TYPE_CHECKING:
    from han_bullet.detection.pictures import Image
    from han_bullet.image_sources import ImageSource
    from han_bullet.window import Window

# OpenCV and its FFmpeg write lines of their own beside our sentence; they read these when cv2 is loaded.
QUIET = {"OPENCV_LOG_LEVEL": "SILENT", "OPENCV_FFMPEG_LOGLEVEL": "-8"}
EXAMPLES = """\
  han-bullet detect photo.jpg
  han-bullet detect photos/ clip.mp4 --threshold 60 --out boxes/
  han-bullet detect clip.mp4 --model FastestDet.onnx
  han-bullet detect photo.jpg --classifier my_cnn.safetensors
  han-bullet detect photo.jpg --model hog       # OpenCV's, to compare with
  han-bullet detect 0 --show                    # the first camera, until Ctrl-C
people lower than 96 px are not found by the shipped models; enlarge such pictures.
detections.csv names a video's frames by the path as given: videos/clip.mp4#000123, counted from 0."""


def add(commands: Commands[Parser]) -> None:
    """Add `detect`."""
    parser = command(
        commands,
        "detect",
        "find upright people at least 96 px high in pictures and videos; write detections.csv and annotated copies",
        EXAMPLES,
    )
    add_option = parser.add_argument
    add_option("paths", nargs="+", type=Path, metavar="PATH", help="picture, video, folder of these, or camera number")
    add_option("--model", default="default", metavar="NAME|FILE", help="a shipped one, hog, .npz, .mat, .onnx or .cfg")
    add_option("--classifier", default="default", metavar="NAME|FILE", help="a shipped CNN or a file of one")
    add_option("--threshold", type=float, metavar="T", help="on the score (default: the model's own)")
    add_option("--out", type=output_folder, default=Path("runs/detect"), metavar="DIR", help="folder of the results")
    add_option("--show", action="store_true", help="also show the annotated images in a window")
    parser.set_defaults(handler=_detect)


def _detect(options: argparse.Namespace, console: Console) -> int:
    for name, level in QUIET.items():
        os.environ.setdefault(name, level)
    from han_bullet.detection.loading import load_detector
    from han_bullet.detection.threads import use_one_thread
    from han_bullet.pictures import detect_sources
    from han_bullet.window import Window

    window = Window("han-bullet detect") if options.show else None
    use_one_thread()
    detector = load_detector(options.model, options.threshold, options.classifier)
    complaints = Console(stderr=True, soft_wrap=True, highlight=False, markup=False)

    def complain(message: str) -> None:
        complaints.print(f"han-bullet: {message}")

    sources = _find(options.paths, complain)
    if not sources:
        return 2
    with _progress(console) as bar:
        look = _watcher(bar, sources, window)
        tally = detect_sources(sources, detector, options.out, complain=complain, look=look)
    if tally.images == 0:
        return 2
    console.print(
        f"{tally.people} people in {tally.images} images; results in {options.out}/", markup=False, soft_wrap=True
    )
    return 0


def _find(paths: Sequence[Path], complain: Callable[[str], None]) -> list[ImageSource]:
    """Return what the paths name; complain of those that name nothing."""
    from han_bullet.commands.watched_camera import WatchedCamera
    from han_bullet.image_sources import find_sources

    sources: list[ImageSource] = []
    for path in paths:
        try:
            camera = str(path).isdigit() and not path.exists()
            sources += [WatchedCamera(int(str(path)))] if camera else find_sources(path)
        except BadInputError as error:
            complain(str(error))
        except OSError as error:
            complain(f"{path} cannot be read: {error.strerror or error}")
    return sources


def _watcher(
    bar: Progress, sources: Sequence[ImageSource], window: Window | None
) -> Callable[[ImageSource, Image], None]:
    """Return what shows each image that was looked at, in the bar and in the window."""
    from han_bullet.image_sources import Video

    pictures = not any(isinstance(source, Video) for source in sources)  # how many frames a video has is seen later
    task = bar.add_task("detect", rate="", total=len(sources) if pictures and len(sources) > 1 else None)

    def look(source: ImageSource, picture: Image) -> None:
        total = source.length if len(sources) == 1 and isinstance(source, Video) else bar.tasks[0].total
        speed = bar.tasks[0].speed
        rate = f", {speed:.1f} per second" if speed else ""
        bar.update(task, advance=1, total=total, description=source.name, rate=rate)
        if window is not None:
            window.show(picture)

    return look


def _progress(console: Console) -> Progress:
    rate = TextColumn("{task.completed} images{task.fields[rate]}")
    return Progress(TextColumn("{task.description}"), BarColumn(), rate, TimeElapsedColumn(), console=console)
