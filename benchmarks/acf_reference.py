"""How closely the ACF detector follows the original [Dollar2014], [Nam2014], and what scan limits save.

Usage: python -m benchmarks.acf_reference --data DIR --reference DIR

DIR of the data is laid out as docs/detector.md says. The reference holds what the original gives: channels, pyramid and
boxes of two pictures (photo, rendering: .png and .npz), and its boxes on the INRIA test photographs, as CSV.
"""

import argparse
import csv
import time
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.provenance import provenance
from han_bullet.detection.acf import AcfDetector, load_acf_model
from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.channels import compute_channels
from han_bullet.detection.colour import luv
from han_bullet.detection.evaluation import Evaluation, LabelledImage, judge
from han_bullet.detection.inria import load_test_photographs
from han_bullet.detection.overlap import intersection_over_union
from han_bullet.detection.pictures import read_picture
from han_bullet.detection.pyramid import build_pyramid
from han_bullet.detection.scan_limits import limits_on_floor
from han_bullet.geometry import Array, Intrinsics, look_at
from han_bullet.markdown import markdown_table
from han_bullet.world_file import load_world

PICTURES = ("photo", "rendering")
CHANNEL_NAMES = ("L", "U", "V", "magnitude", *(f"orientation {number}" for number in range(1, 7)))
MODELS = (("AcfInriaDetector", "inria_test_boxes"), ("LdcfInriaDetector", "inria_test_boxes_ldcf"))
SAME_OVERLAP, SAME_SCORE = 0.9, 2.0  # what counts as the same box
ROUNDS = 60  # of timing

Found = dict[str, tuple[Array, Array]]
"""Boxes and scores of each photograph by its name."""


def channel_rows(reference: Path, name: str, model: AcfModel) -> list[tuple[str, float, float]]:
    """Return each channel's mean difference at full scale and at the worst level, as shares of the channel's range."""
    expected = np.load(reference / f"{name}.npz")
    image = read_picture(reference / f"{name}.png")
    settings = replace(model.pyramid_settings, lambdas=tuple(expected["lambdas"]))
    full = _share(compute_channels(luv(image, True), rough=True), expected["channels"])
    levels = build_pyramid(image, settings)
    assert len(levels) == len(expected["scales"])
    worst = np.max([_share(level.channels, expected[f"pyramid_{n:02d}"]) for n, level in enumerate(levels)], axis=0)
    return list(zip(CHANNEL_NAMES, full.tolist(), worst.tolist(), strict=True))


def _share(ours: Array, expected: Array) -> Array:
    """Return the mean absolute difference of each channel, (10,), as a share of its range."""
    difference = np.abs(ours.transpose(2, 0, 1) - expected).mean(axis=(1, 2))
    return np.asarray(difference / np.ptp(expected, axis=(1, 2)))


def read_boxes(file: Path) -> Found:
    """Return the original's boxes."""
    rows = defaultdict(list)
    with file.open(encoding="utf-8") as lines:
        for row in csv.DictReader(lines):
            rows[row["image"]].append([float(row[key]) for key in ("x", "y", "width", "height", "score")])
    return {image: (np.array(boxes)[:, :4], np.array(boxes)[:, 4]) for image, boxes in rows.items()}


def evaluate_boxes(images: list[LabelledImage], found: Found) -> Evaluation:
    """Return the evaluation of boxes that are there already."""
    nothing = np.empty((0, 4)), np.empty(0)
    return Evaluation.of([judge(*found.get(image.path.name, nothing), image.boxes, image.ignored) for image in images])


def score_differences(expected: Found, ours: Found) -> Array:
    """Return how far the score of the most overlapping box of ours is from each of the original's; inf without one."""
    differences = []
    for image, (boxes, scores) in expected.items():
        own_boxes, own_scores = ours[image]
        if not len(own_boxes):
            differences.append(np.full(len(boxes), np.inf))
            continue
        overlaps = intersection_over_union(boxes, own_boxes)
        best = overlaps.argmax(axis=1)
        same = overlaps[np.arange(len(boxes)), best] >= SAME_OVERLAP
        differences.append(np.where(same, np.abs(own_scores[best] - scores), np.inf))
    return np.concatenate(differences)


def box_row(data: Path, images: list[LabelledImage], model: str, reference_file: Path) -> tuple[object, ...]:
    """Return a line of the table of boxes."""
    detector = AcfDetector(load_acf_model(data / "models" / f"{model}.mat"))
    ours, took = {}, []
    for labelled in images:
        image = read_picture(labelled.path)
        started = time.perf_counter()
        detections = detector.detect(image)
        took.append(time.perf_counter() - started)
        ours[labelled.path.name] = (detections.boxes, detections.scores)
    expected = read_boxes(reference_file)
    differences = score_differences(expected, ours)
    rates = [100 * evaluate_boxes(images, found).log_average_miss_rate() for found in (ours, expected)]
    return (
        model,
        sum(len(boxes) for boxes, _ in expected.values()),
        sum(len(boxes) for boxes, _ in ours.values()),
        f"{100 * np.mean(differences <= SAME_SCORE):.2f}",
        float(np.median(differences)),
        f"{rates[0]:.2f}",
        f"{rates[1]:.2f}",
        f"{1e3 * np.median(took):.1f}",
    )


def limit_rows(picture: Path) -> list[tuple[object, ...]]:
    """Return what a scan takes with and without the limits of the first ceiling camera of real2."""
    camera = load_world("real2").cameras[0]
    image = read_picture(picture)
    height, width = image.shape[:2]
    angle = np.radians(camera.vertical_field_of_view)
    intrinsics = Intrinsics.from_vertical_field_of_view(width, height, float(angle))
    limits = limits_on_floor(intrinsics, look_at(np.array(camera.position), np.array(camera.look_at)))
    detector = AcfDetector(load_acf_model())
    ways = {"none": None, f"of {camera.name}": limits}
    times: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(ROUNDS):
        for name, way in ways.items():
            started = time.perf_counter()
            detector.detect(image, way)
            times[name].append(1e3 * (time.perf_counter() - started))
    scans = {name: detector.scan(image, way) for name, way in ways.items()}
    return [
        (name, scan.windows, scan.trees, len(scan.boxes), min(times[name]), float(np.median(times[name])))
        for name, scan in scans.items()
    ]


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--reference", type=Path, required=True)
    options = parser.parse_args()
    print(f"### The ACF detector beside the original\n\n{provenance()}\n")
    original = load_acf_model(options.data / "models" / "AcfInriaDetector.mat")
    for name in PICTURES:
        print(f"Mean absolute difference of the channels of {name}.png, as a share of each channel's range:\n")
        rows = channel_rows(options.reference, name, original)
        print(markdown_table(("channel", "at full scale", "at the worst level of the pyramid"), rows) + "\n")
    images = load_test_photographs(options.data)
    print(
        f"Boxes on {len(images)} INRIA test photographs (rebuilt: about 2.5 % of their pixels were painted in); the "
        f"same box overlaps by {SAME_OVERLAP} and its score differs by {SAME_SCORE:.0f} at most:\n"
    )
    header = ("model", "boxes of the original", "ours", "same [%]", "median score difference")
    header = (*header, "miss rate [%]", "of the original's boxes [%]", "median [ms per photograph]")
    rows = [box_row(options.data, images, model, options.reference / f"{file}.csv") for model, file in MODELS]
    print(markdown_table(header, rows) + "\n")
    print(f"Our model on rendering.png with and without scan limits, {ROUNDS} rounds in turn:\n")
    header = ("limits", "windows", "trees", "windows that pass", "least [ms]", "median [ms]")
    print(markdown_table(header, limit_rows(options.reference / "rendering.png")))


if __name__ == "__main__":
    main()
