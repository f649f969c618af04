"""The file of results: what `make bench` measures, then the sweeps, which are made once and kept."""

from pathlib import Path

from han_bullet.atomic_file import write_at_once

RESULTS = Path(__file__).with_name("RESULTS.md")
SWEEPS = "\n## Sweeps\n"


def write_measured(text: str) -> None:
    """Replace what `make bench` measures; the sweeps stay."""
    _, heading, sweeps = _parts()
    write_at_once(RESULTS, (text.rstrip() + "\n" + heading + sweeps).encode())


def write_sweeps(text: str) -> None:
    """Replace the sweeps."""
    write_at_once(RESULTS, (_parts()[0].rstrip() + "\n" + SWEEPS + "\n" + text.rstrip() + "\n").encode())


def _parts() -> tuple[str, str, str]:
    return (RESULTS.read_text(encoding="utf-8") if RESULTS.is_file() else "").partition(SWEEPS)
