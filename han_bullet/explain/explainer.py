"""All answers for one time of a run."""

from __future__ import annotations

from pathlib import Path

from han_bullet.costmap.layers import STANDARD
from han_bullet.explain.boxes import explain_boxes
from han_bullet.explain.explanation import Explanation
from han_bullet.explain.people import explain_people
from han_bullet.explain.recorded_run import RecordedRun, read_run
from han_bullet.explain.replay import AGREEMENT, Replay, replay
from han_bullet.explain.way import WayReport
from han_bullet.provenance import git_commit


def explain_run(folder: Path, time: float) -> Explanation:
    """Tell of a run's people and way at a time [s].

    Args:
        folder: That `run_world` or `han-bullet run` left.
        time: Of the run; the last control tick at or before it is explained.

    Raises:
        BadInputError: The folder holds no run, lacks files, or the run has no such time.
    """
    return explain(replay(read_run(folder), time))


def explain(replayed: Replay) -> Explanation:
    """Tell of people and way at the end of a replay."""
    boxes = explain_boxes(replayed)
    people, strays = explain_people(replayed, boxes)
    owners = {person.track: person.name for person in people if person.track is not None}
    run = replayed.run
    return Explanation(
        run.world.name,
        run.result.seed,
        replayed.tick.truth.time,
        _warnings(replayed),
        replayed.difference if run.sees else None,
        people,
        strays,
        boxes,
        WayReport(replayed, owners).explain(),
        replayed.tick.decision.faults,
    )


def _warnings(replayed: Replay) -> tuple[str, ...]:
    run = replayed.run
    told = []
    if replayed.differs_since is not None:
        told.append(
            f"from {replayed.differs_since:.2f} s on the replay's tracks differ from tracks.csv by more than "
            f"{AGREEMENT:g} m: {_suspects(run)}"
        )
    known = {layer.name for layer in STANDARD}
    own = [name for name in run.result.layers if name not in known]
    if own:
        told.append(f"the run had layers of its own, which a replay lacks: {', '.join(own)}")
    return tuple(told)


def _suspects(run: RecordedRun) -> str:
    then, now = run.result.git_commit, git_commit()
    if then != now:
        return f"the run is of commit {then}, and this is {now}"
    return "its files or the code were edited since"
