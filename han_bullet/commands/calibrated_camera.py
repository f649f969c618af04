"""What `han-bullet calibrate` says: a table of the points, and where the camera hangs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

if TYPE_CHECKING:
    from han_bullet.calibration.calibration import Calibration
    from han_bullet.calibration.solve import Solution
    from han_bullet.geometry import Array


def print_points(solution: Solution, console: Console) -> None:
    """Print a row per point: marked, and how far off; red where it was left out."""
    calibration = solution.calibration
    rows = calibration.points.rows()
    raised = any(row[-1] for row in rows)  # above the floor
    table = Table(title="points, and how far from there the camera shows them", title_justify="left")
    for heading in ("", r"u \[px]", r"v \[px]", r"x \[m]", r"y \[m]", *([r"z \[m]"] if raised else [])):
        table.add_column(heading, justify="right")
    for heading in (r"error \[px]", r"on the floor \[cm]"):
        table.add_column(heading, justify="right")
    errors = zip(calibration.pixel_errors().tolist(), calibration.floor_errors().tolist(), strict=True)
    for number, ((u, v, *place), (pixels, metres)) in enumerate(zip(rows, errors, strict=True), 1):
        places = [f"{value:.2f}" for value in (place if raised else place[:2])]
        off = [f"{pixels:.2f}", f"{100.0 * metres:.1f}" if math.isfinite(metres) else "-"]
        style = "red" if number - 1 == solution.left_out else None
        table.add_row(str(number), f"{u:.1f}", f"{v:.1f}", *places, *off, style=style)
    console.print(table)


def print_camera(solution: Solution, console: Console) -> None:
    """Print errors, place, view and focal length."""
    calibration, left_out = solution.calibration, solution.left_out
    errors = calibration.pixel_errors()
    worst = int(errors.argmax())
    lines = [f"reprojection error: {_rms(errors):.2f} px RMS; worst {errors[worst]:.2f} px, point {worst + 1}"]
    if left_out is not None:
        rest = _rms(errors[[index for index in range(len(errors)) if index != left_out]])
        lines.append(
            f"point {left_out + 1} is off by {errors[left_out]:.0f} px; measured or typed wrong? It was left out: the "
            f"others have {rest:.2f} px RMS"
        )
    x, y, z = (_with_deviation(*pair) for pair in zip(_position(calibration), solution.position_deviation, strict=True))
    lines += [f"position: x {x}, y {y} m, {z} m above the floor", f"view: {_view(calibration)}", focal_length(solution)]
    for line in lines:
        console.print(line, markup=False, highlight=False, soft_wrap=True)


def focal_length(solution: Solution) -> str:
    """Return the focal length, where it is from and what field of view it gives."""
    lens, deviation = solution.calibration.intrinsics, solution.focal_deviation
    angle = math.degrees(2.0 * math.atan(0.5 * lens.height / lens.fy))
    if deviation is None:
        return f"focal length: {lens.fx:.1f} px, as given; vertical field of view {angle:.1f} degrees"
    return (
        f"focal length: {_with_deviation(lens.fx, deviation, 1)} px, solved from the points for square pixels and a "
        f"principal point in the image's middle; vertical field of view {angle:.1f} degrees"
    )


def _with_deviation(value: float, deviation: float, digits: int = 2) -> str:
    return f"{_plain(value, digits)} ± {deviation:.{digits}f}"


def _plain(value: float, digits: int) -> str:
    """Return a rounded number, 0 without a sign."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def _position(calibration: Calibration) -> Array:
    return calibration.camera_in_world[:3, 3]


def _view(calibration: Calibration) -> str:
    yaw, down, roll = (_plain(math.degrees(angle), 1) for angle in calibration.view_angles())
    text = f"{yaw} degrees from x towards y, {down} degrees down, turned {roll} degrees clockwise"
    place = calibration.looked_at()
    if place is None:
        return text
    x, y = (_plain(value, 2) for value in place)
    return f"{text}; in the middle is the floor at x {x}, y {y} m"


def _rms(errors: Array) -> float:
    return float((errors**2).mean() ** 0.5)
