"""Rendered sequences with the true boxes of the people in them, for measuring detectors that never saw a rendering.

"corridor" is what a ceiling camera of the building's corridor sees, "MBOT" what the driving robot's camera sees,
"couch" a seated person before the camera above the television. Each is many short takes: people walk and stand at
random; outfits, builds, light and image noise are drawn anew for each. The same seed gives the same frames, bit for
bit.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass

import numpy as np

from han_bullet.geometry import Array, wrap_angle
from han_bullet.messages import Frame, Posture
from han_bullet.rendered_takes import Take, corridor_takes, couch_takes, onboard_takes
from han_bullet.sim.renderer import FrameSource, Image, Renderer
from han_bullet.sim.scene_state import SceneState
from han_bullet.sim.silhouette import Silhouette
from han_bullet.sim.simulator import Simulator

LEAST_HEIGHT = 110.0  # [px] of a person who counts; the smallest that the detector knows has 96
MOST_HIDDEN = 0.3
STEEPEST = math.radians(35.0)  # from above; the detector knows upright people
TAKE_FRAMES = 20  # 4 s
COUCH_TAKE_FRAMES = 4  # nothing moves there but the noise

Report = Callable[[int], None]
"""Called after each frame with how many there are."""


@dataclass(frozen=True)
class PersonInPicture:
    """A person of whom at least one pixel shows.

    Attributes:
        box: Tight around the body as far as it lies in the picture, hidden parts included: x, y, width, height, shape
            (4,) [px].
        cut: Whether the body reaches the picture's edge.
        hidden: Part of the body's pixels that something else covers.
        elevation: Of the camera as seen from the person's hips, above the horizontal [rad].
        facing: Direction the person faces relative to the direction to the camera, in [-pi, pi) [rad]; 0 looks at it.
        posture: Standing, walking or seated.
    """

    box: Array
    cut: bool
    hidden: float
    elevation: float
    facing: float
    posture: Posture

    @property
    def counts(self) -> bool:
        """Tell whether a detector should find this person: large, whole, hardly hidden, not seen steeply."""
        large = self.box[3] >= LEAST_HEIGHT
        return bool(large and not self.cut and self.hidden <= MOST_HIDDEN and self.elevation < STEEPEST)


@dataclass(frozen=True)
class RenderedFrame:
    """A picture and the people in it.

    Attributes:
        frame: As the stack gets it.
        people: All who show.
        empty: What this camera sees without people and robot, (h, w, 3) RGB, the same object for all frames of a take;
            None of a camera that moves.
        take: Number of the take, from 0.
    """

    frame: Frame
    people: tuple[PersonInPicture, ...]
    empty: Image | None
    take: int

    @property
    def image(self) -> Image:
        """Return the picture, (h, w, 3) RGB."""
        return self.frame.image

    @property
    def boxes(self) -> Array:
        """Return the boxes of the people who count, (n, 4): x, y, width, height [px]."""
        return _boxes(person for person in self.people if person.counts)

    @property
    def ignored(self) -> Array:
        """Return the boxes of those who do not, (m, 4) [px]: finding them is neither right nor wrong."""
        return _boxes(person for person in self.people if not person.counts)


def corridor(frames: int, seed: int, report: Report = lambda done: None) -> Iterator[RenderedFrame]:
    """Yield frames of the corridor's ceiling cameras.

    Args:
        frames: How many.
        seed: Of everything that is drawn.
        report: Called after each frame with how many there are.
    """
    return _frames(corridor_takes(seed), TAKE_FRAMES, frames, report)


def mbot(frames: int, seed: int, report: Report = lambda done: None) -> Iterator[RenderedFrame]:
    """Yield frames of the driving robot's camera; see `corridor`."""
    return _frames(onboard_takes(seed), TAKE_FRAMES, frames, report)


def couch(frames: int, seed: int, report: Report = lambda done: None) -> Iterator[RenderedFrame]:
    """Yield frames of a person on the couch by the camera above the television; see `corridor`."""
    return _frames(couch_takes(seed), COUCH_TAKE_FRAMES, frames, report)


def _frames(takes: Iterator[Take], take_frames: int, frames: int, report: Report) -> Iterator[RenderedFrame]:
    numbered = (frame for number, take in enumerate(takes) for frame in film(take, number, take_frames))
    for done, frame in enumerate(itertools.islice(numbered, frames), start=1):
        report(done)
        yield frame


def film(take: Take, number: int, count: int) -> Iterator[RenderedFrame]:
    """Yield the first frames of a take.

    Args:
        take: The scene.
        number: Given to its frames.
        count: How many frames.
    """
    source = _SilhouetteSource(Renderer(take.world, take.seed))
    empty = source.renderer.calibration_image(take.camera.name) if take.camera.fixed else None
    with closing(source.renderer), Simulator(take.world, renderer=source) as simulator:
        observation = simulator.reset()
        while count:
            robot = simulator.truth.pose_robot_in_world
            for frame in (image.placed(robot) for image in observation.images):
                yield RenderedFrame(frame, _people(simulator, source.silhouettes, frame), empty, number)
                count -= 1
            truth = simulator.truth
            observation = simulator.step(take.command(truth.pose_robot_in_world, truth.time))


class _SilhouetteSource(FrameSource):
    """Render in this process and keep what the last picture truly shows."""

    def __init__(self, renderer: Renderer) -> None:
        self.renderer = renderer
        self.silhouettes: tuple[Silhouette | None, ...] = ()

    def render(self, cameras: Sequence[str], state: SceneState) -> list[Image]:
        (camera,) = cameras
        image, self.silhouettes = self.renderer.render_with_people(camera, state)
        return [image]


def _people(
    simulator: Simulator, silhouettes: tuple[Silhouette | None, ...], frame: Frame
) -> tuple[PersonInPicture, ...]:
    """Join the true people, in the order of the world, with what the picture shows of them."""
    found = []
    people = zip(simulator.truth.people, simulator.render_state.people, silhouettes, strict=True)
    for person, body, silhouette in people:
        if silhouette is None or silhouette.hidden >= 1.0:
            continue
        pose = person.pose_in_world
        x, y, up = frame.camera_in_world[:3, 3] - (pose.x, pose.y, body.root_height)
        found.append(
            PersonInPicture(
                silhouette.box,
                silhouette.cut,
                silhouette.hidden,
                elevation=math.atan2(up, math.hypot(x, y)),
                facing=wrap_angle(pose.yaw - math.atan2(y, x)),
                posture=person.posture,
            )
        )
    return tuple(found)


def _boxes(people: Iterable[PersonInPicture]) -> Array:
    return np.array([person.box for person in people], float).reshape(-1, 4)
