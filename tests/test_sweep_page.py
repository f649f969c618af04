"""The page of a sweep: counts, paired tables, what is missing, what failed; from rows made by hand."""

import base64
import re
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from test_run_page import Outline

from han_bullet.errors import BadInputError
from han_bullet.report.charts import ROBOT, VERMILION
from han_bullet.report.compared import COMPARED
from han_bullet.report.sweep_files import is_sweep, read_sweep
from han_bullet.report.sweep_page import MOST_SMALL_MAPS, write_sweep_page
from han_bullet.report.sweep_tables import assumptions, comparison, overview, sensitivity
from han_bullet.world_file import load_world, save_world
from han_bullet.world_schema import Expectation

TRACE_HEADER = (
    "time,robot.x,robot.y,robot.yaw,robot.vx,robot.vy,robot.omega,walker.x,walker.y,walker.yaw,walker.posture"
)


def write_row(out: Path, world: str, variant: str, seed: int, traced: bool = False, **changes: Any) -> None:
    """Write the row of a run in which the robot passes a walker, and its trace where that is wanted."""
    folder = f"runs/{world}/{variant}/{seed}"
    row: dict[str, Any] = {
        **{"world": world, "variant": variant, "seed": seed, "perception": "truth", "association": ""},
        **{"pass_side": "left", "without": "", "cameras": "", "threshold": None, "outcome": "arrived", "passed": True},
        **{"failed": "", "error": None, "folder": folder, "simulated_s": 15.0, "loop_s": 5.0, "real_time_factor": 3.0},
        **{"git_commit": "abc", "world_sha256": "0" * 64, "metric.time_to_goal": 15.0 + 0.1 * seed},
        **{"metric.minimum_distance.walker": 1.0 + 0.01 * seed, "metric.overtaking_side.walker": "left"},
    }
    row |= changes
    schema = pa.schema([("threshold", pa.float64()), ("error", pa.string())])
    table = pa.Table.from_pylist([row])
    for name, kind in zip(schema.names, schema.types, strict=True):
        table = table.set_column(table.schema.get_field_index(name), name, pa.array([row[name]], kind))
    (out / "rows").mkdir(parents=True, exist_ok=True)
    pq.write_table(table, out / "rows" / f"{len(list((out / 'rows').iterdir())):06d}.parquet")
    if traced:
        (out / folder).mkdir(parents=True)
        lines = [f"{0.05 * i:.6f},{0.05 * i},0.0,0.0,1.0,0.0,0.0,{3 + 0.02 * i},-0.5,0.0,walking" for i in range(40)]
        (out / folder / "trace.csv").write_text("\n".join([TRACE_HEADER, *lines]) + "\n")


def page_of(out: Path, baseline: str | None = None) -> Outline:
    return Outline(write_sweep_page(out, baseline).read_text(encoding="utf-8"))


def words(html: str) -> str:
    return " ".join(re.sub(r"<[^>]*>", " ", html).split())


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """Eight seeds of one world in two variants, the second slower and twice not passed; one run of it died."""
    for seed in range(8):
        write_row(tmp_path, "real2", "cameras", seed, traced=seed < 2)
        failed = {"passed": False, "failed": "minimum_distance.walker"} if seed < 2 else {}
        slower = {"metric.time_to_goal": 17.0 + 0.11 * seed}
        write_row(tmp_path, "real2", "truth", seed, traced=seed < 2, **slower, **failed)
    dead = {"outcome": "", "error": "WorkerDiedError: gone", "passed": False, "metric.time_to_goal": None}
    write_row(tmp_path, "real2", "truth", 8, **dead, real_time_factor=None)
    return tmp_path


def test_the_page_stands_alone_and_names_worlds_variants_and_seeds(out: Path) -> None:
    found = page_of(out)
    assert "17 runs: 1 worlds, 2 variants, 9 seeds" in found.text
    ours = [address for address in found.addresses if not address.startswith(("data:", "#"))]
    assert ours == ["runs/real2/truth/0/", "runs/real2/truth/1/", "runs/real2/truth/8/"]  # the failures' folders
    assert not {"script", "link"} & set(found.tags)


def test_the_overview_counts_what_passed_with_wilsons_interval(out: Path) -> None:
    told = words(overview(read_sweep(out)))
    assert "8 of 8 (68% to 100%)" in told  # z^2 = 3.84: 8 / (8 + 3.84)
    assert "6 of 9" in told  # the run that died did not pass


def test_differences_are_paired_by_seed_and_a_clear_one_is_judged_in_a_word(out: Path) -> None:
    told = words(comparison(read_sweep(out), "real2", "truth", "cameras"))
    row = told.split("time to goal [s]")[1]
    assert row.split()[:4] == ["8", "17.4", "15.3", "+2.04"] and "worse" in row.split("minimum")[0]
    assert "minimum distance to walker [m] (1.03)" in told.split("Equal in every pair")[1]


def test_the_baseline_is_cameras_unless_another_is_asked_for(out: Path) -> None:
    assert "real2: truth against cameras" in page_of(out).text
    assert "real2: cameras against truth" in page_of(out, "truth").text
    with pytest.raises(BadInputError, match=r"baseline 'nn' is no variant of .* it has cameras, truth"):
        page_of(out, "nn")


def test_what_is_missing_is_told(out: Path) -> None:
    write_row(out, "sim1", "cameras", 3)
    text = page_of(out).text
    assert "18 runs are missing" in text  # cameras' seed 8, eight of sim1's cameras and nine of its truth
    assert "0 to 2, 4 to 8" in text


def test_failures_are_listed_with_their_reason_and_their_ways(out: Path) -> None:
    text = page_of(out).text.split("Runs that did not meet everything")[-1]
    assert text.count("minimum_distance.walker") == 2 and "error: WorkerDiedError: gone" in text


def pictures_of(page: Path) -> dict[str, str]:
    """Return the page's pictures by what is said instead of them."""
    found = re.findall(r'<img src="data:image/svg\+xml;base64,([^"]+)" alt="([^"]+)"', page.read_text(encoding="utf-8"))
    return {alternative: base64.b64decode(content).decode() for content, alternative in found}


def test_a_way_that_failed_is_vermilion_and_dashed_on_both_maps(out: Path) -> None:
    pictures = pictures_of(write_sweep_page(out))
    for name, failed in (("Ways of real2, truth, seed 0", 1), ("Ways of all seeds of truth in real2", 2)):
        robots = re.findall(rf'<path [^>]*stroke="{VERMILION}"[^>]*>', pictures[name])
        assert len(robots) == failed and all("stroke-dasharray" in robot for robot in robots)
        assert ROBOT not in pictures[name]
    assert VERMILION not in pictures["Ways of all seeds of cameras in real2"]


def test_no_person_has_the_colour_of_what_failed(out: Path) -> None:
    folder = out / "runs/real2/cameras/0"
    people = [f"{name}.{what}" for name in "abcdef" for what in ("x", "y", "yaw", "posture")]
    line = "0.05,1,0,0,1,0,0" + ",3,0.5,0,standing" * 6
    header = ",".join([*TRACE_HEADER.split(",")[:7], *people])
    (folder / "trace.csv").write_text("\n".join([header, line, line]) + "\n")
    assert VERMILION not in pictures_of(write_sweep_page(out))["Ways of all seeds of cameras in real2"]


def test_of_many_failures_the_first_few_of_each_variant_have_a_map_and_the_page_says_so(out: Path) -> None:
    assert "failures have a map" not in page_of(out).text
    for variant in ("truth+nn", "truth+gnn"):
        for seed in range(MOST_SMALL_MAPS + 2):
            write_row(out, "real2", variant, seed, traced=True, passed=False, failed="outcome = blocked")
    page = write_sweep_page(out)
    small = [name for name in pictures_of(page) if name.startswith("Ways of real2, truth+")]
    assert len(small) == 2 * MOST_SMALL_MAPS
    assert f"Of each world and variant the first {MOST_SMALL_MAPS} failures have a map." in page_of(out).text


def test_the_least_distance_is_the_one_that_the_world_expects(out: Path) -> None:
    world = load_world("real2")
    changed = (Expectation(metric="minimum_distance.walker", at_least=0.95),)
    save_world(world.model_copy(update={"expectations": changed}), out / "runs/real2/cameras/0/world.yaml", "changed")
    drawn = pictures_of(write_sweep_page(out))["Minimum distance to each person in real2, by variant"]
    assert "walker: at least 0.95 m expected" in drawn and "0.75" not in drawn


def test_a_world_that_cannot_be_read_is_told_beside_the_ways(out: Path) -> None:
    broken = out / "runs/real2/truth/0/world.yaml"
    assert "no map: 0 has no world.yaml" in page_of(out).text
    broken.write_text("name: [")
    assert f"no map: {broken}: not readable as YAML" in " ".join(page_of(out).text.split())


def test_worlds_or_variants_of_which_there_are_fewer_have_the_columns(tmp_path: Path) -> None:
    for variant in ("cameras", "truth", "truth+mirrored"):
        write_row(tmp_path, "real2", variant, 0)
    assert words(overview(read_sweep(tmp_path))).startswith("variant real2 cameras 1 of 1")
    for world in ("real1", "real3", "sim1"):
        write_row(tmp_path, world, "truth", 0)
    assert words(overview(read_sweep(tmp_path))).startswith("world cameras truth truth+ mirrored real1")


def test_rows_of_others_never_become_markup(out: Path) -> None:
    evil = "<script>alert(1)</script>"
    write_row(out, evil, evil, 0, error=evil, passed=False, failed=evil, outcome=evil, git_commit=evil)
    page = write_sweep_page(out).read_text(encoding="utf-8")
    assert "<script" not in page and evil in Outline(page).text


def test_the_same_rows_give_the_same_page(out: Path) -> None:
    assert write_sweep_page(out).read_bytes() == write_sweep_page(out).read_bytes()


def test_scaled_assumptions_have_a_table_of_their_own(out: Path) -> None:
    assert sensitivity(read_sweep(out)) is None
    for seed in range(8):
        write_row(out, "real2", "truth+scale:walking*0.5", seed, passed=seed > 4)
        write_row(out, "real2", "truth+scale:walking*2", seed)
    sweep = read_sweep(out)
    told = words(sensitivity(sweep) or "")
    assert told.startswith("world assumption else as × 0.5 unchanged × 2 real2 walking truth 3 of 8")
    assert told.index("3 of 8") < told.index("6 of 9") < told.index("8 of 8")
    assert "scale:" not in words(overview(sweep))
    assert "truth+scale:walking*0.5 against" not in page_of(out).text


BIG = "truth+scale:d*1e+06"


def test_variants_that_scale_nothing_or_two_things_are_no_assumptions() -> None:
    found = assumptions(["truth", "truth+scale:a_b*0.5+mirrored", "scale:a*2+scale:b*2", "cameras+scale:c*x", BIG])
    assert [(a.name, a.factor, a.unchanged) for a in found] == [
        ("a_b", 0.5, "truth+mirrored"),
        ("d", 1e6, "truth"),
    ]


def test_a_sweep_of_one_variant_has_nothing_to_compare(tmp_path: Path) -> None:
    write_row(tmp_path, "real2", "truth", 0)
    assert "There is one variant, so nothing to compare." in page_of(tmp_path).text


def test_what_is_no_row_is_refused_in_one_sentence(tmp_path: Path) -> None:
    assert not is_sweep(tmp_path)
    (tmp_path / "rows").mkdir()
    (tmp_path / "rows" / "0.parquet").write_bytes(b"nothing")
    assert is_sweep(tmp_path)
    with pytest.raises(BadInputError, match=r"0\.parquet: not a row of a sweep"):
        read_sweep(tmp_path)
    pq.write_table(pa.table({"world": ["a"]}), tmp_path / "rows" / "0.parquet")
    with pytest.raises(BadInputError, match="rows without the columns of a sweep"):
        read_sweep(tmp_path)


def test_every_compared_figure_reads_a_metric_that_runs_have(out: Path) -> None:
    from han_bullet.metrics import DEFINITIONS
    from han_bullet.report.sweep_files import SweepRow

    class Asked(SweepRow):
        names: list[str] = []  # noqa: RUF012  (of this test alone)

        def people_values(self, name: str) -> list[Any]:
            self.names.append(name)
            return []

    row = read_sweep(out).rows[0]
    asked = Asked(**{name: getattr(row, name) for name in row.__dataclass_fields__})
    for figure in COMPARED:
        figure.value(asked)
    assert len(Asked.names) >= len(COMPARED) - 2 and set(Asked.names) <= set(DEFINITIONS)
