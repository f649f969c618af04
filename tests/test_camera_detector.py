"""Frames of several cameras: names and times, the empty scenes of fixed ones, and any image detector in between."""

import numpy as np
import pytest
from bars import WHITE, RedNetwork, detector, found_at, frame

from han_bullet.detection.camera_detector import CameraDetector
from han_bullet.detection.cnn import Classifier
from han_bullet.detection.detector import Detector
from han_bullet.detection.empty_seats import SeatInView
from han_bullet.detection.loading import load_detector
from han_bullet.detection.still_scene import Changes, _cell_means
from han_bullet.errors import BadInputError
from han_bullet.geometry import Pose2D, project
from han_bullet.messages import Detections, Frame, Posture
from han_bullet.sim.gait import Gait
from han_bullet.sim.renderer import Renderer
from han_bullet.sim.scene_state import RobotPosture, SceneState
from han_bullet.world_file import load_world


class Fixed(Detector):
    """A detector of one stage that finds the same two boxes in every image."""

    def detect(self, image: np.ndarray) -> Detections:
        boxes = np.array([[60.0, 70.0, 24.0, 92.0], [204.0, 70.0, 24.0, 92.0]])
        return Detections(boxes, np.array([2.0, 1.0]), np.ones(2))


def test_detections_carry_the_camera_and_time_of_their_frame():
    frames = [frame((60, WHITE), camera="hall", time=1.5), frame((204, WHITE), camera="door", time=2.0)]
    found = CameraDetector(detector()).detect(frames)
    assert [(one.camera, one.time) for one in found] == [("hall", 1.5), ("door", 2.0)]
    assert [found_at(one) for one in found] == [[72], [216]]


def test_a_detector_of_one_stage_is_masked_by_the_empty_scene_too():
    masked = CameraDetector(Fixed())
    masked.calibrate([frame()])
    (found,) = masked.detect([frame((60, WHITE))])
    assert found.boxes.tolist() == [[60.0, 70.0, 24.0, 92.0]]
    assert len(masked.detect([frame((60, WHITE), fixed=False)])[0].boxes) == 2


def test_only_cameras_with_an_empty_scene_know_the_rows_of_the_feet():
    found = CameraDetector(Fixed())
    assert found.detect([frame((60, WHITE))])[0].feet is None
    found.calibrate([frame()])
    fixed, moving = found.detect([frame((60, WHITE)), frame((60, WHITE), fixed=False)])
    assert fixed.feet.shape == (1,)
    assert moving.feet is None


def test_a_fixed_camera_with_an_empty_scene_names_the_seats_that_it_shows_to_be_empty():
    left, right = (SeatInView(name, np.array([[x, 60.0, 40.0, 110.0]])) for name, x in (("left", 52), ("right", 196)))
    found = CameraDetector(Fixed(), seats={"a": [left, right]})
    assert found.detect([frame()])[0].empty_seats == ()
    found.calibrate([frame(), frame(camera="b")])
    frames = [frame(), frame((60, WHITE)), frame((204, WHITE)), frame(fixed=False), frame(camera="b")]
    assert [one.empty_seats for one in found.detect(frames)] == [("left", "right"), ("right",), ("left",), (), ()]


def test_seats_are_seen_to_be_empty_in_a_frame_in_which_nobody_is_looked_for():
    found = CameraDetector(detector(), seats={"a": [SeatInView("couch", np.array([[52.0, 60.0, 40.0, 110.0]]))]})
    assert not Changes(np.zeros((60, 80), bool)).may_hold(found.detector.smallest_area)
    found.calibrate([frame()])
    assert found.detect([frame()])[0].empty_seats == ("couch",)


def test_what_the_empty_scene_rules_out_never_reaches_the_second_stage():
    class Counting(Classifier):
        boxes = 0

        def probabilities(self, image, boxes):
            self.boxes += len(boxes)
            return super().probabilities(image, boxes)

    classifier = Counting(RedNetwork(), least_probability=0.0)
    masked = CameraDetector(detector(classifier))
    masked.detect([frame((60, WHITE))])
    seen, classifier.boxes = classifier.boxes, 0
    masked.calibrate([frame((60, WHITE))])
    masked.detect([frame((60, WHITE))])
    assert seen > 0 and classifier.boxes == 0


def test_a_frame_is_compared_with_the_empty_scene_once(monkeypatch):
    compared = []

    def count(image):
        compared.append(image)
        return _cell_means(image)

    monkeypatch.setattr("han_bullet.detection.still_scene._cell_means", count)
    masked = CameraDetector(Fixed())
    masked.calibrate([frame()])
    compared.clear()
    seen = frame((60, WHITE))
    assert len(masked.detect([seen])[0].boxes) == 1
    assert len(compared) == 1 and compared[0] is seen.image


def test_what_the_empty_scene_shows_too_is_no_person_but_what_is_new_is():
    masked = CameraDetector(detector())
    masked.calibrate([frame((60, WHITE))])
    (still,) = masked.detect([frame((60, WHITE))])
    (entered,) = masked.detect([frame((60, WHITE), (204, WHITE))])
    assert found_at(still) == []
    assert still.boxes.shape == (0, 4)
    assert found_at(entered) == [216]


def test_person_in_front_of_a_mistake_of_the_empty_scene_is_found():
    masked = CameraDetector(detector())
    masked.calibrate([frame((60, WHITE))])
    assert found_at(masked.detect([frame((60, (250, 160, 120)))])[0]) == [72]


def test_mask_of_one_camera_does_not_touch_another_nor_a_moving_one_of_the_same_name():
    masked = CameraDetector(detector())
    masked.calibrate([frame((60, WHITE), camera="a")])
    images = [frame((60, WHITE), camera=name, fixed=fixed) for name, fixed in (("a", True), ("b", True), ("a", False))]
    assert [found_at(found) for found in masked.detect(images)] == [[], [72], [72]]


def test_second_calibration_replaces_the_first():
    masked = CameraDetector(detector())
    masked.calibrate([frame((60, WHITE))])
    masked.calibrate([frame()])
    assert found_at(masked.detect([frame((60, WHITE))])[0]) == [72]


def test_moving_camera_cannot_be_calibrated():
    with pytest.raises(BadInputError, match="'onboard' moves"):
        CameraDetector(detector()).calibrate([frame(camera="onboard", fixed=False)])


def test_no_frames_give_no_detections():
    assert CameraDetector(detector()).detect([]) == []


def test_shipped_detector_finds_a_rendered_person_and_nothing_else_in_an_empty_corridor():
    world = load_world("real2")
    camera = world.camera("camera1")
    gait = Gait("slim")
    for step in range(20):
        body = gait.advance(Pose2D(5.5 + 0.05 * step, -0.3, 0.0), 1.0, 0.05, Posture.WALKING)
    state = SceneState(0.0, 0, RobotPosture(Pose2D(13.0, 0.9, 0.0)), (body,))
    renderer = Renderer(world, 0)
    images = [renderer.calibration_image("camera1"), renderer.render("camera1", state)]
    renderer.close()
    empty, walker = (Frame("camera1", 0.0, i, camera.intrinsics, camera.camera_in_world, True) for i in images)
    assert len(load_detector().detect(empty.image).scores) <= 1
    shipped = CameraDetector(load_detector())
    shipped.calibrate([empty])
    assert len(shipped.detect([empty])[0].scores) == 0
    (found,) = shipped.detect([walker])
    assert len(found.scores) == 1
    assert found.probabilities[0] > 0.5
    foot = found.boxes[0, :2] + [0.5 * found.boxes[0, 2], found.boxes[0, 3]]
    assert np.abs(foot - _pixel(camera, body.pose_in_world)).max() < 15.0  # [px]


def _pixel(camera, pose) -> np.ndarray:
    return project(np.array([[pose.x, pose.y, 0.0]]), camera.intrinsics, camera.camera_in_world)[0][0]


def test_the_rows_of_the_feet_stay_with_their_boxes_and_empty_seats_with_their_frame():
    found = Detections(
        np.arange(12.0).reshape(3, 4), np.ones(3), np.ones(3), feet=np.array([1.0, np.nan, 3.0]), empty_seats=("couch",)
    )
    chosen = found.select(np.array([2, 0])).at("hall", 1.5)
    assert chosen.boxes[:, 0].tolist() == [8.0, 0.0]
    assert chosen.feet.tolist() == [3.0, 1.0]
    assert (chosen.camera, chosen.time, chosen.empty_seats) == ("hall", 1.5, ("couch",))
    assert Detections.none().select(np.zeros(0, bool)).feet is None
