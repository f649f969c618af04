"""What became of each box of the cameras' last frames."""

from __future__ import annotations

from han_bullet.explain.explanation import DetectionExplained, Place
from han_bullet.explain.replay import Look, Replay
from han_bullet.explain.track_lives import lives, on_trial
from han_bullet.geometry import Array
from han_bullet.tracking.refusals import RefusalReasons
from han_bullet.tracking.track import TrackRecord


def explain_boxes(replay: Replay) -> tuple[DetectionExplained, ...]:
    """Return the boxes of every camera's last frame, in the order of the cameras."""
    reasons, records = RefusalReasons(replay.stack.projection), lives(replay)
    return tuple(box for look in replay.looks.values() for box in _of_frame(look, reasons, records))


def _of_frame(look: Look, reasons: RefusalReasons, records: tuple[TrackRecord, ...]) -> list[DetectionExplained]:
    frame, boxes, robot = look.scan.frame, look.found.boxes, look.scan.pose_robot_in_world
    rows = reasons.projection.known_rows(frame, boxes, look.found.feet, robot)
    feet = reasons.projection.foot_points(frame, boxes, rows).positions
    places = {int(row): _place(look.scan.positions[k]) for k, row in enumerate(look.scan.sources)}
    explained = []
    for row, refusal in enumerate(reasons.of(look.found, look.scan)):
        x, y, width, height = look.found.boxes[row].tolist()
        explained.append(
            DetectionExplained(
                look.scan.camera,
                look.scan.time,
                (x, y, width, height),
                float(look.found.scores[row]),
                _place(feet[row]),
                places.get(row),
                refusal or _taken_by(records, look, row),
            )
        )
    return explained


def _place(point: Array) -> Place:
    return float(point[0]), float(point[1])


def _taken_by(records: tuple[TrackRecord, ...], look: Look, row: int) -> str:
    """Tell which track a measurement fed; of one that has been absorbed since, the older one."""
    image = (look.scan.time, look.scan.camera, row)
    takers = [r for r in records if image in [(hit.time, hit.camera, hit.detection) for hit in r.recent_hits]]
    if not takers:
        return "taken by no track"
    taker = min(takers, key=lambda record: (record.ended_time is not None, record.id is None))
    return on_trial(taker) if taker.id is None else f"track {taker.id}"
