"""`han-bullet calibrate`: where a fixed camera of one's own hangs, from floor points marked in its image."""

from __future__ import annotations

import argparse
import math
import re
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console

from han_bullet.commands.calibrated_camera import focal_length, print_camera, print_points
from han_bullet.commands.parsing import Commands, Parser, command, output_folder
from han_bullet.errors import BadInputError

if TYPE_CHECKING:
    from han_bullet.calibration.lens import Distortion
    from han_bullet.calibration.points import MarkedPoints
    from han_bullet.calibration.solve import Solution
    from han_bullet.detection.pictures import Image
    from han_bullet.geometry import Intrinsics

EXAMPLES = """\
  han-bullet calibrate hall.jpg --points hall.csv --picture hall_grid.png
  han-bullet calibrate hall.jpg --points hall.csv --field-of-view 45 --out hall.yaml
  han-bullet calibrate 0 --points hall.csv --click      # mark them in the first camera's image, in a window
  han-bullet calibrate --points hall.csv --size 1280x720 --camera-matrix camera_info.yaml
hall.csv has the header u,v,x,y (z too, for points above the floor): pixels from the image's upper left corner, metres
on the floor, y to the left of x seen from above. docs/calibration.md has a worked example."""
PICTURES = (".png", ".jpg", ".jpeg")


def add(commands: Commands[Parser]) -> None:
    """Add `calibrate`."""
    parser = command(
        commands,
        "calibrate",
        "find where a fixed camera hangs, and its floor homography, from floor points marked in its image",
        EXAMPLES,
    )
    add_option = parser.add_argument
    add_option("image", nargs="?", type=Path, metavar="IMAGE", help="picture, video (first frame), or camera number")
    add_option("--points", type=Path, required=True, metavar="FILE", help="CSV or YAML file of u, v [px], x, y, z [m]")
    add_option("--click", action="store_true", help="add points to FILE (CSV) by clicking into the image")
    add_option("--size", type=_size, metavar="WxH", help="of the image [px], where none is given")
    lens = parser.add_mutually_exclusive_group()
    lens.add_argument("--field-of-view", type=_angle, metavar="DEG", help="vertical (default: solved from the points)")
    lens.add_argument("--focal", type=_length, metavar="PX", help="focal length in pixels")
    lens.add_argument("--camera-matrix", type=Path, metavar="FILE", help="ROS camera_info (YAML), with its distortion")
    add_option("--out", type=_yaml, metavar="NAME.yaml", help="write the calibration of camera NAME")
    add_option("--picture", type=_picture, metavar="FILE.png", help="draw points and metre grid on the image")
    parser.set_defaults(handler=_calibrate)


def _size(text: str) -> tuple[int, int]:
    """Read WIDTHxHEIGHT."""
    found = re.fullmatch(r"([1-9]\d{0,4})x([1-9]\d{0,4})", text)
    if not found:
        raise argparse.ArgumentTypeError(f"{text!r} is no size such as 1280x720")
    return int(found[1]), int(found[2])


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _angle(text: str) -> float:
    """Read a field of view [deg]."""
    if not 1.0 <= _number(text) <= 170.0:
        raise argparse.ArgumentTypeError(f"{text!r} is no angle of 1 to 170 degrees")
    return _number(text)


def _length(text: str) -> float:
    """Read a focal length [px]."""
    if not 1.0 <= _number(text) <= 1e6:
        raise argparse.ArgumentTypeError(f"{text!r} is no focal length of 1 to 1000000 px")
    return _number(text)


def _file(text: str, endings: tuple[str, ...]) -> Path:
    """Read the name of a file to write."""
    if Path(text).suffix.lower() not in endings or Path(text).is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} is no file that ends in {' or '.join(endings)}")
    return output_folder(str(Path(text).parent)) / Path(text).name


def _yaml(text: str) -> Path:
    from han_bullet.calibration.calibration import check_name

    path = _file(text, (".yaml",))
    check_name(path.stem)
    return path


def _picture(text: str) -> Path:
    return _file(text, PICTURES)


def _calibrate(options: argparse.Namespace, console: Console) -> int:
    from han_bullet.calibration.solve import solve

    image = None if options.image is None else _first_image(options.image)
    _check_options(options, image)
    lens, distortion, size = _lens(options, image)
    points = _points(options, image)
    name = "camera" if options.out is None else options.out.stem
    solution = solve(points, size, lens, distortion, name)
    print_points(solution, console)
    print_camera(solution, console)
    _write(options, image, solution, console)
    return 0


def _first_image(path: Path) -> Image:
    from han_bullet.image_sources import find_sources

    if path.is_dir():
        raise BadInputError(f"{path} is a folder; a picture, video or camera number would be right")
    images = find_sources(path)[0].images()
    try:
        return next(images)[1]
    finally:
        images.close()  # type: ignore[attr-defined]  # a generator, which may hold a camera


def _check_options(options: argparse.Namespace, image: Image | None) -> None:
    """Raise where options ask for what another one would have to give."""
    for given, option in ((options.click, "--click"), (options.picture is not None, "--picture")):
        if given and image is None:
            raise BadInputError(f"{option} needs an image; calibrate IMAGE ... would be right")
    written = [path.resolve() for path in (options.out, options.picture) if path is not None]
    for path in (options.points, options.image, options.camera_matrix):
        if path is not None and path.resolve() in written:
            raise BadInputError(f"{path} would be overwritten; another name for the result would be right")


def _lens(
    options: argparse.Namespace, image: Image | None
) -> tuple[Intrinsics | None, Distortion | None, tuple[int, int]]:
    """Return the intrinsics, None where they are open, the distortion and the size of the image."""
    from han_bullet.calibration.lens import read_camera_info
    from han_bullet.geometry import Intrinsics

    lens, distortion = (None, None) if options.camera_matrix is None else read_camera_info(options.camera_matrix)
    sizes = {
        "the image": None if image is None else (image.shape[1], image.shape[0]),
        "--size": options.size,
        str(options.camera_matrix): None if lens is None else (lens.width, lens.height),
    }
    known = {source: size for source, size in sizes.items() if size is not None}
    if not known:
        raise BadInputError("the size of the image is not known; give the image, or --size WIDTHxHEIGHT")
    if len(set(known.values())) > 1:
        told = ", ".join(f"{width} x {height} px by {source}" for source, (width, height) in known.items())
        raise BadInputError(f"the image's size is {told}; these must agree")
    width, height = size = next(iter(known.values()))
    if options.field_of_view is not None:
        lens = Intrinsics.from_vertical_field_of_view(width, height, math.radians(options.field_of_view))
    elif options.focal is not None:
        lens = Intrinsics(width, height, options.focal, options.focal, 0.5 * width, 0.5 * height)
    return lens, distortion, size


def _points(options: argparse.Namespace, image: Image | None) -> MarkedPoints:
    from han_bullet.calibration.points import CSV_ENDING, MarkedPoints, read_points, write_points

    if not options.click:
        return read_points(options.points)
    from han_bullet.calibration.clicking import click_points, open_clicking

    path: Path = options.points
    if path.suffix.lower() != CSV_ENDING:
        raise BadInputError(f"--click writes the points to {path}; a name that ends in {CSV_ENDING} would be right")
    before = read_points(path) if path.exists() else MarkedPoints.of_rows([])
    assert image is not None  # _check_options saw to it
    return click_points(open_clicking(image), before, _ask, lambda points: write_points(points, path))


def _ask(question: str) -> str:
    """Return a line from the terminal; nothing where it ends."""
    try:
        return input(question)
    except EOFError:
        return ""


def _write(options: argparse.Namespace, image: Image | None, solution: Solution, console: Console) -> None:
    calibration = solution.calibration
    if options.out is not None:
        options.out.parent.mkdir(parents=True, exist_ok=True)
        calibration.save(options.out, f"a fixed camera, by han-bullet calibrate; {focal_length(solution)}")
        console.print(f"calibration: {options.out}", markup=False, soft_wrap=True)
    if options.picture is not None and image is not None:
        from han_bullet.calibration.picture import draw, write_picture

        options.picture.parent.mkdir(parents=True, exist_ok=True)
        write_picture(draw(image, calibration), options.picture)
        console.print(f"picture: {options.picture}", markup=False, soft_wrap=True)
