import copy
import json
from pathlib import Path
from typing import Any

import pytest

from han_bullet.errors import BadInputError
from han_bullet.variation import vary
from han_bullet.world_file import (
    json_schema,
    load_world,
    parse_world,
    read_yaml,
    save_world,
    world_document,
    world_files,
    world_names,
)
from han_bullet.world_schema import CeilingCamera

DOCS = Path(__file__).parent.parent / "docs"


@pytest.fixture
def document() -> dict[str, Any]:
    return copy.deepcopy(world_document("real2"))


def test_every_shipped_world_fits_the_schema_and_bears_its_files_name() -> None:
    assert {"real2", "sim1"} <= set(world_names())
    for name in world_names():
        assert load_world(name).name == name


def test_worlds_are_of_one_building_so_a_ceiling_camera_hangs_alike_in_all_but_one() -> None:
    cameras: dict[str, CeilingCamera] = {}
    for name in world_names():
        for camera in load_world(name).cameras:
            turned = (name, camera.name) == ("sim2", "camera4")  # and with a wider lens, to have the taker in view
            if isinstance(camera, CeilingCamera) and not turned:
                assert camera == cameras.setdefault(camera.name, camera), name
    assert cameras.keys() == {"camera1", "camera2", "camera3", "camera4"}


def test_a_world_survives_being_written_and_read() -> None:
    world = load_world("real2")
    assert parse_world(json.loads(world.model_dump_json())) == world


@pytest.mark.parametrize("name", world_names())
def test_the_world_that_a_seed_makes_survives_its_file(name: str, tmp_path: Path) -> None:
    concrete = vary(load_world(name), 3)
    save_world(concrete, tmp_path / "world.yaml", "a remark")
    assert (tmp_path / "world.yaml").read_text().startswith("# a remark\nname: ")
    assert load_world(tmp_path / "world.yaml") == concrete


def fault(document: dict[str, Any]) -> str:
    with pytest.raises(BadInputError) as caught:
        parse_world(document, source="my.yaml")
    message = str(caught.value)
    assert message.startswith("my.yaml: ") and "\n" not in message
    return message


def test_an_unknown_key_is_named_with_its_place(document: dict[str, Any]) -> None:
    document["people"][0]["behaviour"]["sped"] = 1.0
    assert "people[0].behaviour.sped: unknown key" in fault(document)


def test_a_misspelt_key_is_named_rather_than_the_one_it_hides(document: dict[str, Any]) -> None:
    behaviour = document["people"][0]["behaviour"]
    behaviour["waypoint"] = behaviour.pop("waypoints")
    assert "people[0].behaviour.waypoint: unknown key" in fault(document)


def test_a_kind_that_does_not_exist_is_named_with_those_there_are(document: dict[str, Any]) -> None:
    document["people"][0]["behaviour"] = {"kind": "standing"}
    assert "people[0].behaviour: kind is 'standing'; there are 'stand', 'sit', 'walk'" in fault(document)


def test_a_camera_period_that_is_no_multiple_of_the_control_period_is_refused(document: dict[str, Any]) -> None:
    document["cameras"][1]["rate"] = 7.0
    message = fault(document)
    assert "cameras[1]" in message and "0.05 s" in message and "10" in message


@pytest.mark.parametrize(
    ("laser", "named"),
    [
        ({"rate": 7.0}, ("robot.laser", "1/7 s", "0.05 s", "10")),
        ({"resolution": 0.7}, ("robot.laser", "270", "0.7", "0.5")),
        ({"height": 1.2}, ("robot.laser.height", "1.2", "0.6")),
        ({"field_of_view": 400.0}, ("robot.laser.field_of_view", "400", "360")),
        ({"noise": -0.01}, ("robot.laser.noise", "-0.01")),
        ({"range": 5.0}, ("robot.laser.range", "unknown key")),
    ],
)
def test_a_laser_that_cannot_be_is_refused(
    document: dict[str, Any], laser: dict[str, Any], named: tuple[str, ...]
) -> None:
    document["robot"]["laser"] = laser
    message = fault(document)
    assert all(part in message for part in named), message


def test_a_robot_has_a_laser_and_slips_unless_its_world_says_otherwise(document: dict[str, Any]) -> None:
    robot = parse_world(document).robot
    assert robot.laser is not None
    assert (robot.laser.ray_count, robot.laser.ticks_per_scan, robot.laser.range_max) == (541, 2, 8.0)
    assert robot.slip.distance > 0.0
    document["robot"] |= {"laser": None, "slip": {"distance": 0.0, "heading": 0.0, "turn": 0.0}}
    robot = parse_world(document).robot
    assert robot.laser is None
    assert robot.slip.heading == 0.0


def test_a_negative_speed_is_named_with_its_value(document: dict[str, Any]) -> None:
    document["people"][0]["behaviour"]["speed"] = -0.4
    message = fault(document)
    assert "people[0].behaviour.speed" in message and "-0.4" in message


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_numbers_that_are_not_finite_are_refused(document: dict[str, Any], value: float) -> None:
    document["robot"]["start"][0] = value
    assert "robot.start[0]" in fault(document)


def test_two_cameras_of_one_name_are_refused(document: dict[str, Any]) -> None:
    document["cameras"][1]["name"] = "camera1"
    assert "'camera1' is given twice" in fault(document)


@pytest.mark.parametrize("name", ["all", "laser", "wheels"])
def test_a_camera_cannot_have_a_name_that_means_something_else(document: dict[str, Any], name: str) -> None:
    document["cameras"][0]["name"] = name
    assert f"the name {name!r} stands for something else" in fault(document)


@pytest.mark.parametrize("name", ["all", "laser", "wheels"])
def test_a_device_cannot_have_a_name_that_means_something_else(document: dict[str, Any], name: str) -> None:
    document["devices"] = [{"name": name, "position": [3.0, 1.0], "facing": 0.0}]
    assert f"devices: the name {name!r} stands for something else" in fault(document)


def test_a_device_cannot_have_a_cameras_name(document: dict[str, Any]) -> None:
    document["devices"] = [{"name": "camera1", "position": [3.0, 1.0], "facing": 0.0}]
    assert "devices: the name 'camera1' is a camera's, too" in fault(document)


def test_furniture_cannot_have_a_devices_name(document: dict[str, Any]) -> None:
    document["furniture"] = [{"name": "tv", "position": [3.0, 0.0], "size": [0.5, 0.5, 0.5]}]
    document["devices"] = [{"name": "tv", "position": [3.0, 1.0], "facing": 0.0}]
    assert "the name 'tv' is a device's, too" in fault(document)


def test_a_seat_that_watches_no_known_device_is_refused(document: dict[str, Any]) -> None:
    document["sitting_areas"][0]["watches"] = "radio"
    assert "'radio'" in fault(document)


def test_an_expectation_without_a_bound_is_refused(document: dict[str, Any]) -> None:
    document["expectations"] = [{"metric": "outcome"}]
    assert "has no bound" in fault(document)


def test_a_missing_world_is_named_with_those_there_are() -> None:
    with pytest.raises(BadInputError, match=r"'real9' is not known; there are .*real2"):
        load_world("real9")


def test_a_file_that_is_no_yaml_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "broken.yaml"
    path.write_text("name: [unclosed")
    with pytest.raises(BadInputError, match=r"broken.yaml: not readable as YAML"):
        load_world(path)


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / f"{name}.yaml"
    path.write_text(text)
    return path


def test_a_file_that_extends_another_has_its_keys_and_replaces_those_it_gives_as_a_whole(tmp_path: Path) -> None:
    write(tmp_path, "rooms", "floor: [{x: [0, 9], y: [-2, 2]}]\nduration: 20.0\nlight: {ambient: 0.3, diffuse: 0.2}")
    write(tmp_path, "crowded", "extends: rooms\npeople: [{name: a, start: [5, 0, 0]}, {name: b, start: [6, 0, 0]}]")
    rest = "robot: {start: [1, 0, 0]}\ntask: {kind: go_to, pose: [8, 0, 0]}\nlight: {ambient: 0.5}"
    text = f"extends: crowded\nname: mine\ndescription: mine\npeople: [{{name: c, start: [4, 0, 0]}}]\n{rest}"
    path = write(tmp_path, "mine", text)
    world = load_world(path)
    assert (world.floor[0].x, world.duration) == ((0.0, 9.0), 20.0)
    assert [person.name for person in world.people] == ["c"]
    assert (world.light.ambient, world.light.diffuse) == (0.5, 0.4)  # the schema's default, not the base's 0.2
    assert [file.stem for file in world_files(path)] == ["mine", "crowded", "rooms"]


def test_a_file_of_ones_own_may_extend_a_shipped_one_and_prefers_the_one_beside_it(tmp_path: Path) -> None:
    path = write(tmp_path, "longer", "extends: real2\nname: longer\nduration: 61.0")
    assert load_world(path) == load_world("real2").model_copy(update={"name": "longer", "duration": 61.0})
    write(tmp_path, "real2", "extends: sim1\ndescription: beside")
    assert load_world(path).description == "beside"


def test_the_building_is_no_world_and_is_not_listed_as_one() -> None:
    assert "building" in {file.stem for file in world_files("real2")}
    assert "building" not in world_names()
    with pytest.raises(BadInputError, match=r"building.yaml: name: not given; a file without is no world"):
        load_world("building")


@pytest.mark.parametrize("name", ["../worlds/building", "/etc/passwd", "building.yaml", "", "a b", 3, "[building]"])
def test_what_is_no_plain_name_cannot_be_extended(tmp_path: Path, name: object) -> None:
    path = write(tmp_path, "mine", f"name: mine\nextends: {name}")
    with pytest.raises(BadInputError, match=r"mine.yaml: extends: .* is no name of a world file") as caught:
        load_world(path)
    assert "\n" not in str(caught.value)


def test_a_base_that_is_not_there_is_told_with_where_it_was_looked_for(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"mine.yaml: extends: 'castle' is not there; .*castle.yaml nor .*castle"):
        load_world(write(tmp_path, "mine", "name: mine\nextends: castle"))


def test_files_that_extend_each_other_in_a_circle_are_refused(tmp_path: Path) -> None:
    write(tmp_path, "b", "extends: c")
    write(tmp_path, "c", "extends: b")
    with pytest.raises(BadInputError, match=r"a.yaml: extends: a extends b extends c extends b, in a circle"):
        load_world(write(tmp_path, "a", "extends: b"))
    with pytest.raises(BadInputError, match=r"own.yaml: extends: own extends own, in a circle"):
        load_world(write(tmp_path, "own", "extends: own"))


def test_a_fault_in_what_a_file_extends_is_told_with_that_file(tmp_path: Path) -> None:
    write(tmp_path, "broken", "name: [unclosed")
    with pytest.raises(BadInputError, match=r"broken.yaml: not readable as YAML"):
        load_world(write(tmp_path, "mine", "extends: broken"))


def test_on_is_a_key_like_any_other() -> None:
    assert read_yaml("on: false") == {"on": False}


def test_walls_furniture_and_devices_become_boxes_where_the_file_puts_them() -> None:
    boxes = {box.name: box for box in load_world("real2").solid_boxes()}
    assert len(boxes) == 10
    assert boxes["couch"].contains(load_world("real2").seats()[0].position_in_world)
    assert boxes["tv"].centre_in_world[1] == pytest.approx(-3.4)
    assert boxes["wall0"].size == pytest.approx([16.0, 0.1, 2.8])


def test_the_published_schema_is_the_programs_own() -> None:
    assert json.loads((DOCS / "world_file.schema.json").read_text()) == json_schema()


def test_the_annotated_example_in_the_documentation_is_a_world() -> None:
    text = (DOCS / "world_file.md").read_text()
    example = read_yaml(text.split("```yaml\n")[1].split("```")[0])
    world = parse_world(example)
    assert world.people and world.cameras and world.devices and world.sitting_areas
