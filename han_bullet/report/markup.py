"""HTML as values: text is escaped unless it is HTML already, so that no name in a file can become markup."""

from __future__ import annotations

import base64
import html
import itertools
import re
from collections.abc import Iterable, Sequence

_VOID = {"img", "meta", "wbr"}
_JOINTS = re.compile(r"(?<=[+/:_])")  # after which a long name may go on in the next line


class Html(str):
    """Text that is HTML already; everything else is escaped."""

    __slots__ = ()


def element(tag: str, *children: str, **attributes: str) -> Html:
    """Return an element; a trailing underscore of an attribute's name is dropped, others become hyphens."""
    named = {name.rstrip("_").replace("_", "-"): html.escape(value) for name, value in attributes.items()}
    opening = tag + "".join(f' {name}="{value}"' for name, value in named.items())
    return Html(f"<{opening}>" if tag in _VOID else f"<{opening}>{together(children)}</{tag}>")


def together(parts: Iterable[str]) -> Html:
    """Return parts one after another."""
    return Html("".join(part if isinstance(part, Html) else html.escape(part) for part in parts))


def paragraph(*children: str, class_: str = "") -> Html:
    """Return a paragraph."""
    return element("p", *children, **({"class_": class_} if class_ else {}))


def table(headings: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> Html:
    """Return a table, as wide as it needs; the first columns hold words, the others numbers.

    Args:
        headings: Of the columns.
        rows: Cells, text or HTML.
        words: How many columns are words.
    """
    sides = ["w" if column < words else "n" for column in range(len(headings))]
    head = together(element("th", cell, class_=side, scope="col") for cell, side in zip(headings, sides, strict=True))
    body = [
        element("tr", *(element("td", cell, class_=side) for cell, side in zip(row, sides, strict=True)))
        for row in rows
    ]
    inner = element("table", element("thead", element("tr", head)), element("tbody", *body))
    return element("div", inner, class_="wide")


def explained(name: str, definition: str) -> Html:
    """Return a term with its definition, shown when pointed at."""
    return element("abbr", name, title=definition)


def breakable(name: str) -> Html:
    """Return a name that may be broken at its joints where there is little room."""
    return together(itertools.chain.from_iterable((element("wbr"), part) for part in _JOINTS.split(name)))


def more(summary: str, *children: str) -> Html:
    """Return what shows when it is asked for."""
    return element("details", element("summary", summary), *children)


def data_uri(content: bytes, kind: str) -> str:
    """Return a file as an address that holds it."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def picture(content: bytes, alternative: str, kind: str = "image/svg+xml") -> Html:
    """Return an embedded picture; an SVG in an <img> runs no scripts and shares no names with the page."""
    return element("img", src=data_uri(content, kind), alt=alternative)


def captioned(content: str, caption: str) -> Html:
    """Return a figure with its caption."""
    return element("figure", content, element("figcaption", caption))
