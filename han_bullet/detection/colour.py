"""From RGB to the planes L, U and V (CIE 1976), by the primaries of the original [Dollar2014], without gamma."""

from __future__ import annotations

import functools

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.channels import Float, Floats
from han_bullet.detection.region import Region
from han_bullet.detection.rough_reciprocals import Bits, invert, reciprocal_table

LIGHTNESS_STEPS = 1024
LUV_RANGE = 270.0  # the span of V; maps every colour channel into [0, 1]

_ONE = np.float32(1.0)
_PER_LEVEL = np.float32(1.0 / 255.0)
_LIGHTNESS_STEPS = np.float32(LIGHTNESS_STEPS)
_X = np.array([0.430574, 0.341550, 0.178325], np.float32) * np.float32(1.0 / 255.0)  # of red, green, blue in 0..255
_Y = np.array([0.222015, 0.706655, 0.071330], np.float32) * np.float32(1.0 / 255.0)
_Z = np.array([0.020183, 0.129553, 0.939180], np.float32) * np.float32(1.0 / 255.0)


@functools.cache
def lightness_table() -> Floats:
    """Return L / 270 of the luminances 0, 1/1024, .. 1 (CIE 1976), with one entry to spare for rounding."""
    luminance = np.minimum(np.arange(LIGHTNESS_STEPS + 2) / LIGHTNESS_STEPS, 1.0)
    dark = luminance * (29.0 / 3.0) ** 3
    table = np.where(luminance > (6.0 / 29.0) ** 3, 116.0 * np.cbrt(luminance) - 16.0, dark)
    return (table / LUV_RANGE).astype(np.float32)


def luv(image: NDArray[np.uint8], rough: bool = False, wanted: Region | None = None) -> Floats:
    """Return the L, U and V planes, shape (3, h, w), each within [0, 1], of an RGB image, shape (h, w, 3).

    Args:
        image: RGB.
        rough: Whether to compute with reciprocals as rough as the original's.
        wanted: Part of the image whose planes to return; None returns all.
    """
    # The original's instructions take four pixels at a time, and leave images of other sizes to exact arithmetic.
    rough = rough and image.shape[0] * image.shape[1] % 4 == 0
    part = image if wanted is None else image[wanted.slices]
    planes: Floats = _luv(np.ascontiguousarray(part), lightness_table(), rough, reciprocal_table())
    return planes


@numba.njit(cache=True, error_model="numpy")
def _luv(image: NDArray[np.uint8], lightness: Floats, rough: bool, reciprocals: Bits) -> Floats:
    """Convert by the primaries of the original, without gamma; short loops over a row that compilers vectorise."""
    height, width = image.shape[:2]
    planes = np.empty((3, height, width), np.float32)
    rgb = np.empty((3, width), np.float32)
    luminance = np.empty(width, np.int32)
    shares = np.empty(width, np.float32)
    for row in range(height):
        pixels = image[row].reshape(-1)
        red, green, blue = rgb[0], rgb[1], rgb[2]
        for column in range(width):
            red[column], green[column], blue[column] = (
                pixels[3 * column],
                pixels[3 * column + 1],
                pixels[3 * column + 2],
            )
        light, u, v = planes[0, row], planes[1, row], planes[2, row]
        if rough:
            _rough_chromaticities(rgb, luminance, u, v, shares, reciprocals)
        else:
            for column in range(width):
                luminance[column], u[column], v[column] = _chromaticity(red[column], green[column], blue[column])
        for column in range(width):
            light[column] = lightness[luminance[column]]
        for column in range(width):
            u[column] = light[column] * u[column] + np.float32(88.0 / LUV_RANGE)
            v[column] = light[column] * v[column] + np.float32(134.0 / LUV_RANGE)
    return planes


@numba.njit(cache=True, error_model="numpy", inline="always")
def _chromaticity(red: Float, green: Float, blue: Float) -> tuple[np.int32, Float, Float]:
    """Return the luminance's place in its table and 13 (u' - u'_white), 13 (v' - v'_white) of a colour in 0..255."""
    red, green, blue = red * _PER_LEVEL, green * _PER_LEVEL, blue * _PER_LEVEL
    x = np.float32(0.430574) * red + np.float32(0.341550) * green + np.float32(0.178325) * blue
    y = np.float32(0.222015) * red + np.float32(0.706655) * green + np.float32(0.071330) * blue
    z = np.float32(0.020183) * red + np.float32(0.129553) * green + np.float32(0.939180) * blue
    share = _ONE / (x + np.float32(15.0) * y + np.float32(3.0) * z + np.float32(1e-35))
    u = np.float32(52.0) * x * share - np.float32(13.0 * 0.197833)
    v = np.float32(117.0) * y * share - np.float32(13.0 * 0.468331)
    return np.int32(y * _LIGHTNESS_STEPS), u, v


@numba.njit(cache=True, error_model="numpy")
def _rough_chromaticities(
    rgb: Floats, luminance: NDArray[np.int32], u: Floats, v: Floats, shares: Floats, reciprocals: Bits
) -> None:
    """Do as `_chromaticity` does for one row, with rough reciprocals, and coefficients rounded as the original's."""
    width = shares.size
    for column in range(width):
        red, green, blue = rgb[0, column], rgb[1, column], rgb[2, column]
        x = _X[0] * red + _X[1] * green + _X[2] * blue
        y = _Y[0] * red + _Y[1] * green + _Y[2] * blue
        z = _Z[0] * red + _Z[1] * green + _Z[2] * blue
        shares[column] = x + (np.float32(1e-35) + (np.float32(15.0) * y + np.float32(3.0) * z))
        u[column], v[column] = x, y
    invert(shares, reciprocals)
    for column in range(width):
        x, y, share = u[column], v[column], shares[column]
        luminance[column] = np.int32(y * _LIGHTNESS_STEPS)
        u[column] = np.float32(52.0) * x * share - np.float32(13.0 * 0.197833)
        v[column] = np.float32(117.0) * y * share - np.float32(13.0 * 0.468331)
