from dataclasses import replace
from pathlib import Path

import cv2
import imageio_ffmpeg
import numpy as np
import pytest
from ticks import CAMERA, found, frame, make_world, on_floor, person, tick, track

from han_bullet.assembly import task_of
from han_bullet.costmap.grid import Costmap
from han_bullet.costmap.layers import standard_layers
from han_bullet.episode import Tick
from han_bullet.errors import HanError
from han_bullet.lettering import Lettering
from han_bullet.messages import Fault, Scene, Status
from han_bullet.messages import Path as Way
from han_bullet.panels import BOX, FAULT, STATUS_COLOURS
from han_bullet.topdown import GOAL, PATH, ROBOT, TRACK, TopDownView
from han_bullet.video import CAMERA_HEIGHT, MAP_HEIGHT, TITLE_HEIGHT, WIDTH, VideoRecorder
from han_bullet.world_schema import World

CAMERAS = [{"name": CAMERA.name, "kind": "ceiling", "position": CAMERA.position, "look_at": CAMERA.look_at}]
BOX_IN_IMAGE = (300.0, 150.0, 82.0, 200.0)
GREY = 128


def with_camera(**changes: object) -> World:
    return make_world("walker", cameras=CAMERAS, **changes)


def driving(count: int, speed: float = 2.0) -> list[Tick]:
    """Return ticks of a robot that drives along y = 1 m from x = 2 m, with an image every other tick."""
    ticks = []
    for i in range(count):
        image = frame(time=i * 0.05, image=np.full((480, 640, 3), GREY, np.uint8))
        boxes = found(image, BOX_IN_IMAGE, score=63.2, probability=0.98)
        seen = {"frames": [image], "detections": [boxes], "scans": [on_floor(image, boxes)]} if i % 2 == 0 else {}
        walker = person(x=6.0, y=-0.5, speed=0.35)
        believed = track(0, 6.1, -0.4, velocity=(0.3, 0.0), posture="walking", heading=0.0)
        ticks.append(tick(i, robot=(2.0 + speed * i * 0.05, 1.0, 0.0), people=[walker], tracks=[believed], **seen))
    return ticks


def record(path: Path, world: World, ticks: list[Tick], **keywords: bool) -> None:
    recorder = VideoRecorder(path, world, **keywords)
    for one in ticks:
        recorder.record(one)
    recorder.close()


def read(path: Path) -> tuple[dict, list[np.ndarray]]:
    frames = imageio_ffmpeg.read_frames(str(path))
    facts = next(frames)
    width, height = facts["size"]
    return facts, [np.frombuffer(data, np.uint8).reshape(height, width, 3) for data in frames]


def like(picture: np.ndarray, colour: tuple[int, int, int], within: int = 30) -> np.ndarray:
    """Tell which pixels have nearly a colour; H.264 and its halved colour planes shift it a little."""
    return np.all(np.abs(picture.astype(int) - colour) <= within, axis=-1)


def place_of(world: World, point: tuple[float, float]) -> np.ndarray:
    """Return the column and row in the video of a point of the world."""
    view = TopDownView(world, (WIDTH, MAP_HEIGHT), Lettering())
    return view.pixels(np.array(point)) + np.array([0.0, TITLE_HEIGHT])


def test_the_video_is_h264_in_real_time_with_one_picture_per_camera_period(tmp_path: Path):
    record(tmp_path / "video.mp4", with_camera(), driving(20))
    facts, pictures = read(tmp_path / "video.mp4")
    assert facts["codec"] == "h264" and facts["pix_fmt"].startswith("yuv420p")
    assert (facts["fps"], facts["size"]) == (10.0, (1920, 960))
    assert len(pictures) == 10


def test_a_browser_can_start_before_the_file_is_loaded(tmp_path: Path):
    record(tmp_path / "video.mp4", with_camera(), driving(4))
    data = (tmp_path / "video.mp4").read_bytes()
    assert 0 < data.index(b"moov") < data.index(b"mdat")


def test_the_robot_is_drawn_where_it_is(tmp_path: Path):
    world, ticks = with_camera(), driving(20)
    record(tmp_path / "video.mp4", world, ticks)
    for picture, one in zip(read(tmp_path / "video.mp4")[1], ticks[::2], strict=True):
        rows, columns = np.nonzero(like(picture[TITLE_HEIGHT : TITLE_HEIGHT + MAP_HEIGHT], ROBOT))
        pose = one.truth.pose_robot_in_world
        column, row = place_of(world, (pose.x, pose.y))
        # The white nose lies ahead of the centre, so compare the middle of the disc's extent.
        assert 0.5 * (columns.min() + columns.max()) == pytest.approx(column, abs=2.0)
        assert TITLE_HEIGHT + 0.5 * (rows.min() + rows.max()) == pytest.approx(row, abs=2.0)


def test_goal_path_and_track_are_drawn_where_they_are():
    world = with_camera()
    way = Way(np.array([[2.0, 1.0], [10.0, 1.0]]), cost=8.0)
    picture = VideoRecorder(Path("unused.mp4"), world).draw(
        tick(0, robot=(2.0, 1.0, 0.0), tracks=[track(0, 6.0, -0.5)], path=way, scene=Scene(0.0, task=task_of(world)))
    )
    for point, colour in (((18.0, 0.0), GOAL), ((9.0, 1.0), PATH), ((6.0, -0.5), TRACK)):
        column, row = place_of(world, point).astype(int)
        assert like(picture[row - 1 : row + 2, column - 1 : column + 2], colour, 1).all(), (point, colour)


def test_costs_are_drawn_cell_by_cell_at_their_places():
    world = make_world("walker", walls=[{"start": [0.0, 2.05], "end": [20.0, 2.05]}])
    costmap = Costmap.covering([((0.0, 20.0), (-2.0, 2.0))], 0.05)
    scene = Scene(0.0, (track(0, 12.0, -0.5),))
    for layer in standard_layers(world.solid_boxes(), robot_radius=0.3):
        layer.apply(costmap, scene)
    picture = VideoRecorder(Path("unused.mp4"), world).draw(tick(0, robot=(1.0, 0.0, 0.0), costmap=costmap))

    def brightness(x: float, y: float) -> int:
        column, row = place_of(world, (x, y)).astype(int)
        return int(picture[row, column].sum())

    person_disc, personal_space, floor = brightness(12.0, -0.5), brightness(12.8, -0.5), brightness(6.0, -0.5)
    assert person_disc < personal_space < floor - 20
    assert brightness(6.0, 1.9) < floor - 20  # faint inflation along the wall at y = 2 m


def test_each_camera_has_its_image_below_with_the_box_in_place(tmp_path: Path):
    record(tmp_path / "video.mp4", with_camera(), driving(2))
    strip = read(tmp_path / "video.mp4")[1][0][-288:]
    left = (WIDTH - 384) // 2  # one image of 384 x 288 in the middle, 0.6 of its size
    inside = strip[:, left : left + 384]
    assert like(inside[200:280, 20:150], (GREY, GREY, GREY), 6).all()
    rows, columns = np.nonzero(like(inside, BOX, 60)[95:])  # below the score
    assert (columns.min(), columns.max()) == pytest.approx((300 * 0.6, 382 * 0.6), abs=2.5)
    assert 95 + rows.max() == pytest.approx(350 * 0.6, abs=2.5)


def test_without_cameras_the_video_is_the_map_alone(tmp_path: Path):
    ticks = [tick(i, people=[person()], tracks=[track()]) for i in range(6)]
    record(tmp_path / "none.mp4", make_world("walker"), ticks)
    record(tmp_path / "unused.mp4", with_camera(), ticks, show_cameras=False)
    for name in ("none.mp4", "unused.mp4"):
        facts, pictures = read(tmp_path / name)
        assert (facts["size"], facts["fps"], len(pictures)) == ((1920, 672), 10.0, 3)


def test_fast_cameras_give_as_many_pictures(tmp_path: Path):
    world = make_world("walker", cameras=[{**CAMERAS[0], "rate": 20.0}])
    record(tmp_path / "video.mp4", world, driving(6))
    facts, pictures = read(tmp_path / "video.mp4")
    assert (facts["fps"], len(pictures)) == (20.0, 6)


def test_images_of_any_size_and_seven_cameras_fit(tmp_path: Path):
    cameras = [{**CAMERAS[0], "name": f"camera{i}", "size": [640, 360] if i % 2 else [320, 480]} for i in range(7)]
    world = make_world("walker", cameras=cameras)
    images = [frame(camera) for camera in world.cameras]
    one = tick(0, people=[person()], frames=images, detections=[found(image) for image in images])
    record(tmp_path / "video.mp4", world, [one])
    assert read(tmp_path / "video.mp4")[0]["size"] == (1920, 960)


def test_a_run_that_breaks_off_leaves_a_readable_video(tmp_path: Path):
    recorder = VideoRecorder(tmp_path / "video.mp4", with_camera())
    for one in driving(8):
        recorder.record(one)
    broken = driving(9)[8]
    object.__setattr__(broken.decision, "costmap", None)
    with pytest.raises(AttributeError):
        recorder.record(broken)
    recorder.close()
    assert len(read(tmp_path / "video.mp4")[1]) == 4


def test_closing_twice_or_before_the_first_tick_does_no_harm(tmp_path: Path):
    recorder = VideoRecorder(tmp_path / "video.mp4", with_camera())
    recorder.close()
    recorder.close()
    assert not (tmp_path / "video.mp4").exists()


def test_an_encoder_that_cannot_write_is_told_in_one_sentence(tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    recorder = VideoRecorder(tmp_path / "missing" / "video.mp4", with_camera())
    with pytest.raises(HanError, match=r"video\.mp4.*encoder"):
        for one in 100 * driving(1):
            recorder.record(one)
    recorder.close()


def test_text_is_cut_at_the_pictures_border_and_stands_on_its_anchor():
    lettering, width = Lettering(), Lettering().width("robot", 15)
    for anchor, start in (("left", 100.0), ("centre", 100.0 + width / 2), ("right", 100.0 + width)):
        picture = np.zeros((40, 300, 3), np.uint8)
        lettering.write(picture, "robot", (start, 20.0), 15, (255, 255, 255), anchor=anchor)
        columns = np.nonzero(picture.max(axis=(0, 2)) > 100)[0]
        assert (columns.min(), columns.max()) == pytest.approx((101, 100 + width - 1), abs=2)
    cut = np.zeros((40, 20, 3), np.uint8)
    lettering.write(cut, "a long text", (-30.0, 38.0), 15, (255, 255, 255), halo=(9, 9, 9))
    lettering.write(cut, "elsewhere", (500.0, -90.0), 15, (255, 255, 255))
    assert 0 < np.count_nonzero(cut.max(axis=2) > 100) < cut[..., 0].size


def test_a_long_description_is_cut_between_words():
    lettering = Lettering()
    text = "the robot overtakes on the left"
    assert lettering.shorten(text, 14, 1000.0) == text
    short = lettering.shorten(text, 14, lettering.width("the robot overtakes …", 14))
    assert short == "the robot overtakes …"
    assert lettering.shorten(text, 14, 3.0) == ""


def test_the_same_tick_gives_the_same_picture_whatever_number_of_threads_opencv_uses():
    before = cv2.getNumThreads()
    pictures = []
    try:
        for threads in (1, 2):
            cv2.setNumThreads(threads)
            pictures.append(VideoRecorder(Path("unused.mp4"), with_camera()).draw(driving(1)[0]).copy())
    finally:
        cv2.setNumThreads(before)
    assert np.array_equal(pictures[0], pictures[1])


def test_a_noticed_fault_stands_in_the_title_and_on_its_image_whose_unused_boxes_are_grey(tmp_path: Path) -> None:
    world, (healthy,) = with_camera(), driving(1)
    fault = Fault(CAMERA.name, "frozen", 0.0)
    faulty = replace(healthy, decision=replace(healthy.decision, faults=(fault,), scans=()))
    pictures = []
    for name, one in (("healthy", healthy), ("faulty", faulty)):
        recorder = VideoRecorder(tmp_path / f"{name}.mp4", world)
        recorder.record(one)
        pictures.append(recorder.draw(one).copy())
        recorder.close()
    for picture, letters, boxes in zip(pictures, (False, True), (True, False), strict=True):
        assert like(picture[:TITLE_HEIGHT], FAULT).any() == letters
        assert like(picture[-CAMERA_HEIGHT:], FAULT).any() == letters
        assert like(picture[-CAMERA_HEIGHT:], BOX, 10).any() == boxes


def test_every_status_has_a_colour_to_be_shown_in():
    assert set(STATUS_COLOURS) == set(Status)


def test_a_robot_without_a_task_has_no_goal_in_the_picture():
    picture = VideoRecorder(Path("unused.mp4"), with_camera()).draw(tick(0, robot=(2.0, 1.0, 0.0)))
    column, row = place_of(with_camera(), (18.0, 0.0)).astype(int)
    assert not like(picture[row - 1 : row + 2, column - 1 : column + 2], GOAL, 1).any()
