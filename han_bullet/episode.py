"""The loop: simulator and stack take turns until the task ends; hooks look on, an operator gives orders."""

from __future__ import annotations

import contextlib
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from han_bullet.device_channel import DeviceChannel
from han_bullet.messages import Observation, Truth
from han_bullet.stack import Decision, NavigationStack
from han_bullet.world_schema import World

if TYPE_CHECKING:  # hooks are also for real robots, which need no PyBullet
    from han_bullet.sim.simulator import Simulator


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


class Operator(ABC):
    """Somebody outside who gives the running robot orders; what they see is what the robot decides, never the truth."""

    def begin(self, world: World, stack: NavigationStack, channel: DeviceChannel) -> None:  # noqa: B027
        """Take note, before the first step, of who takes orders, and of the channel on which devices publish."""

    @abstractmethod
    def attend(self, decision: Decision) -> None:
        """Take note of a decision and give orders, if there are any, for the next one."""

    def is_over(self, decision: Decision, duration: float) -> bool:
        """Tell whether the episode is over; who stays on, past the task's end or the time [s], says no.

        With an order just given it goes on in any case: the next decision is the first to know of it.
        """
        return decision.ends_task or decision.time >= duration


class Nobody(Operator):
    """No operator: the world's task is all there is to do."""

    def attend(self, decision: Decision) -> None:
        """Say nothing."""


def run_episode(
    simulator: Simulator,
    stack: NavigationStack,
    *,
    duration: float,
    hooks: Sequence[Hook] = (),
    operator: Operator | None = None,
) -> Decision:
    """Close the loop until the task ends or the time [s] is over, or as the operator says; return the last decision.

    Hooks are closed in every case, so that what they wrote is whole.
    """
    operator = operator or Nobody()
    with contextlib.ExitStack() as closing:
        for hook in hooks:
            closing.callback(hook.close)
        observation = simulator.reset()
        operator.begin(simulator.world, stack, simulator.channel)
        while True:
            for hook in hooks:
                hook.observe(observation)
            decision = stack.step(observation)
            tick = Tick(observation, decision, simulator.truth)
            for hook in hooks:
                hook.record(tick)
            operator.attend(decision)
            if operator.is_over(decision, duration) and not stack.has_orders:
                return decision
            simulator.request_hand_over(decision.asks_for_hand_over)
            simulator.request_way(decision.asks_to_make_way)
            observation = simulator.step(decision.command)
