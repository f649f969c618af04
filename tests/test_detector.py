"""The detector that joins the stages: order of the stages, what each drops, what is kept with it."""

import math

import numpy as np
import pytest
import torch

from han_bullet.detection.acf import AcfDetector
from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.cnn import Classifier
from han_bullet.detection.detector import PedestrianDetector, load_detector
from han_bullet.errors import BadInputError
from han_bullet.geometry import Intrinsics, Pose2D, project
from han_bullet.messages import Frame, Posture
from han_bullet.sim.gait import Gait
from han_bullet.sim.renderer import Renderer
from han_bullet.sim.scene_state import RobotPosture, SceneState
from han_bullet.world_file import load_world

INTRINSICS = Intrinsics.from_vertical_field_of_view(320, 240, math.radians(45.0))


def bar_model() -> AcfModel:
    """Return a hand-made model that finds bright upright bars on dark ground.

    Each of ten trees adds 5 where the middle of the window is bright and the margin beside, above or below it dark, and
    takes 10 away elsewhere. L is the first channel; bright is L > 0.2 of at most 0.37, dark L < 0.1.
    """
    places = [(16, 8), (6, 8), (26, 8), (11, 8), (21, 8)]
    margins = [(16, 2), (16, 13), (1, 8), (30, 8), (8, 2)]
    pairs = [(place, margins[i]) for i, place in enumerate(places)] + list(zip(places, margins[::-1], strict=True))
    index = np.array([[(row * 16 + column) * 10 for row, column in pair] for pair in pairs])
    features = np.stack([index[:, 0], index[:, 1], index[:, 1]], axis=1).astype(np.int32)
    thresholds = np.tile(np.float32([0.2, 0.1, 0.1]), (len(pairs), 1))
    leaves = np.tile(np.float32([-10.0, -10.0, 5.0, -10.0]), (len(pairs), 1))
    return AcfModel(features, thresholds, leaves, lambdas=(0.0, 0.1, 0.1))


class RedNetwork(torch.nn.Module):
    """A network whose logit for pedestrian is how much redder than blue the middle of the crop is."""

    def forward(self, crops: torch.Tensor) -> torch.Tensor:
        middle = crops[:, :, 28:36, 28:36].mean(dim=(2, 3))
        return torch.stack([torch.zeros(len(crops)), (middle[:, 0] - middle[:, 2]) / 20.0], dim=1)


def frame(*bars: tuple[int, tuple[int, int, int]], camera: str = "a", time: float = 0.0, fixed: bool = True) -> Frame:
    """Return a dark image with upright bars, 24 x 92 px, at these left edges [px] and of these colours."""
    image = np.full((240, 320, 3), 10, np.uint8)
    for left, colour in bars:
        image[70:162, left : left + 24] = colour
    return Frame(camera, time, image, INTRINSICS, np.eye(4), fixed)


RED, BLUE, WHITE = (255, 200, 150), (150, 200, 255), (240, 240, 240)


def detector(classifier: Classifier | None = None, threshold: float = 20.0) -> PedestrianDetector:
    return PedestrianDetector(AcfDetector(bar_model()), classifier, threshold)


def found_at(detections) -> list[int]:
    """Return the centres of the boxes, left to right, rounded to 12 px, without repeats."""
    centres = detections.boxes[:, 0] + 0.5 * detections.boxes[:, 2]
    return sorted({round(float(centre) / 12.0) * 12 for centre in centres})


def test_bars_are_found_where_they_stand_with_the_frame_s_name_and_time():
    (found,) = detector().detect([frame((60, WHITE), (204, WHITE), camera="hall", time=1.5)])
    assert (found.camera, found.time) == ("hall", 1.5)
    assert found_at(found) == [72, 216]
    assert found.boxes.shape == (len(found.scores), 4)
    assert (np.diff(found.scores) <= 0.0).all()
    assert (found.probabilities == 1.0).all()


def test_proposals_below_the_threshold_are_dropped():
    image = frame((60, WHITE))
    assert len(detector(threshold=49.0).detect([image])[0].scores) > 0
    assert len(detector(threshold=51.0).detect([image])[0].scores) == 0


def test_threshold_that_is_no_number_is_refused():
    with pytest.raises(BadInputError, match="nan"):
        detector(threshold=math.nan)


def test_cnn_keeps_or_drops_and_kept_boxes_keep_box_and_score():
    image = frame((60, RED), (204, BLUE))
    (without,) = detector().detect([image])
    (found,) = detector(Classifier(RedNetwork())).detect([image])
    assert found_at(without) == [72, 216]
    assert found_at(found) == [72]
    assert ((found.probabilities >= 0.5) & (found.probabilities <= 1.0)).all()
    kept = without.boxes[:, 0] < 140
    np.testing.assert_array_equal(found.boxes, without.boxes[kept])
    np.testing.assert_array_equal(found.scores, without.scores[kept])


def test_least_probability_of_the_classifier_decides():
    image = frame((204, BLUE))
    assert len(detector(Classifier(RedNetwork(), least_probability=0.0)).detect([image])[0].scores) > 0
    assert len(detector(Classifier(RedNetwork())).detect([image])[0].scores) == 0


def test_what_the_empty_scene_shows_too_is_no_person_but_what_is_new_is():
    masked = detector()
    masked.calibrate([frame((60, WHITE))])
    (still,) = masked.detect([frame((60, WHITE))])
    (entered,) = masked.detect([frame((60, WHITE), (204, WHITE))])
    assert found_at(still) == []
    assert still.boxes.shape == (0, 4)
    assert found_at(entered) == [216]


def test_person_in_front_of_a_mistake_of_the_empty_scene_is_found():
    masked = detector()
    masked.calibrate([frame((60, WHITE))])
    assert found_at(masked.detect([frame((60, (250, 160, 120)))])[0]) == [72]


def test_mask_of_one_camera_does_not_touch_another_nor_a_moving_one_of_the_same_name():
    masked = detector()
    masked.calibrate([frame((60, WHITE), camera="a")])
    images = [frame((60, WHITE), camera=name, fixed=fixed) for name, fixed in (("a", True), ("b", True), ("a", False))]
    assert [found_at(found) for found in masked.detect(images)] == [[], [72], [72]]


def test_second_calibration_replaces_the_first():
    masked = detector()
    masked.calibrate([frame((60, WHITE))])
    masked.calibrate([frame()])
    assert found_at(masked.detect([frame((60, WHITE))])[0]) == [72]


def test_moving_camera_cannot_be_calibrated():
    with pytest.raises(BadInputError, match="'onboard' moves"):
        detector().calibrate([frame(camera="onboard", fixed=False)])


def test_no_frames_give_no_detections():
    assert detector().detect([]) == []


def test_unknown_model_is_refused():
    with pytest.raises(BadInputError, match="acf_nowhere"):
        load_detector("acf_nowhere")


def test_model_without_a_score_threshold_is_used_with_one_that_is_given_and_refused_without(tmp_path):
    bar_model().save(tmp_path / "fresh.npz")
    with pytest.raises(BadInputError, match=r"fresh\.npz' has no score threshold; give --threshold or choose one"):
        load_detector(tmp_path / "fresh.npz", classifier=False)
    given = load_detector(tmp_path / "fresh.npz", threshold=20.0, classifier=False)
    assert found_at(given.detect([frame((60, WHITE))])[0]) == [72]


@pytest.mark.data
def test_toolbox_model_is_used_by_its_path(data_folder):
    loaded = load_detector(data_folder / "models" / "AcfInriaDetector.mat", classifier=False)
    assert loaded.threshold == 40.0
    assert loaded.proposer.model.score_threshold == 40.0


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
    assert len(load_detector().detect([empty])[0].scores) <= 1
    shipped = load_detector()
    shipped.calibrate([empty])
    assert len(shipped.detect([empty])[0].scores) == 0
    (found,) = shipped.detect([walker])
    assert len(found.scores) == 1
    assert found.probabilities[0] > 0.5
    foot = found.boxes[0, :2] + [0.5 * found.boxes[0, 2], found.boxes[0, 3]]
    assert np.abs(foot - _pixel(camera, body.pose_in_world)).max() < 15.0  # [px]


def _pixel(camera, pose) -> np.ndarray:
    return project(np.array([[pose.x, pose.y, 0.0]]), camera.intrinsics, camera.camera_in_world)[0][0]
