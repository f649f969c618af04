"""How long each stage of the stack takes, by the wall clock: what no result depends on."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import Any

from han_bullet.stack import NavigationStack

KEPT = 40  # of the last calls, 2 s of ticks
STAGES = {
    "localization": "update",
    "detector": "detect",
    "projection": "project",
    "leg_finder": "find",
    "tracker": "update",
    "situation": "update",
    "planner": "update",
    "follower": "follow",
    "protective_stop": "limit",
}


class StageTimes:
    """The last durations of each stage.

    Args:
        clock: Returns the time [s].
    """

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._taken: dict[str, deque[float]] = {}  # [s]
        self._begun: deque[float] = deque(maxlen=KEPT)  # ticks [s]

    def watch(self, stack: NavigationStack) -> None:
        """Measure a stack's stages from now on; each stays the object that it is, only its method is timed."""
        for name, method in STAGES.items():
            stage = getattr(stack, name)
            setattr(stage, method, self._timed(name, getattr(stage, method)))
        for layer in stack.layers:
            setattr(layer, "apply", self._timed(f"layer {layer.name}", layer.apply))  # noqa: B010
        step = self._timed("step", stack.step)
        setattr(stack, "step", self._counted(step))  # noqa: B010  (mypy lets nobody assign to a method)

    @property
    def mean(self) -> dict[str, float]:
        """Return stage -> mean duration of the last calls [s]; "step" is the whole tick."""
        return {name: sum(taken) / len(taken) for name, taken in self._taken.items()}

    @property
    def rate(self) -> float | None:
        """Return ticks per second by the clock; None before the second."""
        passed = self._begun[-1] - self._begun[0] if len(self._begun) > 1 else 0.0
        return (len(self._begun) - 1) / passed if passed > 0.0 else None

    def _timed(self, name: str, method: Callable[..., Any]) -> Callable[..., Any]:
        def timed(*arguments: Any, **keywords: Any) -> Any:
            began = self._clock()
            result = method(*arguments, **keywords)
            self._taken.setdefault(name, deque(maxlen=KEPT)).append(self._clock() - began)
            return result

        return timed

    def _counted(self, method: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*arguments: Any) -> Any:
            self._begun.append(self._clock())
            return method(*arguments)

        return counted
