import copy
import json
from pathlib import Path
from typing import Any

import pytest

from han_bullet.errors import BadInputError
from han_bullet.variation import vary
from han_bullet.world_file import find_world, json_schema, load_world, parse_world, read_yaml, save_world, world_names
from han_bullet.world_schema import CeilingCamera

DOCS = Path(__file__).parent.parent / "docs"


@pytest.fixture
def document() -> dict[str, Any]:
    return copy.deepcopy(read_yaml(find_world("real2").read_text()))


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
