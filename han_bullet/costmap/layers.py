"""The layers of the costmap, in order: the paper's eight, what the laser sees beyond the map, where walkers will be."""

from __future__ import annotations

import inspect
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from han_bullet.costmap.body import BodyLayer
from han_bullet.costmap.inflation import InflationLayer
from han_bullet.costmap.interaction import InteractionLayer
from han_bullet.costmap.layer import Layer
from han_bullet.costmap.obstacle import ObstacleLayer
from han_bullet.costmap.oncoming import OncomingLayer
from han_bullet.costmap.overtake import OvertakeLayer
from han_bullet.costmap.personal_still import PersonalStillLayer
from han_bullet.costmap.personal_walking import PersonalWalkingLayer
from han_bullet.costmap.static import StaticLayer
from han_bullet.costmap.visibility import VisibilityLayer
from han_bullet.errors import BadInputError
from han_bullet.geometry import SolidBox

STANDARD: tuple[type[Layer], ...] = (
    StaticLayer,
    ObstacleLayer,
    InflationLayer,
    BodyLayer,
    PersonalWalkingLayer,
    PersonalStillLayer,
    VisibilityLayer,
    InteractionLayer,
    OvertakeLayer,
    OncomingLayer,
)

SAFETY = ("static", "obstacle", "inflation", "body")  # what any robot needs; the other layers are social


def layers_meant(names: Iterable[str]) -> tuple[str, ...]:
    """Return the names of layers that words of the command line mean: "social" is all but safety's.

    Raises:
        BadInputError: A word that is neither.
    """
    known = [layer.name for layer in STANDARD]
    found: list[str] = []
    for name in names:
        if name != "social" and name not in known:
            raise BadInputError(
                f"layer {name!r} is not known; there are {', '.join(known)}, and social for all but safety"
            )
        found += [layer for layer in known if layer not in SAFETY] if name == "social" else [name]
    return tuple(dict.fromkeys(found))


def layer_parameters(layer: type[Layer]) -> dict[str, float]:
    """Return the numbers of a layer that a world's `layers:` section may set, with their defaults."""
    if layer in (StaticLayer, InflationLayer):
        return {}  # the robot and the `costmap:` section set theirs; with two places, one would win silently
    keywords = inspect.signature(layer.__init__).parameters.values()
    return {keyword.name: keyword.default for keyword in keywords if isinstance(keyword.default, float)}


def standard_layers(
    boxes: Sequence[SolidBox],
    *,
    robot_radius: float,
    robot_speed: float = 1.0,
    inflation_radius: float = 0.55,
    cost_scaling_factor: float = 10.0,
    pass_side: str = "left",
    without: Collection[str] = (),
    parameters: Mapping[str, Mapping[str, float]] | None = None,
) -> list[Layer]:
    """Build the standard layers.

    Args:
        boxes: Walls, furniture and devices.
        robot_radius: Of the footprint [m].
        robot_speed: The highest [m/s].
        inflation_radius: Where the cost of walls ends [m].
        cost_scaling_factor: Its decay [1/m].
        pass_side: On which side of a walking person the robot overtakes, "left" or "right".
        without: Names of layers to leave out.
        parameters: Layer -> parameter -> value, instead of the defaults; none for static and inflation.

    Raises:
        BadInputError: An unknown layer or parameter, or a value that its layer refuses.
    """
    chosen = {name: dict(values) for name, values in (parameters or {}).items()}
    _check_names(without, chosen)
    given: dict[str, dict[str, Any]] = {
        "static": {"boxes": boxes},
        "obstacle": {"robot_radius": robot_radius},
        "inflation": {
            "robot_radius": robot_radius,
            "inflation_radius": inflation_radius,
            "cost_scaling_factor": cost_scaling_factor,
        },
        "body": {"robot_radius": robot_radius},
        "overtake": {"pass_side": pass_side},
        "oncoming": {"robot_speed": robot_speed},
    }
    return [
        layer(**(given.get(layer.name, {}) | chosen.get(layer.name, {})))
        for layer in STANDARD
        if layer.name not in without
    ]


def _check_names(without: Collection[str], parameters: Mapping[str, Mapping[str, float]]) -> None:
    known = {layer.name: layer_parameters(layer) for layer in STANDARD}
    for name in [*without, *parameters]:
        if name not in known:
            raise BadInputError(f"layer {name!r} is not known; there are {', '.join(known)}")
    for name, values in parameters.items():
        for parameter, value in values.items():
            if name == InflationLayer.name:
                raise BadInputError(
                    f"layer inflation: {parameter!r} is {value!r} under layers; inflation_radius and "
                    "cost_scaling_factor are set in the costmap section alone"
                )
            if parameter not in known[name]:
                names = ", ".join(known[name]) or "none that a world may set"
                raise BadInputError(f"layer {name}: unknown parameter {parameter!r}; it has {names}")
