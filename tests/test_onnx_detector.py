"""Networks as files: what their outputs mean, and FastestDet from file to boxes."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from han_bullet.detection.inria import load_test_photographs
from han_bullet.detection.loading import load_detector
from han_bullet.detection.network_detector import NetworkDetector
from han_bullet.detection.onnx_detector import FastestDet, YoloFastest, YoloV5, YoloV8, kind_of_output, load_onnx
from han_bullet.detection.overlap import intersection_over_union
from han_bullet.detection.pictures import read_picture
from han_bullet.errors import BadInputError


class Canned:
    """A network that gives the same output for every input, and keeps the input."""

    def __init__(self, output: np.ndarray) -> None:
        self.output = output
        self.blob = np.zeros(0)

    def setInput(self, blob: np.ndarray) -> None:
        self.blob = blob

    def forward(self, names: list[str]) -> list[np.ndarray]:
        return [self.output]

    def getUnconnectedOutLayersNames(self) -> list[str]:
        return ["output"]


def image(height: int, width: int) -> np.ndarray:
    return np.full((height, width, 3), (200, 100, 50), np.uint8)


def test_yolov5_rows_are_box_objectness_and_classes() -> None:
    rows = np.zeros((1, 3, 85), np.float32)
    rows[0, 0, :6] = (320, 320, 64, 160, 0.9, 0.8)
    rows[0, 1, :5], rows[0, 1, 7] = (100, 320, 64, 160, 0.9), 0.9  # a car
    rows[0, 2, :6] = (500, 320, 64, 160, 0.5, 0.5)  # too unsure
    found = YoloV5(Canned(rows), 640, threshold=0.3).detect(image(240, 320))
    # 320 x 240 fills 640 x 480, with 80 px of grey above and below.
    assert found.boxes == pytest.approx(np.array([[144.0, 80.0, 32.0, 80.0]]))
    assert found.scores == pytest.approx([0.72])
    assert found.probabilities == pytest.approx([0.72])


def test_yolov8_columns_are_box_and_classes() -> None:
    columns = np.zeros((1, 84, 2), np.float32)
    columns[0, :5, 0] = (320, 400, 40, 100, 0.7)
    columns[0, :5, 1], columns[0, 6, 1] = (100, 100, 40, 100, 0.6), 0.9
    found = YoloV8(Canned(columns), 640).detect(image(320, 160))
    assert found.boxes == pytest.approx(np.array([[70.0, 175.0, 20.0, 50.0]]))
    assert found.scores == pytest.approx([0.7])


def test_fastestdet_cells_hold_an_offset_a_size_and_classes() -> None:
    cells = np.full((1, 85, 22, 22), -20.0, np.float32)
    cells[0, [0, *range(5, 85)]] = 0.0
    cells[0, :6, 11, 4] = (0.9, np.arctanh(0.5), 0.0, np.log(0.1 / 0.9), 0.0, 0.8)
    found = FastestDet(Canned(cells), 352).detect(image(220, 440))
    # Column 4.5 of 22 and row 11 of 22; a tenth as wide and half as high as the image.
    assert found.boxes == pytest.approx(np.array([[90.0 - 22.0, 110.0 - 55.0, 44.0, 110.0]]), abs=1e-3)
    assert found.scores == pytest.approx([0.9**0.6 * 0.8**0.4])


def test_yolo_fastest_rows_are_parts_of_the_image() -> None:
    rows = np.array([[0.5, 0.5, 0.25, 0.5, 0.9, 0.8], [0.1, 0.1, 0.1, 0.1, 0.9, 0.2]], np.float32)
    found = YoloFastest(Canned(rows), 320).detect(image(100, 200))
    assert found.boxes == pytest.approx(np.array([[75.0, 25.0, 50.0, 50.0]]))
    assert found.scores == pytest.approx([0.8])


def test_boxes_on_one_person_are_reduced_to_the_likeliest() -> None:
    rows = np.zeros((1, 2, 85), np.float32)
    rows[0, 0, :6] = (320, 320, 64, 160, 0.8, 1.0)
    rows[0, 1, :6] = (322, 320, 64, 160, 0.9, 1.0)
    found = YoloV5(Canned(rows), 640).detect(image(640, 640))
    assert found.scores == pytest.approx([0.9])


@pytest.mark.parametrize("kind, first", [(YoloV5, 200), (FastestDet, 50)])
def test_the_network_gets_its_order_of_colours(kind: type[NetworkDetector], first: int) -> None:
    shape = (1, 1, 85) if kind is YoloV5 else (1, 85, 1, 1)
    network = Canned(np.zeros(shape, np.float32))
    kind(network, 64).detect(image(64, 64))
    assert network.blob.shape == (1, 3, 64, 64)
    assert network.blob[0, 0] == pytest.approx(first / 255.0)


NOWHERE = [
    (np.nan, 320, 64, 160),
    (320, np.inf, 64, 160),
    (-np.inf, 320, np.inf, 160),
    (320, 320, np.inf, 160),
    (320, 320, 64, -160),
    (320, 320, 0, 160),
    (-40, 320, 64, 160),  # ends 8 px left of the image
    (320, 730, 64, 160),
    (1e30, 1e30, 64, 160),
]


@pytest.mark.parametrize("box", NOWHERE)
def test_a_box_that_is_nowhere_in_the_image_is_dropped(box: tuple[float, ...]) -> None:
    rows = np.zeros((1, 3, 85), np.float32)
    rows[0, :, :6] = [(*box, 1.0, 0.9), (320, 320, 64, 160, 1.0, 0.8), (-30, 320, 64, 160, 1.0, 0.7)]
    found = YoloV5(Canned(rows), 640).detect(image(640, 640))
    assert found.boxes.tolist() == [[288.0, 240.0, 64.0, 160.0], [-62.0, 240.0, 64.0, 160.0]]
    assert found.scores == pytest.approx([0.8, 0.7])


def test_a_score_that_is_not_finite_is_no_probability() -> None:
    rows = np.array([[0.5, 0.5, 0.25, 0.5, 0.9, score] for score in (np.inf, np.nan, 0.8)], np.float32)
    assert YoloFastest(Canned(rows), 320).detect(image(100, 200)).scores == pytest.approx([0.8])


class OfSides(Canned):
    """A network that takes only some sides of its input, as an export of a fixed size does."""

    def __init__(self, output: np.ndarray, *sides: int) -> None:
        super().__init__(output)
        self.sides = sides

    def forward(self, names: list[str]) -> list[np.ndarray]:
        if self.blob.shape[2] not in self.sides:
            raise cv2.error("shapes do\n not fit")
        return super().forward(names)


def test_a_network_that_fails_on_an_image_is_one_sentence() -> None:
    detector = YoloV5(OfSides(np.zeros((1, 1, 85), np.float32), 416), 640)
    with pytest.raises(BadInputError) as caught:
        detector.detect(image(64, 64))
    assert str(caught.value) == "OpenCV cannot run the network at 640 x 640 px: shapes do not fit"


@pytest.mark.parametrize(
    ("sides", "side"), [((352,), 352), ((416,), 416), ((640,), 640), ((640, 352, 416, 320, 512, 1280), 352)]
)
def test_fastestdet_runs_at_the_side_of_its_export_or_else_of_its_training(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sides: tuple[int, ...], side: int
) -> None:
    network = OfSides(np.zeros((1, 85, 22, 22), np.float32), *sides)
    monkeypatch.setattr("cv2.dnn.readNetFromONNX", lambda content: network)
    (tmp_path / "net.onnx").write_bytes(b"any")
    detector = load_onnx(tmp_path / "net.onnx")
    assert isinstance(detector, FastestDet)
    assert detector.side == side
    assert detector.detect(image(64, 64)).boxes.shape == (0, 4)
    assert network.blob.shape == (1, 3, side, side)


@pytest.mark.parametrize("threshold", [-0.1, 1.1, float("nan")])
def test_a_threshold_that_is_no_probability_is_refused(threshold: float) -> None:
    with pytest.raises(BadInputError, match="from 0 to 1"):
        YoloV5(Canned(np.zeros((1, 1, 85), np.float32)), 640, threshold)


@pytest.mark.parametrize("content", [b"", b"hello", b"\x08\x07" * 200])
def test_a_malformed_file_is_one_sentence_with_its_name(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "net.onnx").write_bytes(content)
    with pytest.raises(BadInputError, match=r"net\.onnx is not an ONNX detector") as caught:
        load_detector(tmp_path / "net.onnx")
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_bad_input() -> None:
    with pytest.raises(BadInputError, match=r"nowhere\.onnx"):
        load_detector("nowhere.onnx")


def test_the_shape_of_the_output_tells_the_network() -> None:
    assert kind_of_output([(1, 85, 22, 22)], "x.onnx") is FastestDet
    assert kind_of_output([(1, 25200, 85)], "x.onnx") is YoloV5
    assert kind_of_output([(1, 84, 8400)], "x.onnx") is YoloV8


@pytest.mark.parametrize("shapes", [[(1, 1000)], [(1, 85, 22, 22)] * 2, [(1, 30, 7)], [(2, 84, 8400)]])
def test_another_shape_is_refused_with_what_it_is(shapes: list[tuple[int, ...]]) -> None:
    with pytest.raises(BadInputError, match=r"x\.onnx gives \(.*YOLOv8 would be right"):
        kind_of_output(shapes, "x.onnx")


@pytest.mark.data
@pytest.mark.parametrize("name, least_share", [("FastestDet.onnx", 0.6), ("yolo-fastest-1.1_body.cfg", 0.6)])
def test_boxes_of_real_networks_hug_people_on_photographs(data_folder: Path, name: str, least_share: float) -> None:
    detector = load_detector(data_folder / "peers" / name)
    overlaps = []
    for labelled in load_test_photographs(data_folder)[:12]:
        found = detector.detect(read_picture(labelled.path))
        overlaps += intersection_over_union(labelled.boxes, found.boxes).max(axis=1, initial=0.0).tolist()
    hugged = np.array(overlaps) > 0.6
    assert len(overlaps) > 15
    assert hugged.mean() > least_share


@pytest.mark.data
def test_a_truncated_network_is_bad_input(data_folder: Path, tmp_path: Path) -> None:
    whole = (data_folder / "peers/FastestDet.onnx").read_bytes()
    (tmp_path / "half.onnx").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(BadInputError, match=r"half\.onnx"):
        load_detector(tmp_path / "half.onnx")
