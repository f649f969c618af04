"""The page that holds a report: one file without anything from outside, for screen and paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from han_bullet.report.markup import Html, element, together

STYLE = """
:root { --ink: #202630; --pale: #5b6472; --line: #d9dee6; --good: #00664a; --bad: #a63603; --accent: #0b5aa5; }
* { box-sizing: border-box; }
html { font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", Arial, sans-serif; }
body { color: var(--ink); background: #fff; margin: 0 auto; max-width: 74rem; padding: 2rem 1.5rem 4rem; }
h1 { font-size: 2rem; line-height: 1.2; margin: 0 0 .25rem; }
h2 { font-size: 1.3rem; margin: 2.5rem 0 .75rem; padding-top: .75rem; border-top: 1px solid var(--line); }
h3 { font-size: 1.05rem; margin: 1.5rem 0 .5rem; }
p { margin: .5rem 0; max-width: 52rem; }
.lead { font-size: 1.1rem; color: var(--pale); }
.note, figcaption, summary { color: var(--pale); font-size: .9rem; }
nav { margin: 1rem 0; font-size: .9rem; }
nav a { margin-right: 1.1rem; white-space: nowrap; }
a { color: var(--accent); }
.cards { display: flex; flex-wrap: wrap; gap: .75rem; margin: 1.25rem 0; }
.card { border: 1px solid var(--line); border-radius: .5rem; padding: .6rem 1rem; min-width: 9rem; }
.card b { display: block; font-size: 1.35rem; font-weight: 600; }
.card span { color: var(--pale); font-size: .85rem; }
.good { color: var(--good); font-weight: 600; }
.bad { color: var(--bad); font-weight: 600; }
.verdict { border-left: .35rem solid; padding: .5rem 1rem; background: #f6f8fa; }
.wide { overflow-x: auto; margin: .75rem 0; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .75rem .3rem 0; border-bottom: 1px solid var(--line); text-align: left; vertical-align: top; }
th { color: var(--pale); font-weight: 600; border-bottom: 2px solid var(--line); vertical-align: bottom; }
th.n, td.n { text-align: right; padding-left: .75rem; }
td.n > span { white-space: nowrap; display: inline-block; }
td.w { overflow-wrap: break-word; }
abbr { text-decoration: underline dotted var(--pale); cursor: help; white-space: nowrap; }
figure { margin: 1rem 0; }
figure img, video { max-width: 100%; height: auto; display: block; }
video { width: 100%; border: 1px solid var(--line); border-radius: .5rem; }
.pairs { display: grid; grid-template-columns: repeat(auto-fit, minmax(26rem, 1fr)); gap: 0 1.5rem; }
.pairs figure img { width: 100%; }
td img { width: 17rem; display: block; }
code { font: .85em ui-monospace, "DejaVu Sans Mono", monospace; background: #f3f5f8; padding: .1em .3em; }
details { margin: .75rem 0; }
summary { cursor: pointer; }
footer { margin-top: 3rem; color: var(--pale); font-size: .85rem; border-top: 1px solid var(--line); }
@media print {
  @page { margin: 15mm; }
  html { font-size: 10pt; } body { max-width: none; padding: 0; } nav { display: none; }
  h2, h3 { break-after: avoid; } figure, tr, .verdict, .card { break-inside: avoid; }
  abbr { text-decoration: none; } .wide { overflow: visible; } .pairs { grid-template-columns: 1fr 1fr; }
}
"""


@dataclass(frozen=True)
class Section:
    """A chapter of the page.

    Attributes:
        anchor: For links to it.
        title: Its heading.
        body: What it holds.
    """

    anchor: str
    title: str
    body: Html


def page(title: str, lead: str, opening: Html, sections: Sequence[Section]) -> bytes:
    """Return a whole page.

    Args:
        title: Of the page.
        lead: One line below it.
        opening: What everybody should see, before the contents.
        sections: The chapters.
    """
    links = element("nav", *(element("a", section.title, href=f"#{section.anchor}") for section in sections))
    chapters = [
        element("section", element("h2", section.title), section.body, id=section.anchor) for section in sections
    ]
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("title", title),
        element("style", Html(STYLE)),
    )
    top = element("header", element("h1", title), element("p", lead, class_="lead"))
    body = element("body", top, opening, links, element("main", *chapters), element("footer", _FOOTER))
    return together([Html("<!DOCTYPE html>\n"), element("html", head, body, lang="en"), Html("\n")]).encode()


_FOOTER = "Lengths in metres, times in seconds of simulation time. Made by han-bullet report."
