"""The tables of sweeps that RESULTS.md keeps: counted and paired from rows, and left alone by other benchmarks."""

from pathlib import Path
from typing import Any

import pytest

from benchmarks import results
from benchmarks.sweep_tables import section
from han_bullet.sweep_rows import COLUMNS, write_row


def write(out: Path, variant: str, seed: int, passed: bool = True, **metrics: float | None) -> None:
    common: dict[str, Any] = dict.fromkeys(COLUMNS.names)
    common |= {"world": "real3", "variant": variant, "seed": seed, "outcome": "arrived", "passed": passed}
    common |= {"failed": "" if passed else "spl = 0.2, expected >= 0.5", "folder": f"runs/{seed}", "git_commit": "abc"}
    common |= {"world_sha256": "0", "real_time_factor": 1.0}
    values = common | {f"metric.{name}": value for name, value in metrics.items()}
    write_row(out / f"rows/{variant.replace(':', '=')}.{seed}.parquet", values, dict.fromkeys(metrics, "1"))


def test_passes_touches_and_pairs_are_counted(tmp_path: Path) -> None:
    for seed in range(6):
        write(
            tmp_path,
            "truth",
            seed,
            passed=seed != 3,
            **{"contacts_person": 0.0, "mota": 0.9 + 0.01 * seed, "personal_space_intrusion": 0.01 + 0.001 * seed},
            **{"transit_time_on.tv": 0.0, "replan_delay.tv": 0.05},
        )
        write(
            tmp_path,
            "truth+without:social",
            seed,
            **{"contacts_person": float(seed == 0), "mota": 1.0, "personal_space_intrusion": 0.05},
            **{"transit_time_on.tv": 0.5 * (seed > 0), "replan_delay.tv": 0.05},
        )
    text = section(tmp_path)
    assert "| real3 | truth | **5 of 6** | 44% to 97% | 0 | 0 | - | 0.925 (0.900) | - |" in text
    assert "| real3 | truth+without:social | **6 of 6** | 61% to 100% | 1 | 0 |" in text
    assert "| real3 | personal_space_intrusion | 6 | 0.0125 | 0.0500 | 0.25 |" in text
    assert "| real3 | truth | 0 of 6 |" in text and "| real3 | truth+without:social | 5 of 6 |" in text
    assert text.endswith("- real3, truth, seed 3: spl = 0.2, expected >= 0.5")


def test_scaled_assumptions_stand_beside_the_unchanged(tmp_path: Path) -> None:
    write(tmp_path, "truth", 0)
    write(tmp_path, "truth+scale:interaction.gamma*0.5", 0, passed=False)
    text = section(tmp_path)
    assert "| unchanged |  | truth | 1 of 1 |" in text and "| interaction.gamma | x 0.5 | truth | 0 of 1 |" in text


def test_sweeps_and_what_bench_measures_leave_each_other_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(results, "RESULTS", tmp_path / "RESULTS.md")
    results.write_measured("# Results\n\nfirst")
    results.write_sweeps("rows")
    results.write_measured("# Results\n\nsecond")
    assert (tmp_path / "RESULTS.md").read_text() == "# Results\n\nsecond\n\n## Sweeps\n\nrows\n"
    with (tmp_path / "RESULTS.md").open("a") as file:
        file.write("\n## Measured apart\n\n| in turn |\n")
    results.write_sweeps("more rows")
    results.write_measured("# Results\n\nthird")
    parts = ("# Results\n\nthird\n", "## Sweeps\n\nmore rows\n", "## Measured apart\n\n| in turn |\n")
    assert (tmp_path / "RESULTS.md").read_text() == "\n".join(parts)
