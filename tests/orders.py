"""An operator for tests: gives orders at times that a test names, and keeps what it saw."""

from collections.abc import Callable

from han_bullet.ablation import NoDetector, TrueLocalization, TruthTracker
from han_bullet.assembly import build_stack
from han_bullet.device_channel import DeviceChannel
from han_bullet.episode import Operator, run_episode
from han_bullet.messages import Truth
from han_bullet.sim.simulator import Simulator
from han_bullet.stack import Decision, NavigationStack
from han_bullet.world_schema import World

Act = Callable[[NavigationStack], object]


class Script(Operator):
    """Acts on the stack once the time of an act [s] has come, and stays on until the last time [s]."""

    def __init__(self, until: float, *acts: tuple[float, Act]) -> None:
        self._until, self._acts = until, list(acts)
        self.decisions: list[Decision] = []

    def add(self, time: float, act: Act) -> None:
        """Add an act after the others."""
        self._acts.append((time, act))

    def begin(self, world: World, stack: NavigationStack, channel: DeviceChannel) -> None:
        self.world, self.stack, self.channel = world, stack, channel

    def attend(self, decision: Decision) -> None:
        self.decisions.append(decision)
        while self._acts and decision.time >= self._acts[0][0] - 1e-9:
            self._acts.pop(0)[1](self.stack)

    def is_over(self, decision: Decision, duration: float) -> bool:
        return decision.time >= self._until - 1e-9

    def at(self, time: float) -> Decision:
        """The decision of a time [s]."""
        return next(decision for decision in self.decisions if decision.time >= time - 1e-9)


def episode(world: World, operator: Script) -> Truth:
    """Run a world with perfect perception under an operator; return how it ends."""
    with Simulator(world, renderer=None) as simulator:
        stack = build_stack(
            world,
            localization=TrueLocalization(lambda: simulator.truth),
            detector=NoDetector(),
            tracker=TruthTracker(lambda: simulator.truth, {}),
            sees=False,
        )
        run_episode(simulator, stack, duration=world.duration, operator=operator)
        return simulator.truth
