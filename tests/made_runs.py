"""Runs made up in memory, for tests of explanations: a standing robot, people where one wants them, boxes at will."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from han_bullet.costmap.layers import STANDARD
from han_bullet.coverage import empty_frame
from han_bullet.device_channel import SIMULATED
from han_bullet.explain.recorded_run import RecordedRun
from han_bullet.explain.recorded_tables import FrameRow
from han_bullet.explain.replay import Replay, replay
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.messages import Detections, Odometry, PoseEstimate, Posture, TruePerson, Truth
from han_bullet.run_folder import ResultFile
from han_bullet.tracking.sight import expected_box
from han_bullet.world_file import load_world, parse_world
from han_bullet.world_schema import CONTROL_PERIOD, World

Place = tuple[float, float]
RESULT: dict[str, Any] = {
    "world": "made",
    "world_sha256": "",
    "perception": "cameras",
    "association": "nnjpda",
    "layers": [layer.name for layer in STANDARD],
    "pass": "left",
    "seed": 0,
    "localization": "simulator",
    "device_session": SIMULATED,
    "git_commit": "0123",
    "cameras": [],
    "detector": None,
    "mirrored": False,
    "scaled": [],
    "versions": {},
    "outcome": "timeout",
    "outcome_detail": None,
    "metrics": [],
    "checks": [],
    "timings": {},
}


def corridor(*names: str) -> World:
    """Return real2 with standing people of these names."""
    document = load_world("real2").model_dump(mode="json")
    document["people"] = [{"name": name, "start": [5.0 + k, 0.0, 0.0]} for k, name in enumerate(names)]
    document["expectations"] = []
    return parse_world(document)


def made_run(
    people: dict[str, Place],
    ticks: int,
    boxes: Callable[[str, float], Sequence[Place]],
    robot: Place = (1.5, 0.0),
) -> RecordedRun:
    """Return a run in which the detector gave each camera the boxes of upright people at places of one's choice.

    Args:
        people: Name -> true place [m].
        ticks: How many.
        boxes: Camera and time [s] -> places [m].
        robot: Where it stands [m].
    """
    world = corridor(*people)
    pose = Pose2D(*robot, 0.0)
    bodies = tuple(TruePerson(n, Pose2D(*p, 0.0), np.zeros(2), Posture.STANDING) for n, p in people.items())
    truths = tuple(Truth(k * CONTROL_PERIOD, pose, Twist2D(), bodies) for k in range(ticks))
    found: dict[tuple[int, str], Detections] = {}
    frames = {k: [FrameRow(c.name, k * CONTROL_PERIOD) for c in world.cameras] for k in range(0, ticks, 2)}
    for k in range(0, ticks, 2):
        for camera in world.cameras:
            frame = empty_frame(camera, pose, k * CONTROL_PERIOD)
            rows = [expected_box(frame, np.array(place)) for place in boxes(camera.name, k * CONTROL_PERIOD)]
            if rows:
                found[k, camera.name] = Detections(np.array(rows), np.full(len(rows), 50.0), np.ones(len(rows)))
    poses = {k: PoseEstimate(truth.time, pose) for k, truth in enumerate(truths)}
    odometry = {k: Odometry(truth.time, Pose2D(0.0, 0.0, 0.0), Twist2D()) for k, truth in enumerate(truths)}
    return RecordedRun(
        folder=Path("made"),
        world=world,
        result=ResultFile.model_validate(RESULT),
        truths=truths,
        poses=poses,
        odometry=odometry,
        commands=dict.fromkeys(odometry, Twist2D()),
        scans={},
        frames=frames,
        detections=found,
        legs={},
        messages={},
        tracks={},
        doings=(),
    )


def replayed(run: RecordedRun) -> Replay:
    """Return the replay up to the end."""
    return replay(run, run.truths[-1].time)
