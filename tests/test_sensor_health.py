"""What the robot notices of its sensors, from what they send alone."""

import logging
from collections.abc import Callable

import numpy as np
import pytest

from han_bullet.geometry import Pose2D, Twist2D, moved
from han_bullet.health.sensor_health import BY_CAMERAS_ALONE, BY_LASER_ALONE, HealthReport, SensorHealth
from han_bullet.mecanum import MecanumWheels
from han_bullet.messages import Detections, FrameDetections, ImageHealth, LaserScan, Observation, Odometry, PoseEstimate
from han_bullet.sim.odometry import WheelOdometry
from han_bullet.world_schema import CONTROL_PERIOD, Slip

PERIODS = {"left": 0.1, "right": 0.1}
BLACK = ImageHealth(1, 2.4, 0.1)
NO_SCAN = np.full(3, np.inf)


def live(tick: int) -> ImageHealth:
    """A picture that is like no other."""
    return ImageHealth(1000 + tick, 120.0, 25.0)


def frame(camera: str, exposed: int, health: ImageHealth | None = None) -> FrameDetections:
    """The frame of a camera exposed at a tick."""
    return Detections.none().at(camera, exposed * CONTROL_PERIOD, live(exposed) if health is None else health)


def both(tick: int) -> list[FrameDetections]:
    return [frame("left", tick), frame("right", tick)]


def watch(
    seconds: float,
    frames: Callable[[int], list[FrameDetections]],
    health: SensorHealth | None = None,
    scans: bool = False,
) -> list[HealthReport]:
    """Feed two cameras at 10 Hz, and a laser where there is one; return the report of each tick."""
    health = health or SensorHealth(PERIODS)
    reports = []
    for tick in range(round(seconds / CONTROL_PERIOD) + 1):
        time = tick * CONTROL_PERIOD
        scan = LaserScan(time, NO_SCAN, 0.0, 0.1, 0.05, 8.0, Pose2D(0.0, 0.0, 0.0)) if scans and tick % 2 == 0 else None
        found = frames(tick) if tick % 2 == 0 else []
        here = Pose2D(0.0, 0.0, 0.0)
        sensed = Observation(time, Odometry(time, here, Twist2D()), scan)
        reports.append(health.update(sensed, PoseEstimate(time, here), found))
    return reports


def spans(reports: list[HealthReport]) -> dict[tuple[str, str], tuple[float, float]]:
    """When each fault was first and last there [s]."""
    found: dict[tuple[str, str], tuple[float, float]] = {}
    for tick, report in enumerate(reports):
        for fault in report.faults:
            key, time = (fault.sensor, fault.kind), tick * CONTROL_PERIOD
            found[key] = (found.get(key, (time, time))[0], time)
    return found


def test_cameras_that_send_ever_new_pictures_in_time_have_no_fault() -> None:
    reports = watch(5.0, both)
    assert not spans(reports)
    assert all(all(report.usable) and report.speed_factor == 1.0 for report in reports)


@pytest.mark.parametrize("exposed", [-1, -2, -3])
def test_what_was_taken_before_the_first_tick_arrives_late_at_worst_and_is_not_lossy(exposed: int) -> None:
    def frames(tick: int) -> list[FrameDetections]:
        return [frame("left", exposed if tick == 0 else tick), frame("right", tick)]

    assert {kind for _, kind in spans(watch(1.0, frames))} <= {"late"}


def test_a_picture_that_repeats_is_frozen_at_once_until_half_a_second_after_the_next_new_one() -> None:
    def frames(tick: int) -> list[FrameDetections]:
        return [frame("left", tick, live(38) if 40 <= tick < 80 else None), frame("right", tick)]

    reports = watch(6.0, frames)
    (start, end) = spans(reports)["left", "frozen"]
    assert len(spans(reports)) == 1
    assert (start, end) == pytest.approx((2.0, 4.35))
    unusable = [tick for tick, report in enumerate(reports) if report.usable and not report.usable[0]]
    assert unusable == list(range(40, 88, 2))
    assert all(report.usable[1] for report in reports[::2])


def test_without_noise_a_still_picture_is_no_fault() -> None:
    same = ImageHealth(7, 120.0, 25.0)
    health = SensorHealth(PERIODS, noisy=False)
    assert not spans(watch(2.0, lambda tick: [frame("left", tick, same), frame("right", tick, same)], health))


def test_a_black_picture_is_black_and_nothing_else_even_if_it_repeats() -> None:
    reports = watch(3.0, lambda tick: [frame("left", tick, BLACK if tick >= 20 else None), frame("right", tick)])
    assert spans(reports) == {("left", "black"): pytest.approx((1.0, 3.0))}
    assert not any(report.usable[0] for report in reports[20::2])


def test_a_dark_picture_with_a_lamp_in_it_is_not_black() -> None:
    night = ImageHealth(5, 6.0, 20.0)
    assert not spans(
        watch(1.0, lambda tick: [frame("left", tick, night), frame("right", tick)], SensorHealth(PERIODS, noisy=False))
    )


def test_a_scene_that_has_moved_is_left_out_at_once_and_knocked_after_a_second() -> None:
    def frames(tick: int) -> list[FrameDetections]:
        moved = ImageHealth(tick, 120.0, 25.0, (30.0, 0.5))
        return [frame("left", tick, moved if tick >= 20 else None), frame("right", tick)]

    reports = watch(4.0, frames)
    assert spans(reports) == {("left", "knocked"): pytest.approx((2.0, 4.0))}
    assert not any(report.usable[0] for report in reports[20::2])


def test_a_scene_that_moves_for_half_a_second_is_not_knocked() -> None:
    def frames(tick: int) -> list[FrameDetections]:
        moved = ImageHealth(tick, 120.0, 25.0, (30.0, 0.5))
        return [frame("left", tick, moved if 20 <= tick < 30 else None), frame("right", tick)]

    assert not spans(watch(4.0, frames))


def test_a_camera_without_frames_for_three_periods_is_dropped() -> None:
    reports = watch(3.0, lambda tick: [*([frame("left", tick)] if tick < 20 else []), frame("right", tick)])
    (start, end) = spans(reports)["left", "dropped"]
    assert (start, end) == pytest.approx((1.2, 3.0))  # the last frame came at 0.9 s
    assert len(spans(reports)) == 1


def test_a_camera_that_loses_every_third_frame_is_dropped_and_what_comes_is_used() -> None:
    reports = watch(8.0, lambda tick: [*([frame("left", tick)] if tick % 6 or tick > 80 else []), frame("right", tick)])
    start, end = spans(reports)["left", "dropped"]
    assert start < 2.1 and 4.0 < end < 6.6  # over when less than a tenth of two seconds is missing
    assert all(all(report.usable) for report in reports)


def test_a_camera_that_has_lost_every_third_frame_is_still_dropped_while_it_loses_every_sixth() -> None:
    def lost(tick: int) -> bool:
        return tick % (6 if tick < 80 else 12) == 0

    reports = watch(12.0, lambda tick: [*([] if lost(tick) else [frame("left", tick)]), frame("right", tick)])
    assert spans(reports)["left", "dropped"][1] == 12.0
    assert len({fault for report in reports for fault in report.faults}) == 1


def test_one_lost_frame_is_no_fault() -> None:
    assert not spans(watch(4.0, lambda tick: [*([frame("left", tick)] if tick != 40 else []), frame("right", tick)]))


def test_frames_that_are_half_a_second_old_are_late_and_not_used_beside_newer_ones() -> None:
    def frames(tick: int) -> list[FrameDetections]:
        left = [frame("left", tick - 10)] if tick >= 30 else [frame("left", tick)] if tick < 20 else []
        return [*left, frame("right", tick)]

    reports = watch(6.0, frames)
    assert spans(reports)["left", "late"] == pytest.approx((1.5, 6.0))
    assert spans(reports)["left", "dropped"][1] < 2.1  # silence before the first late one, and no longer
    assert not any(report.usable[0] for report in reports[30::2])


def test_late_frames_of_all_cameras_are_used_in_their_order() -> None:
    reports = watch(4.0, lambda tick: both(tick - 10) if tick >= 30 else both(tick) if tick < 20 else [])
    assert {("left", "late"), ("right", "late")} <= spans(reports).keys()
    assert all(all(report.usable) for report in reports)
    assert all(report.speed_factor == 1.0 for report in reports[32:])


def test_without_a_camera_of_use_the_robot_goes_slowly_by_its_laser_and_stops_without_one() -> None:
    blind = watch(2.0, lambda tick: [frame("left", tick, BLACK), frame("right", tick, BLACK)])
    assert [report.speed_factor for report in blind[:6]] == [1.0] * 6 and blind[-1].speed_factor == 0.0
    feeling = SensorHealth(PERIODS, laser=0.1)
    slow = watch(2.0, lambda tick: [frame("left", tick, BLACK), frame("right", tick, BLACK)], feeling, scans=True)
    assert slow[-1].speed_factor == BY_LASER_ALONE
    assert ("laser", "dropped") not in spans(slow)


def test_a_laser_without_scans_is_dropped_within_three_periods_and_the_robot_goes_at_half_its_speed() -> None:
    reports = watch(1.0, both, SensorHealth(PERIODS, laser=0.1), scans=False)
    assert spans(reports)["laser", "dropped"] == pytest.approx((0.3, 1.0))
    assert [report.speed_factor for report in reports] == [1.0] * 6 + [BY_CAMERAS_ALONE] * 15


def test_a_fault_and_its_end_are_one_line_each_in_the_log(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        watch(3.0, lambda tick: [frame("left", tick, BLACK if 20 <= tick < 40 else None), frame("right", tick)])
    assert caplog.messages == ["left: black, noticed at 1.00 s", "left: no longer black, noticed at 2.40 s"]


def drive(times: float, seed: int) -> list[tuple[str, float]]:
    """Drive 12 m in slight curves; the usual slip for 4 s, then so many times that. Return what was noticed when."""
    health = SensorHealth({}, slip=Slip())
    pose = Pose2D(0.0, 0.0, 0.0)
    wheels = WheelOdometry(MecanumWheels(0.05, 0.2, 0.2), Slip(), pose, np.random.default_rng(seed))
    noticed: dict[str, float] = {}
    for tick in range(280):
        time = tick * CONTROL_PERIOD
        report = health.update(Observation(time, wheels.read(time)), PoseEstimate(time, pose), [])
        for fault in report.faults:
            noticed.setdefault(fault.kind, fault.since)
        pose = moved(pose, Twist2D(0.9, 0.0, 0.2 * np.sin(tick / 20.0)), CONTROL_PERIOD)
        wheels.advance(pose, times if time >= 4.0 else 1.0)
    return list(noticed.items())


def test_usual_slip_is_no_fault_and_five_times_as_much_mostly_is_within_eight_seconds() -> None:
    assert not any(drive(1.0, seed) for seed in range(20))
    noticed = [drive(5.0, seed) for seed in range(20)]
    assert all(kind == "slip" and since > 4.0 for faults in noticed for kind, since in faults)
    assert sum(faults != [] and faults[0][1] < 12.0 for faults in noticed) >= 16


def test_a_leap_with_which_a_lost_robot_is_found_is_no_slip() -> None:
    health = SensorHealth({}, slip=Slip())
    for tick in range(200):
        time = tick * CONTROL_PERIOD
        here, lost = Pose2D(1.0 if tick < 80 else 4.0, 0.0, 0.0), 60 <= tick < 80
        sensed = Observation(time, Odometry(time, Pose2D(0.0, 0.0, 0.0), Twist2D()))
        assert health.update(sensed, PoseEstimate(time, here, lost=lost), []).faults == ()
