"""Whether the robot's camera looks where it should, from whom it and others see."""

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
import pytest
from ticks import make_world, track

from han_bullet.coverage import empty_frame
from han_bullet.geometry import Array, Pose2D, Twist2D, rotation
from han_bullet.health.alignment import SAMPLES, Alignment
from han_bullet.health.sensor_health import SensorHealth
from han_bullet.messages import (
    Detections,
    Fault,
    ImageHealth,
    LegScan,
    Observation,
    Odometry,
    PoseEstimate,
    Scan,
    Seat,
    TrackedPerson,
)

HERE = Pose2D(1.0, 0.0, 0.3)
CAMERAS = {
    camera.name: camera
    for camera in make_world(
        cameras=[
            {"kind": "onboard", "name": "head"},
            {"kind": "ceiling", "name": "ceiling", "position": [0.2, 0.0, 2.6], "look_at": [6.2, 0.0, 0.9]},
        ]
    ).cameras
}
EYE = empty_frame(CAMERAS["head"], HERE).camera_in_world[:2, 3]
ANNA, BERT = np.array([4.0, 1.0]), np.array([6.0, -1.0])
UP = np.array([0.0, 1.0])


def scan(camera: str, *places: Array, time: float = 0.0, deviation: float = 0.15) -> Scan:
    """Whom a camera sees, the robot being at `HERE`."""
    covariances = np.tile(deviation**2 * np.eye(2), (len(places), 1, 1))
    frame = empty_frame(CAMERAS[camera], HERE)
    return Scan(camera, time, np.array(places).reshape(-1, 2), covariances, np.arange(len(places)), frame)


def legs(*places: Array, time: float = 0.0) -> LegScan:
    return LegScan(time, np.array(places).reshape(-1, 2), np.tile(0.05**2 * np.eye(2), (len(places), 1, 1)))


def turned(place: Array, degrees: float) -> Array:
    """Where a camera that is turned to the left sees whom it believes to look straight: to the right."""
    return EYE + rotation(-np.radians(degrees)) @ (place - EYE)


def watch(
    ticks: int,
    degrees: Callable[[int], float],
    seen: Iterable[Array] = (ANNA,),
    rng: np.random.Generator | None = None,
    alignment: Alignment | None = None,
) -> list[bool]:
    """Compare at 10 Hz, people being seen with noise; tell at each tick whether the camera is knocked."""
    alignment = alignment or Alignment("head")
    told = []
    for tick in range(ticks):
        time = 0.1 * tick

        def noisy(place: Array, deviation: float) -> Array:
            return place if rng is None else place + rng.normal(0.0, deviation, 2)

        own = scan("head", *(turned(noisy(place, 0.03), degrees(tick)) for place in seen), time=time)
        alignment.compare(own, [scan("ceiling", *(noisy(place, 0.02) for place in seen), time=time)], [])
        alignment.close_tick(time)
        told.append(alignment.fault is not None)
    return told


def samples_of(own: Scan, *others: Scan | LegScan, people: Iterable[TrackedPerson] = ()) -> list[float]:
    """The samples of one comparison [deg]."""
    alignment = Alignment("head")
    alignment.compare(own, others, tuple(people))
    return np.degrees(alignment.samples).tolist()


def test_a_camera_that_looks_straight_is_never_knocked_whatever_the_noise() -> None:
    assert not any(any(watch(100, lambda _: 0.0, (ANNA, BERT), np.random.default_rng(seed))) for seed in range(4))


@pytest.mark.parametrize("degrees", [-10.0, -3.0, 3.0, 10.0])
def test_a_camera_turned_either_way_is_knocked_within_a_second(degrees: float) -> None:
    told = watch(40, lambda tick: degrees if tick >= 20 else 0.0, rng=np.random.default_rng(1))
    assert not any(told[:20]) and all(told[30:])


def test_the_fault_has_the_name_of_the_camera_and_the_time_at_which_it_was_noticed() -> None:
    alignment = Alignment("head")
    watch(SAMPLES, lambda _: 3.0, alignment=alignment)
    assert alignment.fault is not None
    assert (alignment.fault.sensor, alignment.fault.kind) == ("head", "knocked")
    assert alignment.fault.since == pytest.approx(0.1 * (SAMPLES - 1))


def test_fewer_samples_than_five_tell_nothing() -> None:
    assert not any(watch(SAMPLES - 1, lambda _: 5.0))
    assert watch(SAMPLES, lambda _: 5.0)[-1]


def test_a_camera_that_is_put_right_is_no_longer_knocked_within_a_second() -> None:
    told = watch(60, lambda tick: 3.0 if tick < 30 else 0.0, rng=np.random.default_rng(2))
    assert all(told[SAMPLES:30]) and not any(told[40:])


def test_a_knocked_camera_stays_knocked_while_nobody_is_seen_by_both() -> None:
    alignment = Alignment("head")
    watch(10, lambda _: 3.0, alignment=alignment)
    assert all(watch(50, lambda _: 0.0, (), alignment=alignment))


def test_two_in_five_that_are_far_off_are_no_knock_and_one_that_is_not_hides_none() -> None:
    assert not any(watch(50, lambda tick: 6.0 if tick % 5 < 2 else 0.0))
    assert watch(50, lambda tick: 0.0 if tick % 5 == 0 else 3.0)[-1]


def test_a_knock_of_a_degree_is_not_told_from_the_cameras_own_errors() -> None:
    assert not any(watch(50, lambda _: 1.0))


def test_a_sample_is_how_far_to_the_left_the_camera_sees_somebody() -> None:
    assert samples_of(scan("head", turned(ANNA, 3.0)), scan("ceiling", ANNA)) == pytest.approx([-3.0])
    assert samples_of(scan("head", turned(ANNA, -3.0)), legs(ANNA)) == pytest.approx([3.0])


def test_the_others_are_heeded_as_they_are_sure() -> None:
    (sample,) = samples_of(scan("head", ANNA), scan("ceiling", turned(ANNA, 4.0)), legs(ANNA))
    assert sample == pytest.approx(4.0 * 0.05**2 / (0.05**2 + 0.15**2), rel=0.01)


def test_everybody_who_is_seen_by_both_gives_a_sample_of_their_own() -> None:
    own = scan("head", turned(ANNA, 3.0), turned(BERT, 3.0))
    assert samples_of(own, scan("ceiling", BERT, ANNA)) == pytest.approx([-3.0, -3.0])


@pytest.mark.parametrize("beside", [turned(ANNA, 6.0), turned(ANNA, -6.0)])
def test_two_people_side_by_side_are_not_compared(beside: Array) -> None:
    """Nobody can tell which of them is meant, whoever sees but one."""
    own, both = scan("head", ANNA), scan("ceiling", ANNA, beside)
    assert samples_of(own, both) == []
    assert samples_of(scan("head", ANNA, beside), scan("ceiling", beside)) == []
    assert samples_of(own, scan("ceiling", ANNA)) != []


def test_others_that_mean_different_people_give_no_sample() -> None:
    assert samples_of(scan("head", ANNA), scan("ceiling", ANNA), legs(turned(ANNA, 12.0))) == []


def test_two_known_people_behind_one_another_are_not_compared_but_one_and_their_double_are() -> None:
    own, other = scan("head", turned(ANNA, 5.0)), scan("ceiling", ANNA)
    behind, double = EYE + 1.19 * (ANNA - EYE), turned(ANNA, 5.0)
    anna = track(0, *ANNA.tolist())
    assert samples_of(own, other, people=[anna, track(1, *behind.tolist())]) == []
    assert samples_of(own, other, people=[anna, track(1, *double.tolist())]) == pytest.approx([-5.0])


def test_who_is_nearer_than_two_metres_or_may_sit_is_not_compared() -> None:
    near = EYE + 1.9 * (ANNA - EYE) / np.hypot(*(ANNA - EYE))
    assert samples_of(scan("head", near), scan("ceiling", near)) == []
    sofa = Seat("sofa", ANNA + UP, -1.57, 0.8, 1.9)
    sitting = Alignment("head", [sofa])
    sitting.compare(scan("head", ANNA), [scan("ceiling", ANNA)], ())
    assert sitting.samples == ()
    elsewhere = Alignment("head", [replace(sofa, position_in_world=ANNA + 1.5 * UP)])
    elsewhere.compare(scan("head", ANNA), [scan("ceiling", ANNA)], ())
    assert len(elsewhere.samples) == 1


def test_what_was_seen_a_moment_before_is_taken_to_where_the_person_is_now_and_what_is_older_is_nothing() -> None:
    aside = rotation(0.5 * np.pi) @ (ANNA - EYE) / np.hypot(*(ANNA - EYE))
    walker = track(0, *ANNA.tolist(), velocity=aside.tolist())
    own = scan("head", ANNA, time=1.0)
    assert samples_of(own, scan("ceiling", ANNA - 0.1 * aside, time=0.9), people=[walker]) == pytest.approx([0.0])
    assert samples_of(own, scan("ceiling", ANNA, time=0.85), people=[walker]) == []


def test_health_leaves_out_the_scans_of_a_knocked_camera_counts_it_as_blind_and_names_it() -> None:
    health = SensorHealth({"head": 0.1, "ceiling": 0.1})
    for tick in range(10):
        time = 0.1 * tick
        sensed = Observation(time, Odometry(time, HERE, Twist2D()))
        found = [Detections.none().at(name, time, ImageHealth(tick, 120.0, 25.0)) for name in ("head", "ceiling")]
        report = health.update(sensed, PoseEstimate(time, HERE), found)
        own, other = scan("head", turned(ANNA, 3.0), time=time), scan("ceiling", ANNA, time=time)
        used = health.aligned([own, other], None, [])
        assert report.usable == (True, True)
        assert [s.camera for s in used] == (["head", "ceiling"] if tick < SAMPLES else ["ceiling"])
    assert report.faults == (Fault("head", "knocked", 0.1 * SAMPLES),) and report.blind == ("head",)
    assert health.aligned([own], legs(turned(ANNA, 1.0), time=time), []) == ()


def test_a_robot_that_is_not_sure_of_its_heading_does_not_judge_its_camera() -> None:
    for degrees, knocked in ((0.5, True), (1.0, False)):
        health, covariance = SensorHealth({"head": 0.1}), np.diag([0.0, 0.0, np.radians(degrees) ** 2])
        for tick in range(2 * SAMPLES):
            time = 0.1 * tick
            sensed = Observation(time, Odometry(time, HERE, Twist2D()))
            found = [Detections.none().at("head", time, ImageHealth(tick, 120.0, 25.0))]
            report = health.update(sensed, PoseEstimate(time, HERE, covariance), found)
            health.aligned([scan("head", turned(ANNA, 3.0), time=time), scan("ceiling", ANNA, time=time)], None, [])
        assert bool(report.faults) is knocked, degrees


def test_an_old_frame_is_not_too_old_beside_newer_ones_of_a_knocked_camera_alone() -> None:
    health = SensorHealth({"head": 0.1, "ceiling": 0.1})

    def usable(time: float, camera: str, exposed: float) -> bool:
        sensed = Observation(time, Odometry(time, HERE, Twist2D()))
        found = [Detections.none().at(camera, exposed, ImageHealth(round(exposed * 1000), 120.0, 25.0))]
        return health.update(sensed, PoseEstimate(time, HERE), found).usable[0]

    for tick in range(SAMPLES):
        assert usable(0.1 * tick, "head", 0.1 * tick)
        health.aligned([scan("head", turned(ANNA, 3.0), time=0.1 * tick)], legs(ANNA, time=0.1 * tick), [])
    assert not usable(0.50, "ceiling", 0.35)  # older than what was used until then
    assert usable(0.55, "head", 0.55) and usable(0.60, "ceiling", 0.45)
