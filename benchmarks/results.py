"""The file of results: what `make bench` measures, the sweeps, which are made once, and what is measured with care."""

from pathlib import Path

from han_bullet.atomic_file import write_at_once

RESULTS = Path(__file__).with_name("RESULTS.md")
SWEEPS = "\n## Sweeps\n"
APART = "\n## Measured apart\n"  # two versions in turn, or beside ROS; written by hand


def write_measured(text: str) -> None:
    """Replace what `make bench` measures."""
    _write(text, *_parts()[1:])


def write_sweeps(text: str) -> None:
    """Replace the sweeps."""
    measured, _, apart = _parts()
    _write(measured, text, apart)


def _parts() -> tuple[str, str, str]:
    """Return what was measured, the sweeps, and what was measured apart."""
    before, _, apart = (RESULTS.read_text(encoding="utf-8") if RESULTS.is_file() else "").partition(APART)
    measured, _, sweeps = before.partition(SWEEPS)
    return measured, sweeps, apart


def _write(measured: str, sweeps: str, apart: str) -> None:
    parts = (
        measured.strip()
        + "\n"
        + "".join(
            heading + "\n" + text.strip() + "\n" for heading, text in ((SWEEPS, sweeps), (APART, apart)) if text.strip()
        )
    )
    write_at_once(RESULTS, parts.encode())
