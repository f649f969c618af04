"""A little world, its cameras calibrated by the solver, and a configuration that names them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from han_bullet.calibration.picture import write_picture
from han_bullet.calibration.points import MarkedPoints
from han_bullet.calibration.solve import solve
from han_bullet.geometry import project
from han_bullet.sim.renderer import Renderer
from han_bullet.world_file import load_world
from han_bullet.world_schema import CeilingCamera

WORLD = """\
name: live_passage
description: Corridor; somebody stands in the way of a robot that knows of them only through cameras and laser
extends: building
cameras:
  - {name: camera1, kind: ceiling, position: [0.2, 0.0, 2.6], look_at: [6.2, 0.0, 0.9], rate: 5}
  - {name: camera2, kind: ceiling, position: [9.5, 0.0, 2.6], look_at: [3.5, 0.0, 0.9], rate: 5}
people:
  - {name: bystander, start: [4.0, -0.2, 3.0]}
robot: {start: [1.5, 0.0, 0.0]}
task: {kind: go_to, pose: [6.0, 0.0, 0.0]}
duration: 60.0
"""
CONFIG = """\
world: world.yaml
cameras:
  - {name: camera1, topic: /camera1/image_raw, calibration: camera1.yaml, empty_scene: camera1.png, rate: 5}
  - {name: camera2, topic: /camera2/image_raw, calibration: camera2.yaml, empty_scene: camera2.png, rate: 5}
laser: {topic: /scan}
localization: lidar
"""
CLICK = 0.5  # [px] by which marked points are off


def write_live_robot(folder: Path, config: str = CONFIG) -> Path:
    """Write world, calibrations, empty scenes and configuration; return the last's path.

    The calibrations are solved, focal length and all, from floor points that were marked by an unsteady hand.
    """
    (folder / "world.yaml").write_text(WORLD)
    world, generator = load_world(folder / "world.yaml"), np.random.default_rng(0)
    renderer = Renderer(world, seed=1)
    for camera in world.cameras:
        assert isinstance(camera, CeilingCamera)
        x, y = map(np.ravel, np.meshgrid(np.arange(0.5, 9.5), [-1.2, 0.0, 1.2]))
        floor = np.column_stack([x, y, np.zeros(len(x))])
        pixels, depths = project(floor, camera.intrinsics, camera.camera_in_world)
        shown = (depths > 0.1) & (pixels > 0.0).all(axis=1) & (pixels < camera.size).all(axis=1)
        marked = np.clip(pixels[shown] + generator.normal(0.0, CLICK, (shown.sum(), 2)), 0.0, camera.size)
        solution = solve(MarkedPoints(marked, floor[shown]), camera.size, name=camera.name)
        solution.calibration.save(folder / f"{camera.name}.yaml", "of a test")
        write_picture(renderer.calibration_image(camera.name), folder / f"{camera.name}.png")
    renderer.close()
    path = folder / "robot.yaml"
    path.write_text(config)
    return path
