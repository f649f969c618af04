"""The option --fault: what goes wrong with which sensor, by how much, from when to when, as one short word."""

from __future__ import annotations

import argparse
import re
from decimal import Decimal
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from han_bullet.world_schema import InjectedFault

NUMBER = r"\d+(?:\.\d+)?"
GRAMMAR = re.compile(
    rf"(?:(?P<target>\w+)=)?(?P<kind>\w+)(?::(?P<amount>-?{NUMBER}))?(?:@(?P<start>{NUMBER})(?:-(?P<until>{NUMBER}))?)?"
)
# What the amount of each kind is; None: it takes none.
AMOUNTS = {"frozen": None, "black": None, "dropped": "share", "late": "delay", "knocked": "degrees", "slip": "times"}
FORM = "[TARGET=]KIND[:AMOUNT][@FROM[-UNTIL]]"
HELP = (
    f"{FORM}: a sensor fails. KIND: frozen, black, dropped[:SHARE], late[:SECONDS], knocked[:DEGREES] of a camera "
    "(default: all of them), dropped of the laser or a device, slip[:TIMES] of the wheels. May be given several times"
)


def fault_word(meant: InjectedFault) -> str | None:
    """Return the word that `fault` reads as this one; None where there is none, since it does not start at a time."""
    if meant.starts.when != "time":
        return None
    word = f"{meant.target}={meant.kind}"
    amount = AMOUNTS[meant.kind]
    word += "" if amount is None else f":{_digits(getattr(meant, amount))}"
    start, until = meant.starts.delay, meant.until
    word += f"@{_digits(start)}" if start > 0.0 or until is not None else ""
    return word + ("" if until is None else f"-{_digits(until)}")


def _digits(number: float) -> str:
    """Return a number to the last digit and without exponent, which a word cannot have."""
    return format(Decimal(repr(number)).normalize(), "f")


def fault(text: str) -> InjectedFault:
    """Read a fault, such as camera2=frozen@5 or camera1=dropped:0.5@2-10.

    Raises:
        argparse.ArgumentTypeError: It is none; says why.
    """
    from pydantic import TypeAdapter, ValidationError

    from han_bullet.world_schema import InjectedFault

    match = GRAMMAR.fullmatch(text)
    if match is None:
        raise argparse.ArgumentTypeError(f"{text!r} is not {FORM}, such as camera2=frozen@5 or camera1=dropped:0.5@2-8")
    kind, amount = match["kind"], match["amount"]
    if kind not in AMOUNTS:
        raise argparse.ArgumentTypeError(f"{text!r} has the kind {kind!r}; one of {', '.join(AMOUNTS)} would be right")
    if amount is not None and AMOUNTS[kind] is None:
        raise argparse.ArgumentTypeError(f"{text!r} has an amount, but {kind} takes none")
    given = {"target": match["target"], AMOUNTS[kind]: amount, "until": match["until"]}
    document: dict[str | None, object] = {key: value for key, value in given.items() if value is not None}
    if match["start"] is not None:
        document["starts"] = float(match["start"])
    try:
        read: InjectedFault = TypeAdapter(InjectedFault).validate_python({"kind": kind, **document})
    except ValidationError as error:
        reason = error.errors()[0]["msg"].removeprefix("Value error, ")
        raise argparse.ArgumentTypeError(f"{text!r} cannot be: {reason}") from None
    return read
