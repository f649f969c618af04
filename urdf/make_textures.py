"""Make the pictures on floors, walls and furniture: seamless, small, the same at every run."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Array = NDArray[np.float64]
Size = tuple[int, int]


def noise(generator: np.random.Generator, size: Size, grain: Size) -> Array:
    """Return seamless smooth noise, mean 0, standard deviation 1; grain is the size of its blobs [px]."""
    white = np.fft.fft2(generator.standard_normal(size))
    rows, columns = np.fft.fftfreq(size[0])[:, None], np.fft.fftfreq(size[1])[None, :]
    smooth = np.fft.ifft2(white * np.exp(-2.0 * np.pi**2 * ((rows * grain[0]) ** 2 + (columns * grain[1]) ** 2))).real
    result: Array = (smooth - smooth.mean()) / smooth.std()
    return result


def tint(colour: tuple[float, float, float], shade: Array) -> Array:
    """Return a colour [grey levels] times one plus a shade, shape (h, w, 3)."""
    return np.array(colour) * (1.0 + shade[..., None])


def tiles(g: np.random.Generator) -> Array:
    """Return 3 x 3 stone tiles with narrow joints."""
    n, tile = 384, 128
    cells = np.kron(0.035 * g.standard_normal((3, 3)), np.ones((tile, tile)))
    picture = tint((158.0, 152.0, 142.0), cells + 0.02 * noise(g, (n, n), (12, 12)) + 0.012 * noise(g, (n, n), (1, 1)))
    edge = np.minimum(np.arange(n) % tile, tile - 1 - np.arange(n) % tile)
    joint = np.minimum(edge[:, None], edge[None, :]) < 2
    picture[joint] = np.array((128.0, 123.0, 115.0))
    return picture


def parquet(g: np.random.Generator) -> Array:
    """Return planks that lie along the picture's width, staggered."""
    n, plank = 512, 64
    picture = np.zeros((n, n, 3))
    for row in range(n // plank):
        grain = 0.05 * noise(g, (plank, n), (1, 40)) + 0.02 * noise(g, (plank, n), (1, 6))
        shift = int(g.integers(n))
        halves = np.where((np.arange(n) + shift) % n < n // 2, *(0.06 * g.standard_normal(2)))
        strip = tint((172.0, 128.0, 84.0), grain + halves[None, :])
        strip[0] *= 0.78
        strip[:, [(-shift) % n, (n // 2 - shift) % n]] *= 0.8
        picture[row * plank : (row + 1) * plank] = strip
    return picture


def plaster(g: np.random.Generator) -> Array:
    """Return off-white, lightly structured plaster."""
    n = 256
    return tint((226.0, 222.0, 212.0), 0.010 * noise(g, (n, n), (3, 3)) + 0.012 * noise(g, (n, n), (24, 24)))


def wood(g: np.random.Generator) -> Array:
    """Return brown wood, grain along the width."""
    n = 256
    shade = 0.07 * noise(g, (n, n), (2, 50)) + 0.03 * noise(g, (n, n), (1, 12))
    return tint((134.0, 92.0, 58.0), shade)


def fabric(g: np.random.Generator) -> Array:
    """Return a light woven cloth, to be tinted."""
    n = 256
    thread = np.cos(2.0 * np.pi * np.arange(n) / 8.0)
    weave = (
        0.03 * thread[:, None] * thread[None, :] + 0.02 * noise(g, (n, n), (1, 1)) + 0.02 * noise(g, (n, n), (20, 20))
    )
    return tint((205.0, 205.0, 205.0), weave)


def screen_on(g: np.random.Generator) -> Array:
    """Return what is on television: hills under an evening sky, with a caption bar."""
    height, width = 256, 448
    y, x = np.mgrid[0:height, 0:width] / (float(height), float(width))[0]
    sky = np.stack([90 + 150 * y, 120 + 70 * y, 200 - 60 * y], axis=-1)
    sun = np.exp(-(((x - 1.25) / 0.13) ** 2) - ((y - 0.45) / 0.13) ** 2)
    picture = sky + sun[..., None] * (140.0, 90.0, 10.0)
    for base, swing, colour in ((0.55, 0.08, (70, 100, 110)), (0.68, 0.06, (50, 110, 70)), (0.80, 0.05, (30, 75, 45))):
        ridge = base + swing * np.sin(2.0 * np.pi * (x[0] / g.uniform(0.7, 1.3) + g.uniform()))
        picture[y > ridge[None, :]] = colour
    picture[int(0.86 * height) : int(0.94 * height), 20 : width - 20] = (235.0, 235.0, 240.0)
    picture[int(0.86 * height) : int(0.94 * height), 20:80] = (200.0, 40.0, 40.0)
    return picture


PICTURES: dict[str, Callable[[np.random.Generator], Array]] = {
    "tiles": tiles,
    "parquet": parquet,
    "plaster": plaster,
    "wood": wood,
    "fabric": fabric,
    "screen_on": screen_on,
}


def main() -> None:
    """Write the pictures."""
    parser = argparse.ArgumentParser(description="Make the pictures on floors, walls and furniture.")
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parent, help="folder to write to")
    folder = parser.parse_args().out / "textures"
    folder.mkdir(parents=True, exist_ok=True)
    for number, (name, make) in enumerate(PICTURES.items()):
        picture = np.clip(make(np.random.default_rng(number)), 0.0, 255.0).astype(np.uint8)
        palette = Image.fromarray(picture).quantize(64, dither=Image.Dither.NONE)
        palette.convert("RGB").save(folder / f"{name}.png", optimize=True)
        print(f"{name}: {picture.shape[1]} x {picture.shape[0]} px")


if __name__ == "__main__":
    main()
