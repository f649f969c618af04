"""The page of one run."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from han_bullet.ablation import TrueLocalization
from han_bullet.atomic_file import write_at_once
from han_bullet.commands.fault_option import fault_word
from han_bullet.costmap.layers import STANDARD
from han_bullet.detection.model_files import DEFAULT_CLASSIFIER, DEFAULT_PROPOSER
from han_bullet.metrics.tally import Value
from han_bullet.mirroring import OTHER_SIDE
from han_bullet.report.film_still import middle_picture
from han_bullet.report.markup import (
    Html,
    captioned,
    data_uri,
    element,
    explained,
    more,
    paragraph,
    picture,
    table,
    together,
)
from han_bullet.report.page import Section, page
from han_bullet.report.run_charts import draw_encounters, draw_perception, draw_ways
from han_bullet.report.run_files import Run, read_run_files
from han_bullet.report.run_moments import position_errors
from han_bullet.run_folder import MetricEntry, OrderEntry, ResultFile

LARGEST_EMBEDDED = 12 * 2**20  # [B] of a video; a third more as text, which browsers still open at once
KEY_METRICS = (
    *("time_to_goal", "path_length", "minimum_distance", "overtaking_side", "distance_when_level"),
    *("personal_space_share", "contacts_person", "stalled_time", "transit_time_on", "replan_delay"),
    *("behind_seated", "hand_over_distance", "hand_over_bearing"),
)
OF_PERCEPTION = ("tracked_share", "person_position_rmse")
OUTCOMES = {
    "arrived": "The robot fulfilled its task",
    "blocked": "The robot found no free way",
    "lost": "The robot did not find out where it is",
    "timeout": "The robot ran out of time",
}


def write_run_page(folder: Path) -> Path:
    """Write report.html into the folder of a run and return its path.

    Raises:
        BadInputError: The folder does not hold what a run writes.
    """
    path = folder / "report.html"
    write_at_once(path, run_page(read_run_files(folder)))
    return path


def run_page(run: Run) -> bytes:
    """Return the page of a run."""
    result = run.result
    description = run.world.description if run.world is not None else ""
    sections = [
        Section("expectations", "What the world expects", _checks(result)),
        Section("ways", "Where everybody went", _ways(run)),
        Section("encounters", "How near, how fast", _encounters(run)),
        Section("perception", "What the robot saw of people", _perception(run)),
        *_video(run.folder / "video.mp4"),
        Section("figures", "All figures", _all_metrics(result.metrics)),
        Section("provenance", "Where this comes from", _provenance(result)),
    ]
    title = f"{result.world}{', mirrored' if result.mirrored else ''}, seed {result.seed}"
    return page(title, description, _opening(result), sections)


def _opening(result: ResultFile) -> Html:
    failed = [check for check in result.checks if not check.passed]
    outcome = OUTCOMES.get(result.outcome, f"The run ended as {result.outcome}")
    if result.orders:
        met = "it was given orders, so no expectation of its world was held against it"
    elif not result.checks:
        met = "the world states no expectations"
    elif failed:
        met = f"{len(failed)} of {len(result.checks)} expectations are not met"
    else:
        met = f"all {len(result.checks)} expectations are met"
    good = result.outcome == "arrived" and not failed
    detail = "" if result.outcome_detail is None else f" It gave up: {result.outcome_detail}."
    verdict = element("p", f"{outcome}; {met}.{detail}", class_=f"verdict {'good' if good else 'bad'}")
    names = KEY_METRICS if result.perception == "truth" else KEY_METRICS + OF_PERCEPTION
    chosen = [metric for name in names for metric in result.metrics if metric.name.split(".")[0] == name]
    cards = [_card(metric) for metric in chosen if metric.value not in (None, "none")]
    return together([verdict, element("div", *cards, class_="cards")])


def _card(metric: MetricEntry) -> Html:
    unit = "" if metric.unit in ("", "1") else f" {metric.unit}"
    name = explained(metric.name.replace("_", " ").replace(".", ": "), metric.definition)
    return element("div", element("b", f"{value_text(metric.value)}{unit}"), element("span", name), class_="card")


def value_text(value: Value) -> str:
    """Return a figure as people write it; what is not there as a dash."""
    if value is None:
        return "–"
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def _checks(result: ResultFile) -> Html:
    if result.orders:
        told = "; ".join(f"{order.time:.2f} s: {_told(order)}" for order in result.orders)
        return paragraph(f"No expectation was held against the run, as the robot was given orders. {told}.")
    if not result.checks:
        return paragraph("The world states no expectations.")
    rows = [
        (
            element("span", "met" if check.passed else "not met", class_="good" if check.passed else "bad"),
            *(check.metric, _in_words(check.expected), value_text(check.value)),
        )
        for check in sorted(result.checks, key=lambda check: check.passed)
    ]
    return table(("", "expectation on", "is to be", "is"), rows, words=3)


def _told(order: OrderEntry) -> str:
    """Return an order in words; places in [m]."""
    if order.pose is not None:
        return "go to ({:.2f}, {:.2f})".format(*order.pose[:2])
    if order.place is not None:
        whom = "" if order.person is None else f"track {order.person} "
        return f"hand over to {whom}" + "at ({:.2f}, {:.2f})".format(*order.place)
    return order.order.replace("_", " ")


def _in_words(expected: str) -> str:
    """Return a range with the signs that people read."""
    for sign, words in ((">=", "at least"), ("<=", "at most"), ("== ", "")):
        expected = expected.replace(sign, words)
    return expected


def _ways(run: Run) -> Html:
    note = [] if run.world else [paragraph(f"No map is drawn: {run.no_map}.", class_="note")]
    people = ", ".join(person.name for person in run.trace.people) or "nobody"
    alternative = f"Map with the ways of the robot, of {people}, and of the tracks"
    caption = (
        "Seen from above. The robot's way is coloured by its speed; squares are starts, discs ends, small circles "
        "stand every 5 s. The dashed ring is the goal, as large as the robot; wedges are ceiling cameras with their "
        "width of view. Thin dashed lines are tracks, what the stack believed of people."
    )
    return together([*note, captioned(picture(draw_ways(run), alternative), caption)])


def _encounters(run: Run) -> Html:
    caption = (
        "Above: true distance between the centres of robot and person; triangles mark the nearest moment. Bands are "
        "Hall's zones of intimate (to 0.45 m), personal (to 1.2 m) and social distance (to 3.6 m): those are between "
        "surfaces, so they begin where bodies touch. Below: the robot's true speed."
    )
    caption += " Dotted lines mark when the robot was told that a device is on." if run.devices_on else ""
    chart = captioned(picture(draw_encounters(run), "Distances to people and speed over time"), caption)
    steps = [f"{time:.2f} s: {'goes on' if step is None else step.value}" for time, step in run.steps]
    note = [paragraph(f"Where the robot could not go on: {'; '.join(steps)}.")] if steps else []
    return together([chart, *note])


def _perception(run: Run) -> Html:
    if run.result.perception == "truth":
        return paragraph("This run had no cameras: the robot was told where people are (--perception truth).")
    if not run.trace.people:
        return paragraph("There were no people.")
    caption = (
        "Above: when a confirmed track was matched to the person, within 1 m. Below: distance of that track from the "
        "person's true place. People out of every camera's view have no track; the metric tracked_share counts only "
        "from when they could first be seen."
    )
    return captioned(
        picture(draw_perception(run, position_errors(run)), "Who had a track when, and its error over time"), caption
    )


def _video(file: Path) -> list[Section]:
    """Return the chapter with the video: inside the page, or beside it where it is large; none without one."""
    if not file.is_file():
        return []
    embedded = file.stat().st_size <= LARGEST_EMBEDDED
    source = data_uri(file.read_bytes(), "video/mp4") if embedded else file.name
    still = middle_picture(file)
    poster = {} if still is None else {"poster": data_uri(still, "image/jpeg")}
    player = element("video", f"See {file.name}.", src=source, controls="", preload="metadata", **poster)
    words = "Above the map, below the cameras with what the detector found."
    beside = "" if embedded else f" The file {file.name} lies beside this page; keep them together."
    link = paragraph(words + beside + " ", element("a", "Open the file", href=file.name), class_="note")
    return [Section("video", "Video", together([player, link]))]


def _all_metrics(metrics: tuple[MetricEntry, ...]) -> Html:
    rows = [
        (
            metric.name,
            element("b", value_text(metric.value)),
            "" if metric.unit == "1" else metric.unit,
            metric.definition,
        )
        for metric in metrics
    ]
    inner = table(("metric", "value", "unit", "definition"), rows, words=4)
    return more(f"{len(metrics)} metrics with their definitions", inner)


def _provenance(result: ResultFile) -> Html:
    detector = ", ".join(f"{name} {value}" for name, value in (result.detector or {}).items() if value is not None)
    beyond = [" with the assumptions below scaled, which only han-bullet sweep can"] if result.scaled else []
    if any(fault_word(fault) is None for fault in result.asked_faults):
        beyond.append(" with faults that wait for an event, which only a world file or own code can")
    facts = {
        "made again by": together([element("code", command_line(result)), *beyond]),
        "world": f"{result.world}, sha256 {result.world_sha256}",
        "seed": str(result.seed),
        "perception": result.perception,
        "cameras": ", ".join(result.cameras) or "none",
        "detector": detector or "none",
        "association": result.association or "none",
        "costmap layers": ", ".join(result.layers),
        "assumptions scaled": ", ".join(result.scaled) or "none",
        "pose of the robot from": result.localization or "unknown",
        "commit": result.git_commit,
        "versions": ", ".join(f"{name} {version}" for name, version in result.versions.items()),
        "timings": ", ".join(f"{name} {value}" for name, value in result.timings.items()),
    }
    return table(("", ""), list(facts.items()), words=2)


def command_line(result: ResultFile) -> str:
    """Return the command that makes a run with shipped parts again; own code it cannot know, of own files the names."""
    words = ["han-bullet", "run", result.world, "--seed", str(result.seed)]
    if result.perception == "truth":
        words += ["--perception", "truth"]
    else:
        words += ["--cameras", ",".join(result.cameras)]
        if result.association not in (None, "nnjpda"):
            words += ["--association", str(result.association)]
        words += _of_detector(result.detector or {})
    words += ["--localization", "truth"] if result.localization == TrueLocalization.name else []
    missing = [layer.name for layer in STANDARD if layer.name not in result.layers]
    words += ["--without", ",".join(missing)] if missing else []
    words += ["--mirrored"] if result.mirrored else []
    asked = OTHER_SIDE[result.pass_side] if result.mirrored else result.pass_side
    words += [] if asked == "left" else ["--pass", asked]
    for fault in result.asked_faults:
        word = fault_word(fault)
        words += [] if word is None else ["--fault", word]
    return shlex.join(words)


def _of_detector(told: Mapping[str, Any]) -> list[str]:
    """Return the options that choose a detector, by what result.json tells of it."""
    words = []
    for option, name, default in (
        ("--detector", told.get("proposer"), DEFAULT_PROPOSER),
        ("--classifier", told.get("classifier"), DEFAULT_CLASSIFIER),
    ):
        words += [] if name in (None, default) else [option, str(name)]
    threshold = told.get("threshold")
    return words + ([] if threshold is None else [f"--threshold={threshold!r}"])  # to the last digit; may be negative
