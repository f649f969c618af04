"""The page of a run: one file that stands alone, tells the outcome in words and escapes what it did not write."""

import argparse
import base64
import json
import re
import shlex
import shutil
from html.parser import HTMLParser
from pathlib import Path

import cv2
import imageio_ffmpeg
import numpy as np
import pytest
import yaml

from han_bullet.commands.fault_option import fault
from han_bullet.errors import BadInputError
from han_bullet.report import run_page
from han_bullet.report.film_still import middle_picture
from han_bullet.report.run_files import read_run_files
from han_bullet.report.run_moments import position_errors
from han_bullet.report.run_page import command_line, write_run_page
from han_bullet.run_folder import read_result
from han_bullet.runner import RunOptions, run_world
from han_bullet.world_file import find_world, read_yaml


class Outline(HTMLParser):
    """Collects tags, addresses and text, and checks that elements close in order."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.addresses: list[str] = []
        self.text = ""
        self.feed(page)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.addresses += [value for name, value in attrs if name in ("src", "href") and value]
        if tag == "img":
            assert dict(attrs)["alt"]
        if tag not in ("img", "meta", "wbr"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def outline(page: Path) -> Outline:
    return Outline(page.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of sim2 that ends after six seconds, when the television is on."""
    folder = tmp_path_factory.mktemp("run")
    document = read_yaml(find_world("sim2").read_text()) | {"duration": 6.0}
    path = folder / "short.yaml"
    path.write_text(yaml.safe_dump(document))
    run_world(path, RunOptions(seed=1, perception="truth", video=False), folder / "run")
    (folder / "run" / "world.yaml").write_text(path.read_text())
    return folder / "run"


@pytest.fixture
def run(recorded: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(recorded, tmp_path / "run"))


def change_result(folder: Path, **changes: object) -> None:
    path = folder / "result.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))


def test_the_page_stands_alone(run: Path) -> None:
    found = outline(write_run_page(run))
    assert found.tags.count("img") >= 2 and found.tags[0] == "html"
    assert all(address.startswith(("data:", "#")) for address in found.addresses)
    assert not {"script", "link", "iframe"} & set(found.tags)


def test_the_outcome_is_told_in_words(run: Path) -> None:
    text = outline(write_run_page(run)).text
    assert "sim2, seed 1" in text and "The robot ran out of time" in text and "expectations are not met" in text
    failed = sum(not check.passed for check in read_result(run).checks)
    assert failed > 0  # arrival and hand-over cannot be met in six seconds
    assert text.count("not met") == failed + 1 and f"{failed} of " in text
    for metric in read_result(run).metrics:
        assert metric.name in text and metric.definition in text


def test_all_met_is_told_too(run: Path) -> None:
    checks = [check | {"passed": True} for check in json.loads((run / "result.json").read_text())["checks"]]
    change_result(run, checks=checks, outcome="arrived")
    text = outline(write_run_page(run)).text
    assert f"all {len(checks)} expectations are met" in text and "not met" not in text


def test_names_of_others_never_become_markup(run: Path) -> None:
    evil = "<script>alert(1)</script>\"'&"
    result = json.loads((run / "result.json").read_text())
    metrics = [metric | {"name": evil, "value": evil, "unit": evil, "definition": evil} for metric in result["metrics"]]
    checks = [check | {"metric": evil, "expected": evil, "value": evil} for check in result["checks"]]
    versions = {evil: evil}
    change_result(run, world=evil, metrics=metrics, checks=checks, versions=versions, outcome=evil, git_commit=evil)
    trace = run / "trace.csv"
    trace.write_text(trace.read_text().replace("viewer", "<script>alert(2)</script>"))
    page = write_run_page(run)
    assert "<script" not in page.read_text(encoding="utf-8")
    assert evil in outline(page).text
    for picture in re.findall(r"data:image/svg\+xml;base64,([A-Za-z0-9+/=]+)", page.read_text(encoding="utf-8")):
        assert b"<script" not in base64.b64decode(picture)


def test_the_same_run_gives_the_same_page_every_time(run: Path) -> None:
    assert write_run_page(run).read_bytes() == write_run_page(run).read_bytes()


def test_without_its_world_a_run_is_told_without_a_map_and_the_page_says_so(run: Path) -> None:
    (run / "world.yaml").unlink()
    assert "No map is drawn: run has no world.yaml." in outline(write_run_page(run)).text


def test_a_world_that_cannot_be_read_is_told_with_its_fault(run: Path) -> None:
    (run / "world.yaml").write_text("name: [")
    text = outline(write_run_page(run)).text
    assert f"No map is drawn: {run / 'world.yaml'}: not readable as YAML" in " ".join(text.split())


def test_a_device_is_marked_when_the_robot_was_told_that_it_is_on(run: Path) -> None:
    read = read_run_files(run)
    assert read.world is not None
    tick = int(np.abs(read.trace.time - read.devices_on["tv"]).argmin())
    distance = np.hypot(*(read.trace.poses[:, :2] - read.world.devices[0].position).T)
    assert distance[tick] <= 4.0 < distance[tick - 1]  # as the world file says: the robot within 4 m
    text = outline(write_run_page(run)).text
    assert "Dotted lines mark when the robot was told" in text
    (run / "messages.csv").write_text("time,device,sent,on,session\n0.000000,tv,0.000000,0,simulator\n")
    assert read_run_files(run).devices_on == {} and "Dotted lines" not in outline(write_run_page(run)).text


def test_a_mirrored_run_says_so_on_top(run: Path) -> None:
    change_result(run, mirrored=True)
    assert outline(write_run_page(run)).text.strip().startswith("sim2, mirrored, seed 1")


def test_true_perception_has_no_errors_and_strangers_have_no_track(run: Path) -> None:
    read = read_run_files(run)
    assert all(np.nanmax(errors) < 1e-5 for errors in position_errors(read).values())
    (run / "tracks.csv").write_text("time,id,x,y,vx,vy,yaw,posture\n")
    assert all(np.isnan(errors).all() for errors in position_errors(read_run_files(run)).values())


def test_perception_is_shown_where_there_were_cameras(run: Path) -> None:
    assert "This run had no cameras" in outline(write_run_page(run)).text
    change_result(run, perception="cameras", cameras=["camera4"], association="nn", detector={"threshold": 9.5})
    text = outline(write_run_page(run)).text
    assert "when a confirmed track was matched" in text and "This run had no cameras" not in text
    assert "--cameras camera4 --association nn --threshold=9.5" in text


def test_a_small_video_is_in_the_page_and_a_large_one_beside_it(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (run / "video.mp4").write_bytes(b"film")
    assert f"data:video/mp4;base64,{base64.b64encode(b'film').decode()}" in outline(write_run_page(run)).addresses
    monkeypatch.setattr(run_page, "LARGEST_EMBEDDED", 3)
    found = outline(write_run_page(run))
    assert "video.mp4" in found.addresses and not any(address.startswith("data:video") for address in found.addresses)


def test_a_still_of_the_video_stands_for_it_until_it_plays(tmp_path: Path) -> None:
    film = tmp_path / "video.mp4"
    writer = imageio_ffmpeg.write_frames(str(film), (64, 48), fps=10, macro_block_size=16)
    writer.send(None)
    for level in (*[0] * 10, *[200] * 10, *[0] * 10):  # bright in its middle second
        writer.send(np.full((48, 64, 3), level, np.uint8))
    writer.close()
    still = middle_picture(film)
    assert still is not None
    assert cv2.imdecode(np.frombuffer(still, np.uint8), cv2.IMREAD_COLOR).mean() > 150.0
    film.write_bytes(b"film")
    assert middle_picture(film) is None


def test_the_command_line_makes_the_run_again(run: Path) -> None:
    change_result(run, layers=["static", "obstacle", "inflation", "body"], **{"pass": "right"})
    expected = "--without personal_walking,personal_still,visibility,interaction,overtake,oncoming --pass right"
    assert command_line(read_result(run)) == f"han-bullet run sim2 --seed 1 --perception truth {expected}"
    change_result(run, mirrored=True)  # whose own side is the right one
    assert command_line(read_result(run)).endswith("overtake,oncoming --mirrored")


def test_the_command_line_names_localization_detector_and_faults_where_they_were_not_the_usual_ones(run: Path) -> None:
    seen = {"perception": "cameras", "cameras": ["camera4"], "association": "nnjpda", "localization": "lidar"}
    usual = {"proposer": "acf_inria", "classifier": "cnn_inria", "threshold": 9.5}
    start = "han-bullet run sim2 --seed 1 --cameras camera4"
    change_result(run, detector=usual, **seen)
    assert command_line(read_result(run)) == f"{start} --threshold=9.5"
    hog = {"proposer": "hog", "classifier": None, "threshold": 0.5}
    change_result(run, detector=hog, **(seen | {"localization": "simulator"}))
    assert command_line(read_result(run)) == f"{start} --detector hog --threshold=0.5 --localization truth"
    knocked = {"kind": "knocked", "target": "camera4", "degrees": -3.0, "starts": {"delay": 5.0}}
    near = {"kind": "frozen", "target": "camera4", "starts": {"when": "robot_near"}}
    change_result(run, detector=usual | {"classifier": "mine"}, asked_faults=[knocked], **seen)
    assert command_line(read_result(run)) == f"{start} --classifier mine --threshold=9.5 --fault camera4=knocked:-3@5"
    assert "with faults that wait for an event" not in outline(write_run_page(run)).text
    change_result(run, asked_faults=[near])
    assert (
        "with faults that wait for an event, which only a world file or own code can"
        in outline(write_run_page(run)).text
    )


def test_a_mirrored_run_is_made_again_with_the_faults_that_were_asked_for_and_without_those_of_its_world_file(
    tmp_path: Path,
) -> None:
    document = read_yaml(find_world("real2").read_text())
    document |= {"duration": 0.2, "faults": [{"kind": "black", "target": "camera1"}]}
    path = tmp_path / "faulty.yaml"
    path.write_text(yaml.safe_dump(document))
    asked = fault("camera2=knocked:3@5")
    options = RunOptions(perception="truth", localization="truth", mirrored=True, video=False, faults=(asked,))
    run_world(path, options, tmp_path / "run")
    line = command_line(read_result(tmp_path / "run"))
    assert line.endswith("--perception truth --localization truth --mirrored --fault camera2=knocked:3@5")


@pytest.mark.parametrize("threshold", [10.934406280517578, -1e6])
def test_the_threshold_is_read_from_the_command_line_as_it_was(run: Path, threshold: float) -> None:
    detector = {"proposer": "acf_inria", "classifier": "cnn_inria", "threshold": threshold}
    change_result(run, perception="cameras", cameras=["camera4"], association="nnjpda", detector=detector)
    parser = argparse.ArgumentParser()
    parser.add_argument("--threshold", type=float)
    read, _ = parser.parse_known_args(shlex.split(command_line(read_result(run))))
    assert read.threshold == threshold


def test_the_command_line_of_a_run_with_a_scaled_assumption_is_not_said_to_be_all(run: Path) -> None:
    assert "which only han-bullet sweep can" not in outline(write_run_page(run)).text
    change_result(run, scaled=["interaction.gamma*0.5"])
    assert "with the assumptions below scaled, which only han-bullet sweep can" in outline(write_run_page(run)).text


def test_a_trace_whose_last_line_is_cut_is_read_up_to_there(run: Path) -> None:
    whole = len(read_run_files(run).trace.time)
    trace = run / "trace.csv"
    trace.write_text(trace.read_text()[:-40])
    assert len(read_run_files(run).trace.time) == whole - 1


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("result.json", "{", "result.json"),
        ("result.json", '{"world": "sim2"}', "world_sha256"),
        ("trace.csv", "", "trace.csv"),
        ("trace.csv", "time,robot.x\n0.0,1.0\n", "robot.y"),
        ("trace.csv", "time,robot.x,robot.y,robot.yaw,robot.vx,robot.vy\na,b,c,d,e,f\n", "trace.csv"),
        ("tracks.csv", "nothing\n", "tracks.csv"),
        ("messages.csv", "time,on\n0.0,1\n", "has no column 'device'"),
    ],
)
def test_a_file_that_no_run_wrote_is_named_in_one_sentence(run: Path, name: str, content: str, told: str) -> None:
    (run / name).write_text(content)
    with pytest.raises(BadInputError, match=told) as caught:
        write_run_page(run)
    assert "\n" not in str(caught.value)
    assert not (run / "report.html").exists()


def test_a_run_of_one_tick_and_without_people_has_a_page(run: Path) -> None:
    lines = (run / "trace.csv").read_text().splitlines()[:2]
    (run / "trace.csv").write_text("\n".join(",".join(line.split(",")[:7]) for line in lines) + "\n")
    assert "sim2" in outline(write_run_page(run)).text
