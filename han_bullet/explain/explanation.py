"""What an explanation says, as values; `people.py` and `way.py` make them, the command and the picture show them."""

from __future__ import annotations

from dataclasses import dataclass

from han_bullet.geometry import Array
from han_bullet.messages import Fault, RecoveryStep, Status

Place = tuple[float, float]


@dataclass(frozen=True)
class Sighting:
    """What the last frame of a camera had of a person.

    Attributes:
        camera: Name.
        time: Of the exposure [s]; None before the first frame.
        measured: Whether there was a box that became a measurement.
        text: What became of the box, or why there was none.
    """

    camera: str
    time: float | None
    measured: bool
    text: str


@dataclass(frozen=True)
class PersonExplained:
    """A true person and what the stack knew of them.

    Attributes:
        name: As in the world file.
        place: In the world [m].
        posture: The true one.
        track: Id, None where there is no track within `MATCH_WITHIN`.
        distance: To the track [m].
        sightings: One per camera.
        history: Where there is no track: what became of those that there were.
    """

    name: str
    place: Place
    posture: str
    track: int | None
    distance: float | None
    sightings: tuple[Sighting, ...]
    history: tuple[str, ...]


@dataclass(frozen=True)
class StrayExplained:
    """A track that stands for nobody, or for somebody who has another one.

    Attributes:
        track: Id.
        place: In the world [m].
        nearest: Name of the nearest true person and their distance [m]; None without people.
        text: Since when it lives, and what feeds it.
    """

    track: int
    place: Place
    nearest: tuple[str, float] | None
    text: str


@dataclass(frozen=True)
class DetectionExplained:
    """A box of a camera's last frame.

    Attributes:
        camera: Name.
        time: Of the exposure [s].
        box: x, y, width, height [px].
        score: Of the detector.
        foot_point: Of the person on the floor, whether or not it makes sense [m].
        measured: Where the tracker was told that the person is [m]; None where the box gave no measurement.
        text: Whom it fed, or why it gave no measurement.
    """

    camera: str
    time: float
    box: tuple[float, float, float, float]
    score: float
    foot_point: Place
    measured: Place | None
    text: str


@dataclass(frozen=True)
class Shift:
    """How far one way lies beside another; to the left is positive.

    Attributes:
        largest: Signed, with the largest amount [m].
        mean: Of the amounts [m].
        place: On the way, where it is largest [m].
    """

    largest: float
    mean: float
    place: Place


@dataclass(frozen=True)
class LayerEffect:
    """What a layer does to the way.

    Attributes:
        layer: Name.
        way: Best one without the layer, shape (n, 2) [m]; None where there is none.
        length: Of that way [m].
        cost_of_way: What the way with all layers costs where this one is missing.
        cost_without: What `way` costs where this layer is missing.
        cost_if_ignored: What `way` costs with all layers.
        shift: Of the way with all layers against `way`; None where one of them is missing.
        dearest: Where the layer raises the costs most along `way` [m], and by how much [1 of 252]; None: nowhere.
        causes: Tracks and devices that are behind that, in words.
        sides: True person whom `way` passes -> on which side of it they are, "left" or "right".
    """

    layer: str
    way: Array | None
    length: float
    cost_of_way: float
    cost_without: float
    cost_if_ignored: float
    shift: Shift | None
    dearest: tuple[Place, int] | None
    causes: tuple[str, ...]
    sides: dict[str, str]


@dataclass(frozen=True)
class WayExplained:
    """The way at some time and what each layer does to it.

    Attributes:
        status: What the robot was up to.
        step: Since when [s] it tried what, as it could not go on; None where it could.
        taken_cost: Of the way that the robot was on, on the costmap of that time; infinite where it had none.
        best: The best one of that time; the robot keeps an older one while that is hardly dearer.
        best_cost: Its cost.
        best_length: [m].
        kept_shift: Of the way taken against the best one.
        sides: True person whom the best way passes -> on which side of it they are.
        layers: Effects, in the order of the layers.
        has_task: Whether the robot had anywhere to go.
    """

    status: Status
    step: tuple[float, RecoveryStep] | None
    taken_cost: float
    best: Array | None
    best_cost: float
    best_length: float
    kept_shift: Shift | None
    sides: dict[str, str]
    layers: tuple[LayerEffect, ...]
    has_task: bool = True


@dataclass(frozen=True)
class Explanation:
    """All answers for one time of a run.

    Attributes:
        world: Name.
        seed: Of the run.
        time: Of the tick explained [s].
        warnings: Where the replay or the files do not agree; sentences.
        difference: Largest between replayed and recorded tracks [m], [m/s]; None with true perception, where the tracks
            are the recorded ones.
        people: The true ones.
        strays: Tracks of nobody.
        detections: Of the cameras' last frames.
        way: Where the robot goes, and why.
        faults: What the robot knew to be wrong with its cameras and devices.
    """

    world: str
    seed: int
    time: float
    warnings: tuple[str, ...]
    difference: float | None
    people: tuple[PersonExplained, ...]
    strays: tuple[StrayExplained, ...]
    detections: tuple[DetectionExplained, ...]
    way: WayExplained
    faults: tuple[Fault, ...] = ()
