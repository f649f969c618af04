"""Parsers and option values that the subcommands share."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NoReturn

from han_bullet.errors import BadInputError


class Parser(argparse.ArgumentParser):
    """A parser whose complaints are one sentence, like every other one of ours."""

    def error(self, message: str) -> NoReturn:
        """Raise what argparse would print with its usage."""
        raise BadInputError(f"{self.prog}: {message}; see {self.prog} --help")


Commands = argparse._SubParsersAction  # argparse has no public name for it


def command(commands: Commands[Parser], name: str, help_line: str, examples: str) -> Parser:
    """Add a subcommand with its help and examples."""
    return commands.add_parser(
        name,
        help=help_line,
        description=help_line,
        epilog=f"examples:\n{examples}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def natural(text: str) -> int:
    """Read a whole number of at least 0."""
    if not text.isdigit():
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of at least 0")
    return int(text)


def positive(text: str) -> int:
    """Read a whole number of at least 1."""
    if not text.isdigit() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of at least 1")
    return int(text)


def names(text: str) -> tuple[str, ...]:
    """Read names separated by commas."""
    return tuple(name.strip() for name in text.split(",") if name.strip())


def output_folder(text: str) -> Path:
    """Read the path of a folder that exists or can be made."""
    path = Path(text)
    existing = next(place for place in (path, *path.absolute().parents) if place.exists())
    if not existing.is_dir():
        raise argparse.ArgumentTypeError(f"{str(existing)!r} is a file; a folder would be right")
    return path
