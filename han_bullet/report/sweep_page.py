"""The page of a sweep."""

from __future__ import annotations

import itertools
import shlex
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from urllib.parse import quote

import numpy as np

from han_bullet.atomic_file import write_at_once
from han_bullet.errors import BadInputError
from han_bullet.report.markup import Html, breakable, captioned, element, more, paragraph, picture, table, together
from han_bullet.report.page import Section, page
from han_bullet.report.run_files import find_map
from han_bullet.report.sweep_charts import draw_all_ways, draw_minimum_distances, draw_small_map
from han_bullet.report.sweep_files import Sweep, SweepRow, read_sweep
from han_bullet.report.sweep_tables import SCALED, comparison, overview, sensitivity
from han_bullet.run_folder import read_table
from han_bullet.run_tables import Trace, trace_of
from han_bullet.world_schema import World

Maps = dict[tuple[str, bool], tuple[World | None, str]]  # by world and whether mirrored: the map, or None and why

MOST_SMALL_MAPS = 4  # of failures, of each world and variant
COMPARISON_NOTE = (
    "Both variants ran the same seeds, so differences are taken seed by seed. Intervals are 95 % bootstrap intervals "
    "over pairs (BCa, 10 000 resamples, fixed random seed) of the mean difference and of the ratio of the means; none "
    "is given below six pairs, where chance alone would leave zero out too often, nor for a ratio whose baseline has "
    "zeros. “better” and “worse” stand where the interval leaves zero out. Where nothing differs but by chance, about "
    "one interval in twenty does so with twenty pairs, and one in ten with ten. A figure counts the seeds that have it "
    "in both; pp are percentage points."
)


def write_sweep_page(folder: Path, baseline: str | None = None) -> Path:
    """Write report.html into the folder of a sweep and return its path.

    Args:
        folder: Of the sweep; it may still be running.
        baseline: Variant that the others are compared with; None: `cameras`, or else the first.

    Raises:
        BadInputError: The folder holds no sweep, or the sweep no such variant.
    """
    sweep = read_sweep(folder)
    path = folder / "report.html"
    write_at_once(path, sweep_page(sweep, sweep.baseline(baseline)))
    return path


def sweep_page(sweep: Sweep, baseline: str) -> bytes:
    """Return the page of a sweep, its variants compared with a baseline."""
    table_of_assumptions, maps = sensitivity(sweep), _maps(sweep)
    sections = [
        Section("comparisons", f"Compared with {baseline}", _comparisons(sweep, baseline)),
        *([Section("assumptions", "Assumptions", _assumptions(table_of_assumptions))] if table_of_assumptions else []),
        Section("distances", "How near the robot came", _distances(sweep, maps)),
        Section("ways", "All ways", _all_ways(sweep, maps)),
        Section("failures", "Runs that did not meet everything", _failures(sweep, maps)),
        Section("provenance", "Where this comes from", _provenance(sweep)),
    ]
    seeds = len({row.seed for row in sweep.rows})
    lead = f"{len(sweep.rows)} runs: {len(sweep.worlds)} worlds, {len(sweep.variants)} variants, {seeds} seeds"
    return page(f"Sweep “{sweep.folder.resolve().name}”", lead, _opening(sweep), sections)


def _opening(sweep: Sweep) -> Html:
    caption = "Runs that met every expectation of their world, with Wilson's 95 % interval of the share."
    parts = [paragraph(caption, class_="note"), overview(sweep)]
    gaps = sweep.missing()
    if gaps:
        count = sum(len(seeds) for _, _, seeds in gaps)
        parts.insert(0, element("p", f"{count} runs are missing; what follows is of the others.", class_="verdict bad"))
        parts.append(
            more(
                "What is missing",
                table(("world", "variant", "seeds"), [(w, v, _ranges(seeds)) for w, v, seeds in gaps], words=3),
            )
        )
    return together(parts)


def _ranges(seeds: Sequence[int]) -> str:
    """Return numbers in order, neighbours joined: 0 to 3, 7."""
    runs: list[list[int]] = []
    for seed in seeds:
        if runs and seed == runs[-1][-1] + 1:
            runs[-1].append(seed)
        else:
            runs.append([seed])
    return ", ".join(f"{run[0]} to {run[-1]}" if len(run) > 1 else str(run[0]) for run in runs)


def _comparisons(sweep: Sweep, baseline: str) -> Html:
    others = [variant for variant in sweep.variants if variant != baseline and not SCALED.search(variant)]
    if not others:
        return paragraph("There is one variant, so nothing to compare.")
    parts = [paragraph(COMPARISON_NOTE, class_="note")]
    for world in sweep.worlds:
        for variant in others:
            if sweep.of(world, variant) and sweep.of(world, baseline):
                heading = element("h3", f"{world}: {variant} against {baseline}")
                parts += [heading, comparison(sweep, world, variant, baseline)]
    return together(parts)


def _assumptions(rows: Html) -> Html:
    note = (
        "Runs that met every expectation with one assumption scaled, beside those with it unchanged. A value that "
        "would exceed the largest with a meaning is set to that one."
    )
    return together([paragraph(note, class_="note"), rows])


def _distances(sweep: Sweep, maps: Maps) -> Html:
    parts = []
    for world in sweep.worlds:
        known = next((found for (name, _), (found, _) in maps.items() if name == world and found is not None), None)
        drawn = draw_minimum_distances(sweep, world, known)
        if drawn is not None:
            alternative = f"Minimum distance to each person in {world}, by variant"
            parts.append(captioned(picture(drawn, alternative), f"{world}: one mark per run."))
    return together(parts)


def _maps(sweep: Sweep) -> Maps:
    """Return each world, and each mirrored one, as the first run had it that left a copy; or why there is none."""
    found: Maps = {}
    for world, mirrored in itertools.product(sweep.worlds, (False, True)):
        rows = (row for row in sweep.rows if row.world == world and row.is_mirrored == mirrored)
        folders = [sweep.folder / row.folder for row in rows]
        if folders:
            left = (folder for folder in folders if (folder / "world.yaml").is_file())
            found[world, mirrored] = find_map(next(left, folders[0]))
    return found


def _all_ways(sweep: Sweep, maps: Maps) -> Html:
    parts = []
    for world in sweep.worlds:
        figures = []
        for variant in sweep.variants:
            runs = list(_with_traces(sweep, sweep.of(world, variant)))
            if runs:
                known, why_not = maps[world, runs[0][0].is_mirrored]
                alternative = f"Ways of all seeds of {variant} in {world}"
                caption = f"{variant}: {len(runs)} runs" + (f"; no map: {why_not}" if known is None else "")
                figures.append(captioned(picture(draw_all_ways(known, runs), alternative), caption))
        parts += [element("h3", world), element("div", *figures, class_="pairs")]
    note = "Blue: the robot; vermilion and dashed where the run did not meet everything. Other colours: people."
    return together([paragraph(note, class_="note"), *parts])


def _with_traces(sweep: Sweep, rows: Sequence[SweepRow]) -> Iterator[tuple[SweepRow, Trace]]:
    """Yield the rows whose trace is there, with it."""
    for row in rows:
        trace = _trace_of(sweep, row)
        if trace is not None:
            yield row, trace


def _trace_of(sweep: Sweep, row: SweepRow) -> Trace | None:
    try:
        trace = trace_of(read_table(sweep.folder / row.folder / "trace.csv"))
    except BadInputError:
        return None  # the run died, or its folder was taken away; its row is still counted
    return trace if len(trace.time) else None


def _failures(sweep: Sweep, maps: Maps) -> Html:
    failed = [row for row in sweep.rows if row.error or not row.passed]
    if not failed:
        return paragraph("None.")
    drawn: Counter[tuple[str, str]] = Counter()
    rows = []
    for row in failed:
        cell = row.world, row.variant
        drawn[cell] += 1
        ways = _small_map(sweep, row, maps[row.world, row.is_mirrored][0]) if drawn[cell] <= MOST_SMALL_MAPS else ""
        link = element("a", breakable(row.folder), href=quote(row.folder) + "/")
        ended = f"error: {row.error}" if row.error else row.outcome
        rows.append([*map(breakable, cell), str(row.seed), ended, row.failed, link, ways])
    headings = ("world", "variant", "seed", "ended as", "not met", "folder", "ways")
    note = "Vermilion and dashed: the robot; other colours: people; dots where they end."
    if max(drawn.values()) > MOST_SMALL_MAPS:
        note += f" Of each world and variant the first {MOST_SMALL_MAPS} failures have a map."
    return together([paragraph(note, class_="note"), table(headings, rows, words=7)])


def _small_map(sweep: Sweep, row: SweepRow, known: World | None) -> str:
    """Return a picture of a run's ways; nothing where its trace is not there."""
    trace = _trace_of(sweep, row)
    if trace is None:
        return ""
    return picture(draw_small_map(known, row, trace), f"Ways of {row.world}, {row.variant}, seed {row.seed}")


def _provenance(sweep: Sweep) -> Html:
    commits = Counter(row.git_commit for row in sweep.rows)
    factors = [row.real_time_factor for row in sweep.rows if np.isfinite(row.real_time_factor)]
    example = f"{sweep.folder.resolve().name}/{sweep.rows[0].folder}"
    facts = {
        "folder": sweep.folder.resolve().name,
        "commit": ", ".join(f"{commit} ({count} runs)" for commit, count in commits.items()),
        "worlds": ", ".join(dict.fromkeys(f"{row.world} sha256 {row.world_sha256[:12]}" for row in sweep.rows)),
        "real-time factor": f"median {np.median(factors):.2f}, {min(factors):.2f} to {max(factors):.2f}"
        if factors
        else "–",
        "a page of one run, such as the first": element("code", f"han-bullet report {shlex.quote(example)}"),
    }
    mixed = [paragraph("Runs of more than one commit are mixed here.", class_="bad")] if len(commits) > 1 else []
    return together([*mixed, table(("", ""), list(facts.items()), words=2)])
