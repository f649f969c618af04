"""The detector's stages on one image: channels, proposals, and what the CNN leaves [Mateus2019]."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.patches import Rectangle

from han_bullet.detection.acf import AcfDetector, load_acf_model
from han_bullet.detection.channels import CELL, Floats, compute_channels
from han_bullet.detection.cnn import load_classifier
from han_bullet.detection.colour import luv
from han_bullet.detection.pyramid import smooth
from han_bullet.messages import Detections, Frame
from han_bullet.report.charts import GREEN, ORANGE, VERMILION
from han_bullet.sim.renderer import InProcessRenderer
from han_bullet.sim.simulator import Simulator
from han_bullet.variation import vary
from han_bullet.world_file import load_world

WORLD, CAMERA, SEED = "sim2", "camera4", 0  # one of the rare images with a false proposal
CHANNEL_NAMES = ("L", "U", "V", "gradient", *(f"{angle}–{angle + 30}°" for angle in range(0, 180, 30)))


def draw_pipeline() -> Figure:
    """Draw one image of a camera, its ten channels, all proposals of ACF and what the CNN says of each."""
    frame = first_frame()
    model, classifier = load_acf_model(), load_classifier()
    proposals = AcfDetector(model).detect(frame.image)
    probabilities = classifier.probabilities(frame.image, proposals.boxes)
    judged = replace(proposals, probabilities=probabilities)
    threshold = model.score_threshold
    kept = probabilities >= classifier.least_probability
    figure = Figure(figsize=(9.0, 7.2), layout="constrained")
    (image, channels), (proposed, decided) = figure.subfigures(2, 2)
    _show(image.subplots(), frame, f"(a) image of {CAMERA}, {frame.image.shape[1]} × {frame.image.shape[0]} px")
    channels.suptitle(f"(b) ACF's channels, cells of {CELL} px", fontsize=9, x=0.02, ha="left")
    _draw_channels(channels, channels_of(frame))
    axes = proposed.subplots()
    _show(axes, frame, f"(c) ACF: {len(kept)} proposals with scores; dashed: below the threshold {threshold:.1f}")
    strong = judged.scores >= threshold
    for rows, style in ((strong, "-"), (~strong, "--")):
        _draw_boxes(axes, judged.select(rows), [f"{score:.0f}" for score in judged.scores[rows]], GREEN, style)
    axes = decided.subplots()
    _show(axes, frame, f"(d) CNN: {int(kept.sum())} pedestrians with their probability; dashed: none")
    for rows, colour, style in ((kept, ORANGE, "-"), (~kept, VERMILION, "--")):
        _draw_boxes(axes, judged.select(rows), [f"{share:.2f}" for share in probabilities[rows]], colour, style)
    return figure


def _draw_channels(figure: SubFigure, planes: Floats) -> None:
    """Draw each channel in shades of its own, from its least to nearly its largest value."""
    charts = figure.subplots(3, 4)
    for axes, name, plane in zip(charts.ravel(), CHANNEL_NAMES, np.moveaxis(planes, 2, 0), strict=False):
        axes.imshow(plane, cmap="gray", vmin=plane.min(), vmax=np.percentile(plane, 99.5))
        axes.set_title(name, pad=2.0, fontsize=8)
    for axes in charts.ravel():
        axes.set(xticks=[], yticks=[])
        axes.spines[:].set_visible(False)


def first_frame() -> Frame:
    """Return what the camera sees at the start of the world."""
    world = vary(load_world(WORLD), SEED)
    world = world.model_copy(update={"cameras": (world.camera(CAMERA),)})
    with contextlib.ExitStack() as closing:
        frames = InProcessRenderer(world, SEED)
        closing.callback(frames.close)
        simulator = Simulator(world, renderer=frames)
        closing.callback(simulator.close)
        (image,) = simulator.reset().images
    return image.placed(world.robot.start_pose_in_world)


def channels_of(frame: Frame) -> Floats:
    """Return the channels of an image at its own scale, smoothed, shape (h/4, w/4, 10)."""
    height, width = (size // CELL * CELL for size in frame.image.shape[:2])
    return smooth(compute_channels(luv(np.ascontiguousarray(frame.image[:height, :width]))))


def _show(axes: Axes, frame: Frame, title: str) -> None:
    axes.imshow(frame.image)
    axes.set(xticks=[], yticks=[])
    axes.set_title(title)


def _draw_boxes(axes: Axes, found: Detections, labels: Sequence[str], colour: str, style: str = "-") -> None:
    backing = {"facecolor": "white", "edgecolor": "none", "pad": 1.0, "alpha": 0.85}
    for (x, y, width, height), label in zip(found.boxes, labels, strict=True):
        axes.add_patch(Rectangle((x, y), width, height, fill=False, edgecolor=colour, linewidth=1.8, linestyle=style))
        axes.text(x, y - 4.0, label, fontsize=8, va="bottom", bbox=backing)
