"""How long the messages for rviz take per tick: made, and made and serialized.

Processor time of this thread, so that other programs count less. The ticks are those of a run with true perception, to
which five images with a box in each are added at 10 Hz.

Usage: python -m benchmarks.ros_messages [--world sim2] [--seconds 6]
"""

import argparse
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.provenance import provenance
from han_bullet.coverage import empty_image
from han_bullet.episode import Hook, Tick
from han_bullet.markdown import markdown_table
from han_bullet.messages import CameraImage, Detections
from han_bullet.ros.message_types import serialize
from han_bullet.ros.publications import Publications
from han_bullet.ros.topics import COSTMAP, COSTMAP_UPDATES, camera_topic
from han_bullet.runner import RunOptions, run_world
from han_bullet.world_file import load_world, save_world
from han_bullet.world_schema import World

BOX = Detections(np.array([[200.0, 120.0, 90.0, 220.0]]), np.array([50.0]), np.array([1.0]))


class Kept(Hook):
    """Keeps the ticks."""

    def __init__(self) -> None:
        self.ticks: list[Tick] = []

    def record(self, tick: Tick) -> None:
        """Keep one."""
        self.ticks.append(tick)


def ticks_of(world: World, seconds: float) -> list[Tick]:
    """Return the ticks of a run's beginning, with images."""
    kept = Kept()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "world.yaml"
        save_world(world.model_copy(update={"duration": seconds}), path, world.name)
        run_world(path, RunOptions(perception="truth", video=False), Path(folder) / "run", [kept])
    rng = np.random.default_rng(0)
    return [with_images(tick, world, rng) if k % 2 == 0 else tick for k, tick in enumerate(kept.ticks)]


def with_images(tick: Tick, world: World, rng: np.random.Generator) -> Tick:
    """Return a tick with an image of noise from each camera, and a box in each."""
    images: list[CameraImage] = []
    for camera in world.cameras:
        width, height = camera.size
        pixels = rng.integers(0, 256, (height, width, 3), dtype=np.uint8)
        images.append(replace(empty_image(camera, tick.observation.time), image=pixels))
    found = tuple(BOX.at(image.camera, image.time) for image in images)
    seen = replace(tick.observation, images=tuple(images))
    return replace(tick, observation=seen, decision=replace(tick.decision, detections=found))


def take(world: World, ticks: Sequence[Tick], wanted: Callable[[str], bool], sent: bool) -> tuple[float, float]:
    """Return mean and 95th percentile of a tick's processor time [ms], made alone or serialized, too."""
    publications, taken = Publications(world), []
    for tick in ticks:
        began = time.thread_time()
        for outgoing in publications.of(tick.observation, tick.decision, wanted):
            if sent:
                serialize(outgoing.message)
        taken.append(time.thread_time() - began)
    return 1e3 * float(np.mean(taken)), 1e3 * float(np.percentile(taken, 95))


def wants(world: World) -> dict[str, set[str]]:
    """Return what listeners of several kinds want."""
    cameras = [camera.name for camera in world.cameras]
    pictures = {camera_topic(name, what) for name in cameras for what in ("image_raw", "camera_info", "image_boxes")}
    layers = {topic.name for topic in Publications(world).topics if topic.name.endswith("/grid")}
    rest = {topic.name for topic in Publications(world).topics} - pictures - layers
    return {
        "nobody listens": set(),
        "all but images": rest,
        "with five raw images": rest | {camera_topic(name, "image_raw") for name in cameras},
        "with five images with boxes": rest | {camera_topic(name, "image_boxes") for name in cameras},
        "the costmap alone": {COSTMAP, COSTMAP_UPDATES},
    }


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--world", default="sim2", help="whose ticks (default: sim2)")
    parser.add_argument("--seconds", type=float, default=6.0, help="of the run (default: 6)")
    options = parser.parse_args()
    world = load_world(options.world)
    ticks = ticks_of(world, options.seconds)
    rows = []
    for name, topics in wants(world).items():
        take(world, ticks, topics.__contains__, sent=True)  # once, so that types and code are there
        made = take(world, ticks, topics.__contains__, sent=False)
        sent = take(world, ticks, topics.__contains__, sent=True)
        rows.append((name, *(f"{value:.2f}" for value in (*made, *sent))))
    headings = ("listeners", "made: mean [ms]", "95 % [ms]", "and serialized: mean [ms]", "95 % [ms]")
    print(f"{provenance()}; {options.world}, {len(ticks)} ticks\n")
    print(markdown_table(headings, rows))


if __name__ == "__main__":
    main()
