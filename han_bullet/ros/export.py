"""A recorded run as a bag: what the robot would have published on ROS while it ran."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from han_bullet.episode import Tick
from han_bullet.explain.recorded_run import RecordedRun
from han_bullet.explain.replay import decide_again, recorded_observation, recorded_stack
from han_bullet.messages import RecoveryStep
from han_bullet.ros.bag import open_bag
from han_bullet.ros.pictures_again import PicturesAgain
from han_bullet.ros.publications import Publications
from han_bullet.stack import Decision, NavigationStack


@dataclass(frozen=True)
class Exported:
    """What an export came to.

    Attributes:
        duration: Of the run [s].
        counts: Topic -> its messages.
        size: Of the file [bytes].
    """

    duration: float
    counts: Mapping[str, int]
    size: int


def export(
    run: RecordedRun,
    path: Path,
    *,
    mcap: bool = False,
    images: bool = False,
    progress: Callable[[float], None] = lambda time: None,
) -> Exported:
    """Write a run to a file.

    Args:
        run: The run.
        path: Of the file; another one there is replaced when this one is finished.
        mcap: Whether to write MCAP for Foxglove rather than a ROS 1 bag.
        images: Whether to take the cameras' pictures again.
        progress: Is told the time of the run that has been reached [s].

    Raises:
        BadInputError: The run had no cameras, but images are wanted; or the packages that write the file are missing.
        HanError: A picture does not come out as it was.
    """
    stack = recorded_stack(run)
    publications = Publications(run.world, [layer.name for layer in stack.layers])
    publications.watch_layers(stack)
    path.parent.mkdir(parents=True, exist_ok=True)
    with (
        contextlib.closing(_ticks(run, stack, images=images)) as ticks,
        open_bag(path, publications.topics, mcap=mcap) as bag,
    ):
        for outgoing in publications.statics():
            bag.write(outgoing.topic, 0.0, outgoing.message)
        for tick in ticks:
            for outgoing in publications.of(tick.observation, tick.decision, wanted=lambda _: True):
                bag.write(outgoing.topic, tick.observation.time, outgoing.message)
            progress(tick.observation.time)
    return Exported(run.truths[-1].time, bag.counts, path.stat().st_size)


def _ticks(run: RecordedRun, stack: NavigationStack, *, images: bool) -> Generator[Tick, None, None]:
    """Replay a run tick by tick; its commands, the faults it noticed and why it gave up are the record's."""
    with contextlib.ExitStack() as closing:
        pictures = closing.enter_context(PicturesAgain(run)) if images else None
        decision: Decision | None = None
        for number, truth in enumerate(run.truths):
            observation = recorded_observation(run, number)
            if pictures is not None:
                observation = replace(observation, images=pictures.after(decision))
            decided = decide_again(run, stack, observation)
            gave_up = run.result.outcome_detail if decided.step is RecoveryStep.GIVE_UP else None
            decision = replace(decided, command=run.commands[number], faults=run.faults_at(truth.time), gave_up=gave_up)
            yield Tick(observation, decision, truth)
