"""What comes from ROS, gathered for one tick after the other; what cannot be used is refused, once with its reason."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from live_robot import write_live_robot

from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.messages import CameraImage, LaserScan, Odometry
from han_bullet.ros.camera_messages import image_message
from han_bullet.ros.live_setup import LiveSetup, load_live_setup
from han_bullet.ros.message_types import serialize
from han_bullet.ros.robot_messages import odometry_message, scan_message
from han_bullet.ros.senses import Senses
from han_bullet.world_schema import Slip

EPOCH = 1.7e9  # [s], a robot's clock
CAMERA, LASER, ODOM = "/camera1/image_raw", "/scan", "/odom"


@pytest.fixture(scope="module")
def setup(tmp_path_factory: pytest.TempPathFactory) -> LiveSetup:
    return load_live_setup(write_live_robot(tmp_path_factory.mktemp("robot")))


class Heard:
    """Senses, and what they handed on."""

    def __init__(self, setup: LiveSetup) -> None:
        self.images: list[CameraImage] = []
        self.complaints: list[str] = []
        self.senses = Senses(setup, self.images.append, self.complaints.append)
        self._mounted = setup.cameras[0].mounted

    def odometry(self, time: float, x: float = 0.0) -> bool:
        odometry = Odometry(EPOCH + time, Pose2D(x, 0.0, 0.0), Twist2D())
        return self.take(ODOM, odometry_message(odometry, Slip()))

    def image(self, time: float, encoding: str = "rgb8") -> bool:
        lens = self._mounted.intrinsics
        pixels = np.zeros((lens.height, lens.width, 3), np.uint8)
        image = CameraImage("camera1", EPOCH + time, pixels, lens, self._mounted.mount, fixed=True)
        return self.take(CAMERA, replace(image_message(image), encoding=encoding))

    def scan(self, time: float, distance: float = 1.0) -> bool:
        scan = LaserScan(EPOCH + time, np.full(3, distance), -0.5, 0.5, 0.0, 8.0, Pose2D(0.0, 0.0, 0.0))
        return self.take(LASER, scan_message(scan, 0.1))

    def take(self, topic: str, message: Any) -> bool:
        return self.senses.take(topic, bytes(serialize(message)))


def test_the_loops_clock_begins_with_the_first_odometry_and_the_robots_is_kept(setup: LiveSetup) -> None:
    heard = Heard(setup)
    assert heard.odometry(5.0)
    first = heard.senses.tick()
    assert first is not None and first.time == 0.0
    assert heard.senses.epoch == pytest.approx(EPOCH + 5.0)
    assert heard.image(5.1) and heard.scan(5.1)
    scan = heard.senses.scan()
    assert scan is not None and scan.time == pytest.approx(0.1)
    assert heard.images[0].time == pytest.approx(0.1)


def test_a_tick_is_due_once_per_control_period_whatever_the_rate_of_odometry(setup: LiveSetup) -> None:
    heard, times = Heard(setup), []
    for count in range(101):  # 50 Hz for 2 s
        heard.odometry(0.02 * count)
        odometry = heard.senses.tick()
        times += [] if odometry is None else [odometry.time]
    assert len(times) == pytest.approx(41, abs=1)
    assert np.diff(times).min() > 0.039 and np.diff(times).max() < 0.061
    assert heard.senses.tick() is None


def test_after_a_gap_ticks_go_on_from_there_and_none_is_made_up_for(setup: LiveSetup) -> None:
    heard = Heard(setup)
    ticks = 0
    for time in (0.0, 1.0, 1.02, 1.05):
        heard.odometry(time)
        ticks += heard.senses.tick() is not None
    assert ticks == 3


def test_of_many_odometries_that_wait_the_newest_counts(setup: LiveSetup) -> None:
    heard = Heard(setup)
    for count in range(5):
        heard.odometry(0.05 * count, x=float(count))
    odometry = heard.senses.tick()
    assert odometry is not None and odometry.pose_robot_in_odom.x == 4.0
    assert heard.senses.tick() is None


def test_a_scan_is_handed_on_once_and_the_newest(setup: LiveSetup) -> None:
    heard = Heard(setup)
    heard.odometry(0.0)
    assert heard.scan(0.0, 1.0) and heard.scan(0.1, 2.0)
    scan = heard.senses.scan()
    assert scan is not None and scan.ranges[0] == 2.0
    assert heard.senses.scan() is None


def test_images_are_taken_no_more_often_than_the_camera_is_to_be_looked_at(setup: LiveSetup) -> None:
    heard = Heard(setup)
    heard.odometry(0.0)
    assert setup.cameras[0].period == pytest.approx(0.2)
    taken = [heard.image(time) for time in (0.0, 0.05, 0.1, 0.15, 0.19, 0.3, 0.39)]
    assert taken == [True, False, False, False, True, False, True]
    assert heard.complaints == []


def test_nothing_is_taken_before_odometry_since_nothing_has_a_time_yet(setup: LiveSetup) -> None:
    heard = Heard(setup)
    assert not heard.image(0.0) and not heard.scan(0.0)
    assert heard.images == [] and heard.complaints == []


def test_a_refused_message_is_told_once_per_reason_and_counted_and_the_next_good_one_is_taken(setup: LiveSetup) -> None:
    heard = Heard(setup)
    heard.odometry(0.0)
    for time in (0.2, 0.4, 0.6):
        assert not heard.image(time, encoding="yuv422")
    assert not heard.senses.take(CAMERA, b"\x00\x01")
    assert not heard.senses.take(CAMERA, b"\x00\x01\x02")
    assert heard.image(0.8)
    assert len(heard.complaints) == 2
    assert heard.complaints[0].startswith(f"{CAMERA}: encoding is 'yuv422'")
    assert heard.complaints[1].startswith(f"{CAMERA}: 2 bytes are no sensor_msgs/Image")
    assert heard.senses.refused == {CAMERA: 5}


def test_odometry_that_goes_back_in_time_is_refused_and_so_is_a_scan(setup: LiveSetup) -> None:
    heard = Heard(setup)
    assert heard.odometry(1.0) and not heard.odometry(0.9) and not heard.odometry(1.0)
    assert heard.scan(1.1) and not heard.scan(1.0)
    assert [complaint.split(":")[0] for complaint in heard.complaints] == [ODOM, LASER]
    assert "back to" in heard.complaints[1]


def test_a_sensor_on_another_clock_is_refused(setup: LiveSetup) -> None:
    heard = Heard(setup)
    heard.odometry(0.0)
    assert not heard.scan(-3.0) and not heard.scan(3.0) and heard.scan(0.5)
    assert "from odometry's; at most 2 s would be right" in heard.complaints[0]


def test_it_listens_to_what_the_configuration_names(setup: LiveSetup) -> None:
    assert Heard(setup).senses.topics == {
        ODOM: "nav_msgs/Odometry",
        LASER: "sensor_msgs/LaserScan",
        CAMERA: "sensor_msgs/Image",
        "/camera2/image_raw": "sensor_msgs/Image",
    }


def test_a_lens_that_bends_lines_is_undone(setup: LiveSetup, tmp_path: Path) -> None:
    from han_bullet.calibration.lens import Distortion

    camera = setup.cameras[0]
    assert camera.calibration is not None
    bent = replace(camera.calibration, distortion=Distortion("plumb_bob", np.array([-0.3, 0.1, 0.0, 0.0, 0.0])))
    heard = Heard(replace(setup, cameras=(replace(camera, calibration=bent), setup.cameras[1])))
    heard.odometry(0.0)
    lens = camera.mounted.intrinsics
    pixels = np.random.default_rng(0).integers(0, 256, (lens.height, lens.width, 3), np.uint8)
    image = CameraImage("camera1", EPOCH, pixels, lens, camera.mounted.mount, fixed=True)
    assert heard.take(CAMERA, image_message(image))
    np.testing.assert_array_equal(heard.images[0].image, bent.undistort(pixels))
    assert (heard.images[0].image != pixels).mean() > 0.5
