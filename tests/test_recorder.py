import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from ticks import found, frame, make_world, person, tick, track

from han_bullet.device_payload import write_payload
from han_bullet.episode import Hook, Tick
from han_bullet.geometry import Twist2D
from han_bullet.messages import Detections, DeviceMessage, FrameDetections, ImageHealth, LegScan, RecoveryStep, Status
from han_bullet.recorder import (
    CommandsRecorder,
    DetectionsRecorder,
    EmptySeatsRecorder,
    FeetRecorder,
    FramesRecorder,
    LegsRecorder,
    MessagesRecorder,
    OdometryRecorder,
    PosesRecorder,
    StatusRecorder,
    TraceRecorder,
    TracksRecorder,
)

IMAGE = frame(time=0.05)
TICKS = (
    tick(0, robot=(1.0, -0.5, math.pi), people=[person("anna", 5.0, -0.2, 0.0), person("bob", 9.0, 1.0, 1.5, 0.35)]),
    tick(
        1,
        robot=(1.05, -0.5, 3.0),
        twist=(0.25, -0.125, 0.1),
        people=[person("anna", 5.0, -0.2, 0.0, posture="seated"), person("bob", 9.0, 1.0, 1.5, 0.35)],
        tracks=[track(0, 5.125, -0.25), track(4, 9.0, 1.0, velocity=(0.3, 0.0), heading=-1.5, posture="walking")],
        frames=[IMAGE],
        detections=[found(IMAGE, (10.5, 20.0, 41.0, 100.0), score=62.5, probability=0.875)],
    ),
)


def write(hook: Hook, ticks: tuple[Tick, ...] = TICKS) -> None:
    for one in ticks:
        hook.record(one)
    hook.close()


def test_the_trace_has_a_row_per_tick_with_robot_and_people(tmp_path: Path):
    write(TraceRecorder(tmp_path / "trace.csv", make_world("anna", "bob")))
    assert (tmp_path / "trace.csv").read_text().splitlines() == [
        "time,robot.x,robot.y,robot.yaw,robot.vx,robot.vy,robot.omega,"
        "anna.x,anna.y,anna.yaw,anna.posture,bob.x,bob.y,bob.yaw,bob.posture",
        "0.000000,1.000000,-0.500000,3.141593,0.000000,0.000000,0.000000,"
        "5.000000,-0.200000,0.000000,standing,9.000000,1.000000,1.500000,walking",
        "0.050000,1.050000,-0.500000,3.000000,0.250000,-0.125000,0.100000,"
        "5.000000,-0.200000,0.000000,seated,9.000000,1.000000,1.500000,walking",
    ]


def test_odometry_and_commands_have_a_row_per_tick_commands_with_all_digits(tmp_path: Path):
    write(OdometryRecorder(tmp_path / "odometry.csv"))
    command = Twist2D(0.1 + 0.2, -0.0, 1 / 3)
    commanded = tuple(replace(one, decision=replace(one.decision, command=command)) for one in TICKS)
    write(CommandsRecorder(tmp_path / "commands.csv"), commanded)
    assert (tmp_path / "odometry.csv").read_text().splitlines() == [
        "time,x,y,yaw,vx,vy,omega",
        "0.000000,1.000000,-0.500000,3.141593,0.000000,0.000000,0.000000",
        "0.050000,1.050000,-0.500000,3.000000,0.250000,-0.125000,0.100000",
    ]
    assert (tmp_path / "commands.csv").read_text().splitlines() == [
        "time,vx,vy,omega",
        "0.000000,0.30000000000000004,-0.0,0.3333333333333333",
        "0.050000,0.30000000000000004,-0.0,0.3333333333333333",
    ]


def test_poses_have_the_upper_triangle_of_their_covariance(tmp_path: Path):
    covariance = np.array([[4e-4, 1e-6, -2e-7], [1e-6, 9e-4, 3e-8], [-2e-7, 3e-8, 1e-9]])
    (one, *_) = TICKS
    estimate = replace(one.decision.estimate, covariance=covariance, lost=True)
    write(PosesRecorder(tmp_path / "poses.csv"), (replace(one, decision=replace(one.decision, estimate=estimate)),))
    assert (tmp_path / "poses.csv").read_text().splitlines() == [
        "time,x,y,yaw,lost,xx,xy,xyaw,yy,yyaw,yawyaw",
        "0.000000,1.000000,-0.500000,3.141593,1,"
        "0.000400000,0.000001000,-0.000000200,0.000900000,0.000000030,0.000000001",
    ]


def test_the_status_has_a_row_per_change_with_the_recoverys_step(tmp_path: Path):
    ticks = (
        tick(0, status=Status.WAITING, step=RecoveryStep.WAIT),
        tick(1, status=Status.WAITING, step=RecoveryStep.WAIT),
        tick(2, status=Status.WAITING, step=RecoveryStep.ASK),
        tick(3, status=Status.MOVING, step=RecoveryStep.ASK),
        tick(4, status=Status.MOVING),
    )
    write(StatusRecorder(tmp_path / "status.csv"), ticks)
    assert (tmp_path / "status.csv").read_text().splitlines() == [
        "time,status,step",
        "0.000000,waiting,wait",
        "0.100000,waiting,ask",
        "0.150000,moving,ask",
        "0.200000,moving,",
    ]


def test_tracks_have_a_row_each_and_an_unknown_yaw_is_empty(tmp_path: Path):
    write(TracksRecorder(tmp_path / "tracks.csv"))
    assert (tmp_path / "tracks.csv").read_text().splitlines() == [
        "time,id,x,y,vx,vy,yaw,posture",
        "0.050000,0,5.125000,-0.250000,0.000000,0.000000,,standing",
        "0.050000,4,9.000000,1.000000,0.300000,0.000000,-1.500000,walking",
    ]


def test_detections_have_a_row_per_box_with_the_time_of_exposure(tmp_path: Path):
    write(DetectionsRecorder(tmp_path / "detections.csv"))
    assert (tmp_path / "detections.csv").read_text().splitlines() == [
        "time,camera,x,y,width,height,score,probability",
        "0.050000,ceiling,10.500000,20.000000,41.000000,100.000000,62.500000,0.875000",
    ]


def test_known_feet_have_a_row_each_with_the_number_of_their_box(tmp_path: Path):
    one, boxes = TICKS[1], np.zeros((3, 4))
    known = FrameDetections(boxes, np.ones(3), np.ones(3), "ceiling", 0.05, feet=np.array([np.nan, 412.0, np.nan]))
    unknown = FrameDetections(boxes, np.ones(3), np.ones(3), "onboard", 0.05)
    write(
        FeetRecorder(tmp_path / "feet.csv"),
        (replace(one, decision=replace(one.decision, detections=(known, unknown))),),
    )
    assert (tmp_path / "feet.csv").read_text().splitlines() == [
        "time,camera,detection,row",
        "0.050000,ceiling,1,412.000000",
    ]


def test_seats_seen_empty_have_a_row_each_with_their_frame(tmp_path: Path):
    one = TICKS[1]
    shown = replace(Detections.none(), empty_seats=("couch", "chair")).at("ceiling", 0.05)
    write(
        EmptySeatsRecorder(tmp_path / "empty_seats.csv"),
        (replace(one, decision=replace(one.decision, detections=(shown, Detections.none().at("door", 0.05)))),),
    )
    assert (tmp_path / "empty_seats.csv").read_text().splitlines() == [
        "time,camera,seat",
        "0.050000,ceiling,couch",
        "0.050000,ceiling,chair",
    ]


def test_frames_have_a_row_each_with_the_tick_of_their_arrival_and_what_their_pixels_told(tmp_path: Path):
    health = ImageHealth(4_000_000_000, 120.5, 25.25, (30.125, -0.5))
    late = replace(found(frame(time=-0.45)), health=health)
    unknown = found(IMAGE)
    write(FramesRecorder(tmp_path / "frames.csv"), (tick(1, detections=[late, unknown]),))
    assert (tmp_path / "frames.csv").read_text().splitlines() == [
        "time,camera,exposed,checksum,brightness,contrast,shift_right,shift_down",
        "0.050000,ceiling,-0.450000,4000000000,120.500000,25.250000,30.125000,-0.500000",
        "0.050000,ceiling,0.050000,,,,,",
    ]


def test_legs_have_a_row_per_measurement_and_one_per_empty_place(tmp_path: Path):
    covariances = np.array([[[0.01, 0.003], [0.003, 0.04]]])
    legs = LegScan(0.05, np.array([[2.0, -1.0]]), covariances, vacant=(3, 5))
    told = replace(TICKS[1], decision=replace(TICKS[1].decision, legs=legs))
    write(LegsRecorder(tmp_path / "legs.csv"), (TICKS[0], told))
    assert (tmp_path / "legs.csv").read_text().splitlines() == [
        "time,x,y,deviation_x,deviation_y,correlation,vacant",
        "0.050000,2.000000,-1.000000,0.100000,0.200000,0.150000,",
        "0.050000,,,,,,3",
        "0.050000,,,,,,5",
    ]


def test_well_formed_messages_have_a_row_each_with_the_tick_of_their_arrival(tmp_path: Path):
    observation = replace(
        TICKS[1].observation, device_messages=(b"{}", write_payload(DeviceMessage("tv", 0.02, True, "ha")))
    )
    write(MessagesRecorder(tmp_path / "messages.csv", ["tv"]), (TICKS[0], replace(TICKS[1], observation=observation)))
    assert (tmp_path / "messages.csv").read_text().splitlines() == [
        "time,device,sent,on,session",
        "0.050000,tv,0.020000,1,ha",
    ]


def test_whole_numbers_and_numpy_numbers_are_written_like_other_numbers(tmp_path: Path):
    write(TraceRecorder(tmp_path / "trace.csv", make_world()), (tick(0, robot=(1, 2, 0)),))
    assert (tmp_path / "trace.csv").read_text().splitlines()[1].startswith("0.000000,1.000000,2.000000,0.000000,")


def test_rows_are_on_disk_after_each_tick_even_if_the_run_dies(tmp_path: Path):
    recorder = TraceRecorder(tmp_path / "trace.csv", make_world("anna", "bob"))
    recorder.record(TICKS[0])
    lines = (tmp_path / "trace.csv").read_text()
    recorder.close()
    assert lines.count("\n") == 2 and lines.endswith("walking\n")


def test_a_failure_in_the_middle_of_a_tick_leaves_no_half_line(tmp_path: Path):
    recorder = DetectionsRecorder(tmp_path / "detections.csv")
    recorder.record(TICKS[1])
    broken = found(IMAGE, (1.0, 2.0, 3.0, 4.0))
    object.__setattr__(broken, "scores", broken.scores[:0])
    with pytest.raises(ValueError, match="zip"):
        recorder.record(tick(2, detections=[broken]))
    recorder.close()
    lines = (tmp_path / "detections.csv").read_text()
    assert lines.endswith("\n") and all(line.count(",") == 7 for line in lines.splitlines())


def test_equal_runs_give_equal_files(tmp_path: Path):
    for name in ("first", "second"):
        write(TracksRecorder(tmp_path / name))
    assert (tmp_path / "first").read_bytes() == (tmp_path / "second").read_bytes()
