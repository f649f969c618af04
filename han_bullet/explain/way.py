"""Which layer moved the way? The way planned again on costmaps from which one layer is missing."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from han_bullet.assembly import build_planner
from han_bullet.costmap.grid import Costmap
from han_bullet.costmap.layer import Layer
from han_bullet.explain.beside import length_of, resampled, shift_between, side_of
from han_bullet.explain.explanation import LayerEffect, WayExplained
from han_bullet.explain.replay import Replay
from han_bullet.geometry import Array
from han_bullet.messages import Scene
from han_bullet.planning.planner import survey

# A way that is dearer by no more than this part is as good: ties between ways are nobody's doing.
AS_GOOD = 1e-6


class WayReport:
    """Plans again with all layers, and with each left out in turn.

    Args:
        replay: Up to the time in question.
        owners: Track id -> name of the true person whom it stands for.
    """

    def __init__(self, replay: Replay, owners: Mapping[int, str]) -> None:
        self._owners = owners
        self._stack, self._tick = replay.stack, replay.tick
        self._step = replay.run.step_at(replay.tick.truth.time)
        self._world = replay.run.world
        self._weight = self._world.costmap.astar_weight
        self._scene = replay.tick.decision.scene
        self._goal = replay.stack.situation.goal()
        self._costmap = replay.tick.decision.costmap
        self._best = self._plan(self._costmap)

    def explain(self) -> WayExplained:
        """Return everything about the way."""
        path = self._tick.decision.path
        taken = None if path is None else path.points_in_world
        return WayExplained(
            self._tick.decision.status,
            self._step,
            self._cost(self._costmap, taken),
            self._best,
            self._cost(self._costmap, self._best),
            length_of(self._best),
            shift_between(taken, self._best),
            self._sides(self._best),
            () if self._goal is None else tuple(self._effect(layer) for layer in self._stack.layers),
            self._goal is not None,
        )

    def _effect(self, layer: Layer) -> LayerEffect:
        others = [other for other in self._stack.layers if other is not layer]
        without = self._map_of(others, self._scene)
        way = self._plan(without)
        cost_of_way, cost_without = self._cost(without, self._best), self._cost(without, way)
        if self._best is not None and way is not None and cost_of_way <= (1.0 + AS_GOOD) * cost_without:
            way, cost_without = self._best, cost_of_way
        dearest = self._dearest(without, way)
        return LayerEffect(
            layer.name,
            way,
            length_of(way),
            cost_of_way,
            cost_without,
            self._cost(self._costmap, way),
            shift_between(self._best, way),
            dearest,
            () if dearest is None else self._causes(layer, np.array(dearest[0])),
            self._sides(way),
        )

    def _map_of(self, layers: Sequence[Layer], scene: Scene) -> Costmap:
        costmap = self._stack.free_space.copy()
        for layer in layers:
            layer.apply(costmap, scene)
        return costmap

    def _plan(self, costmap: Costmap) -> Array | None:
        """Return the best way, as a planner finds it that is on none yet."""
        decision, start = self._tick.decision, self._tick.decision.estimate.pose_robot_in_world.position
        if self._goal is None:
            return None
        planner = build_planner(self._world, self._stack.layers)
        path = planner.update(costmap, start, self._goal.position, decision.time, True, decision.people)
        return None if path is None else path.points_in_world

    def _cost(self, costmap: Costmap, way: Array | None) -> float:
        return np.inf if way is None else survey(costmap, way, self._weight)[0]

    def _sides(self, way: Array | None) -> dict[str, str]:
        sides = {p.name: side_of(way, p.pose_in_world.position) for p in self._tick.truth.people}
        return {name: side for name, side in sides.items() if side is not None}

    def _dearest(self, without: Costmap, way: Array | None) -> tuple[tuple[float, float], int] | None:
        """Return where along a way the missing layer would raise the costs most."""
        if way is None:
            return None
        points = resampled(way)
        rise = self._costmap.cost_at(points).astype(int) - without.cost_at(points)
        at = int(rise.argmax())
        return ((float(points[at, 0]), float(points[at, 1])), int(rise[at])) if rise[at] > 0 else None

    def _causes(self, layer: Layer, place: Array) -> tuple[str, ...]:
        """Return who makes a layer raise the costs at a place, (2,) [m]: the track that does most, its devices."""
        nobody = self._alone(layer, dataclasses.replace(self._scene, people=()), place)
        scenes = {person.id: dataclasses.replace(self._scene, people=(person,)) for person in self._scene.people}
        costs = {track: self._alone(layer, scene, place) for track, scene in scenes.items()}
        track = max(costs, key=lambda one: costs[one], default=None)
        if track is None or costs[track] <= nobody:
            return ()
        causes = [f"track {track} ({self._owners.get(track, 'nobody')})"]
        for device in self._scene.devices:
            others = tuple(other for other in self._scene.devices if other is not device)
            if self._alone(layer, dataclasses.replace(scenes[track], devices=others), place) < costs[track]:
                causes.append(device.name)
        return tuple(causes)

    def _alone(self, layer: Layer, scene: Scene, place: Array) -> int:
        """Return what a layer alone makes of a free place."""
        costmap = self._stack.free_space.copy()
        layer.apply(costmap, scene)
        return int(costmap.cost_at(place))
