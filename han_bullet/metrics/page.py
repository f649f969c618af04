"""docs/metrics.md, made of the definitions: every metric, its statement, and what others call it."""

from __future__ import annotations

import re
from pathlib import Path

from han_bullet.atomic_file import write_at_once
from han_bullet.markdown import markdown_table
from han_bullet.metrics.run_metrics import DEFINITIONS, GROUPS
from han_bullet.metrics.tally import Definition

_TITLES = {
    "task": "Task: how it ended, and what it took",
    "motion": "Motion: how the robot moved and planned",
    "people": "People: how near, how long, on which side",
    "perception": "Perception: what it believed of people, inside the loop",
}
_OPENING = """# Metrics

Every run measures all of these from the simulator's truth; `result.json` has them with unit and definition, and
`han-bullet run` prints the ones in **bold** that came to something, and those that the world expects. Any of them can
stand in a world's `expectations`. Metrics of one person or device carry its name behind a dot:
`minimum_distance.walker`.

- Truth is the simulator's; a tick is a control period of 0.05 s; a metric without a value is `null`.
- Distances say whether they are between centres or surfaces. A run with the same seed has the same figures.
- *Elsewhere* says what HuNav, SEAN, SocNavBench, [Francis2023] and others call it, and where theirs differs; what none
  of them has and no source in the definition is *ours*. Mistakes of such programs that we met are in
  `tests/test_metric_defects.py`, each with the figure that is right.

This page is made of the definitions in `han_bullet/metrics/`, and a test holds it to them. Make it anew:
`python -c "from han_bullet.metrics.page import write; write('docs/metrics.md')"`.
"""


def page() -> str:
    """Return the page."""
    parts = [_OPENING]
    for group, title in _TITLES.items():
        rows = [
            (f"**`{name}`**" if one.headline else f"`{name}`", one.unit or "–", one.statement, _elsewhere(one))
            for name, one in DEFINITIONS.items()
            if GROUPS[name] == group
        ]
        parts.append(f"## {title}\n\n{markdown_table(('metric', 'unit', 'definition', 'elsewhere'), rows)}\n")
    return "\n".join(parts)


def _elsewhere(definition: Definition) -> str:
    """Return what others call a metric; one that neither others have nor a source defines is ours."""
    return definition.elsewhere or ("–" if re.search(r"\[[A-Z]\w+\d{4}\]", definition.text) else "ours")


def write(path: str | Path) -> None:
    """Write the page."""
    write_at_once(Path(path), page().encode())
