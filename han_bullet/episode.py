"""The loop: simulator and stack take turns until the task ends; hooks look on."""

from __future__ import annotations

import contextlib
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

from han_bullet.messages import Observation, Status, Truth
from han_bullet.sim.simulator import Simulator
from han_bullet.stack import Decision, NavigationStack


@dataclass(frozen=True)
class Tick:
    """What a hook sees of one control period: known, decided, and (for metrics and pictures only) true."""

    observation: Observation
    decision: Decision
    truth: Truth


class Hook(ABC):
    """Something that looks at every tick: trace, video, metrics, ROS bridge."""

    def observe(self, observation: Observation) -> None:  # noqa: B027  (most hooks wait for the whole tick)
        """Take note of an observation on which the stack has not decided yet."""

    @abstractmethod
    def record(self, tick: Tick) -> None:
        """Take note of one tick."""

    def close(self) -> None:  # noqa: B027  (most hooks have nothing to finish)
        """Finish files; called once, also when the episode ends by an error."""


def run_episode(
    simulator: Simulator, stack: NavigationStack, *, duration: float, hooks: Sequence[Hook] = ()
) -> Decision:
    """Close the loop until the task ends or the time [s] is over; return the last decision.

    Hooks are closed in every case, so that what they wrote is whole.
    """
    with contextlib.ExitStack() as closing:
        for hook in hooks:
            closing.callback(hook.close)
        observation = simulator.reset()
        while True:
            for hook in hooks:
                hook.observe(observation)
            decision = stack.step(observation)
            tick = Tick(observation, decision, simulator.truth)
            for hook in hooks:
                hook.record(tick)
            arrived = decision.status is Status.ARRIVED
            if arrived or decision.gave_up is not None or observation.time >= duration:
                return decision
            simulator.request_hand_over(decision.asks_for_hand_over)
            simulator.request_way(decision.asks_to_make_way)
            observation = simulator.step(decision.command)
