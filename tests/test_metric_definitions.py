"""The definitions: complete, honest about thresholds and polarity, equal to the page, and alive in runs."""

import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray

from han_bullet.detection.detector import Detector
from han_bullet.messages import Detections
from han_bullet.metrics import DEFINITIONS, GROUPS, TALLIES
from han_bullet.metrics.page import page
from han_bullet.runner import RunOptions, RunResult, run_world
from han_bullet.world_file import find_world

ROOT = Path(__file__).parent.parent
UNITS = {"", "1", "m", "s", "rad", "m/s", "m/s^2", "m/s^3", "rad/m"}
# Neither more nor less of these is better in itself.
NEUTRAL = {
    "outcome",
    "shortest_path_length",
    "mean_speed",
    "max_speed",
    "replans",
    "social_zone_share",
    "public_zone_share",
    "overtaking_side",
    "passing_side",
    "transit_time_off",
    "hand_over_distance",
    "detections_per_frame",
}
# Which have no value where nothing of the kind happened, so that they must say so.
MAY_BE_NONE = {
    "time_to_goal",
    "path_irregularity",
    "path_change_mean",
    "minimum_time_to_collision",
    "distance_when_level",
    "passing_side",
    "replan_delay",
    "hand_over_distance",
    "hand_over_early_bearing",
    "person_position_rmse",
    "heading_error_rmse",
    "mota",
    "tracked_share",
    "time_to_first_track",
    "time_to_notice_walking",
    "detection_recall",
    "frame_age_mean",
}


def test_each_name_is_defined_by_one_tally() -> None:
    assert len(DEFINITIONS) == sum(len(tally.definitions) for tally in TALLIES)
    assert GROUPS.keys() == DEFINITIONS.keys()


@pytest.mark.parametrize("name", DEFINITIONS)
def test_a_definition_names_unit_and_polarity(name: str) -> None:
    definition = DEFINITIONS[name]
    assert definition.unit in UNITS
    assert (definition.better == "") == (name in NEUTRAL)
    assert definition.better == "" or definition.statement.endswith(f"; {definition.better} is better")
    assert len(definition.text) > 20 and not definition.text.endswith(".")


@pytest.mark.parametrize("name", [name for name in DEFINITIONS if re.search("distance|gap|zone|phantom_tracks", name)])
def test_a_distance_to_people_says_between_what(name: str) -> None:
    assert re.search("centre|surface|that moment", DEFINITIONS[name].text)


@pytest.mark.parametrize("name", sorted(MAY_BE_NONE))
def test_a_metric_that_may_have_no_value_says_when(name: str) -> None:
    assert re.search(r"\bnone\b", DEFINITIONS[name].text)


THRESHOLDS = {
    "contacts_person": ["0.5 s", "0.05 m/s", "<= 0 m"],
    "stalled_time": ["0.05 m/s"],
    "failure_to_progress": ["5 s", "0.1 m"],
    "path_irregularity": ["0.1 m"],
    "path_switches": ["0.5 m", "0.1 m"],
    "intimate_zone_share": ["[0, 0.45) m"],
    "personal_zone_share": ["[0.45, 1.2) m"],
    "social_zone_share": ["[1.2, 3.6) m"],
    "personal_space_share": ["g > 0.5"],
    "personal_space_intrusion": ["0.5 m", "2 s"],
    "minimum_time_to_collision": ["0.25 m"],
    "overtaking_side": ["0.05 m/s", "2.5 m"],
    "hand_over_early_bearing": ["1.2 m"],
    "person_position_rmse": ["1 s", "1 m"],
    "mota": ["1 m", "all ticks"],
    "ospa": ["order 2", "cut-off 1 m"],
    "detection_recall": ["1 m", "114 px"],
}


@pytest.mark.parametrize(("name", "quoted"), THRESHOLDS.items())
def test_a_definition_quotes_its_thresholds(name: str, quoted: list[str]) -> None:
    assert [one for one in quoted if one not in DEFINITIONS[name].text] == []


def test_the_page_equals_the_definitions() -> None:
    assert (ROOT / "docs/metrics.md").read_text() == page()
    columns = {len(re.findall(r"(?<!\\)\|", line)) for line in page().splitlines() if line.startswith("|")}
    assert columns == {5}


class Anybody(Detector):
    """Finds somebody in the middle of every image."""

    def detect(self, image: NDArray[np.uint8]) -> Detections:
        return Detections(np.array([[300.0, 200.0, 60.0, 150.0]]), np.array([2.5]), np.array([0.75]))


def produced(result: RunResult) -> set[str]:
    return {metric.name.split(".")[0] for metric in result.metrics if metric.value is not None}


@pytest.mark.scenario
def test_every_metric_is_produced_by_some_run_of_a_shipped_world(tmp_path: Path) -> None:
    found = produced(run_world("sim2", RunOptions(perception="truth", video=False), tmp_path / "truth"))
    there = {"kind": "go_to", "pose": [1.5, 0.0, 0.0]}  # where the robot stands: it arrives
    document = yaml.safe_load(find_world("real2").read_text()) | {"duration": 0.2, "task": there}
    brief = tmp_path / "brief.yaml"
    brief.write_text(yaml.safe_dump(document))
    options = RunOptions(video=False, cameras=("camera1", "onboard"))
    found |= produced(run_world(brief, options, tmp_path / "cameras", detector=Anybody()))
    assert set(DEFINITIONS) - found == set()
