"""The file of results: what `make bench` measures, then the sweeps, which are made once and kept."""

from pathlib import Path

RESULTS = Path(__file__).with_name("RESULTS.md")
SWEEPS = "\n## Sweeps\n"


def write_measured(text: str) -> None:
    """Replace what `make bench` measures; the sweeps stay."""
    _, heading, sweeps = _parts()
    RESULTS.write_text(text.rstrip() + "\n" + heading + sweeps)


def write_sweeps(text: str) -> None:
    """Replace the sweeps."""
    RESULTS.write_text(_parts()[0].rstrip() + "\n" + SWEEPS + "\n" + text.rstrip() + "\n")


def _parts() -> tuple[str, str, str]:
    return (RESULTS.read_text() if RESULTS.is_file() else "").partition(SWEEPS)
