"""The comparison with the original, on a reference made with our own code."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from bars import bar_model

from benchmarks.acf_reference import channel_rows
from han_bullet.detection.channels import compute_channels
from han_bullet.detection.colour import luv
from han_bullet.detection.pictures import read_picture
from han_bullet.detection.pyramid import build_pyramid


def test_the_pyramid_is_compared_at_the_sizes_of_the_model_that_the_reference_is_of(tmp_path: Path) -> None:
    picture = np.random.default_rng(0).integers(0, 256, (140, 140, 3), dtype=np.uint8)
    assert cv2.imwrite(str(tmp_path / "photo.png"), picture)
    image = read_picture(tmp_path / "photo.png")
    models = [replace(bar_model(), rough=True, person_height=h, person_width=w) for h, w in ((100, 41), (96, 39))]
    right, other = (build_pyramid(image, model.pyramid_settings) for model in models)
    assert (len(right), len(other)) == (4, 5)
    planes = {f"pyramid_{n:02d}": level.channels.transpose(2, 0, 1) for n, level in enumerate(right)}
    planes["channels"] = compute_channels(luv(image, True), rough=True).transpose(2, 0, 1)
    scales = np.zeros(len(right))
    np.savez(tmp_path / "photo.npz", lambdas=models[0].lambdas, scales=scales, **planes)
    rows = channel_rows(tmp_path, "photo", models[0])
    assert len(rows) == 10
    assert [row[1:] for row in rows] == 10 * [pytest.approx((0.0, 0.0), abs=1e-7)]
