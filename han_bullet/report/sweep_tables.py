"""The tables of a sweep: what passed, variants against a baseline, and assumptions halved and doubled."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from han_bullet.assumptions import JOINT
from han_bullet.paired_statistics import Comparison, compare, share_interval
from han_bullet.report.compared import COMPARED, Figure, minimum_distances
from han_bullet.report.markup import Html, breakable, element, explained, paragraph, table, together
from han_bullet.report.sweep_files import Sweep, SweepRow

SCALED = re.compile(r"scale:(?P<name>[^*+]+)\*(?P<factor>[0-9.]+(?:[eE][+-]?[0-9]+)?)")


def overview(sweep: Sweep) -> Html:
    """Return the table of passed runs by world and variant; of whichever there are fewer, each has a column."""
    variants = [variant for variant in sweep.variants if not SCALED.search(variant)]
    worlds = list(sweep.worlds)
    cells: dict[tuple[str, str], Html] = {}
    for variant in variants:
        cells |= {(world, variant): _passed(sweep.of(world, variant)) for world in worlds}
        cells["all", variant] = _passed([row for row in sweep.rows if row.variant == variant])
    worlds += ["all"] if len(worlds) > 1 else []
    if len(worlds) < len(variants):
        rows = [[breakable(variant), *(cells[world, variant] for world in worlds)] for variant in variants]
        return table(("variant", *map(breakable, worlds)), rows)
    rows = [[breakable(world), *(cells[world, variant] for variant in variants)] for world in worlds]
    return table(("world", *map(breakable, variants)), rows)


def _passed(rows: Sequence[SweepRow]) -> Html:
    """Return how many runs met all expectations, with Wilson's interval."""
    if not rows:
        return element("span", "–", class_="note")
    passed = sum(row.passed and row.error is None for row in rows)
    count = element("span", f"{passed} of {len(rows)}", class_="good" if passed == len(rows) else "bad")
    within = share_interval(passed, len(rows))
    between = element("span", f"({within.low:.0%} to {within.high:.0%})", class_="note")
    return together([count, " ", between])


def comparison(sweep: Sweep, world: str, variant: str, baseline: str) -> Html:
    """Return the table of one variant against the baseline in one world."""
    ours, theirs = sweep.of(world, variant), sweep.of(world, baseline)
    rows, equal = [], []
    for figure in (*COMPARED, *minimum_distances([*ours, *theirs]).values()):
        found = compare(_by_seed(ours, figure), _by_seed(theirs, figure))
        if found is not None and found.equal:
            equal.append(f"{figure.label} ({_shown(figure, found.mean)})")
        elif found is not None:
            rows.append(_comparison_row(figure, found))
    names = (breakable(variant), breakable(baseline))
    headings = ("", "pairs", *names, "mean difference", "95 % interval", "ratio", "95 % interval", "")
    parts = [table(headings, rows)] if rows else []
    parts += [paragraph(f"Equal in every pair (mean): {'; '.join(equal)}.", class_="note")] if equal else []
    return together(parts) or paragraph("No seed has been run in both variants yet.", class_="note")


def _by_seed(rows: Sequence[SweepRow], figure: Figure) -> dict[int, float]:
    values = {row.seed: figure.value(row) for row in rows}
    return {seed: value for seed, value in values.items() if value is not None}


def _shown(figure: Figure, value: float) -> str:
    return f"{100.0 * value:.0f} %" if figure.is_share else f"{value:.3g}"


def _comparison_row(figure: Figure, found: Comparison) -> list[str]:
    def change(value: float) -> str:
        text = f"{100.0 * value:+.1f} pp" if figure.is_share else f"{value:+.3g}"
        return text.replace("-", "−")

    within, ratio_within = found.interval, found.ratio_interval
    return [
        explained(figure.label, figure.definition),
        str(found.pairs),
        _shown(figure, found.mean),
        _shown(figure, found.baseline_mean),
        change(found.difference),
        "–" if within is None else _interval(change(within.low), change(within.high)),
        "–" if found.ratio is None else f"{found.ratio:.2f}",
        "–" if ratio_within is None else _interval(f"{ratio_within.low:.2f}", f"{ratio_within.high:.2f}"),
        _verdict(figure, found),
    ]


def _interval(low: str, high: str) -> str:
    return "all the same" if low == high else f"{low} to {high}"


def _verdict(figure: Figure, found: Comparison) -> Html:
    """Say in a word, not by colour alone, which way a difference points whose interval leaves zero out."""
    if not found.is_clear:
        return Html("")
    more = found.difference > 0.0
    if not figure.better:
        return element("b", "more" if more else "less")
    good = more == (figure.better == "more")
    return element("span", "better" if good else "worse", class_="good" if good else "bad")


@dataclass(frozen=True)
class Assumption:
    """A variant that scales one assumption.

    Attributes:
        variant: As a whole.
        name: Of the assumption.
        factor: By which it is scaled.
        unchanged: The variant without that.
    """

    variant: str
    name: str
    factor: float
    unchanged: str


def assumptions(variants: Sequence[str]) -> list[Assumption]:
    """Return the variants that scale one assumption, `scale:NAME*FACTOR`."""
    found = []
    for variant in variants:
        words = JOINT.split(variant)
        scaled = [(word, match) for word in words if (match := SCALED.fullmatch(word))]
        if len(scaled) == 1:
            ((word, match),) = scaled
            unchanged = "+".join(other for other in words if other != word)
            found.append(Assumption(variant, match["name"], float(match["factor"]), unchanged))
    return found


def sensitivity(sweep: Sweep) -> Html | None:
    """Return how often runs pass with each assumption scaled, against unchanged; None where none is."""
    found = assumptions(sweep.variants)
    if not found:
        return None
    factors = sorted({assumption.factor for assumption in found} | {1.0})
    rows = []
    for world in sweep.worlds:
        for name, unchanged in dict.fromkeys((assumption.name, assumption.unchanged) for assumption in found):
            variants = {a.factor: a.variant for a in found if (a.name, a.unchanged) == (name, unchanged)}
            if any(sweep.of(world, variant) for variant in variants.values()):
                cells = [sweep.of(world, (variants | {1.0: unchanged}).get(factor, "")) for factor in factors]
                rows.append([*map(breakable, (world, name, unchanged)), *map(_passed, cells)])
    headings = ("world", "assumption", "else as", *("unchanged" if f == 1.0 else f"× {f:g}" for f in factors))
    return table(headings, rows, words=3)
