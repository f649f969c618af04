"""Worlds as files: a YAML document <-> the checked values of `world_schema.py`."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from han_bullet import assets
from han_bullet.atomic_file import write_at_once
from han_bullet.errors import BadInputError
from han_bullet.world_schema import World

EXTENDS = "extends"  # the key that names another file, whose keys hold where this one gives none
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
NAMED = "name"  # a file that gives none, nor extends one that does, is only there to be extended


class _Loader(yaml.SafeLoader):
    """YAML in which, as in its version 1.2, only true and false are booleans: `on` is a key of ours."""

    yaml_implicit_resolvers = {  # noqa: RUF012  (as the base class has it)
        first: [(tag, pattern) for tag, pattern in resolvers if tag != "tag:yaml.org,2002:bool"]
        for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }


_Loader.add_implicit_resolver("tag:yaml.org,2002:bool", re.compile(r"^(true|false)$"), list("tf"))


def read_yaml(text: str) -> Any:
    """Return what a YAML text holds, without running anything in it.

    Raises:
        yaml.YAMLError: The text is no YAML.
    """
    return yaml.load(text, Loader=_Loader)


def load_world(name_or_path: str | Path) -> World:
    """Read and check a world.

    Args:
        name_or_path: A name from `world_names()` or a path to a YAML file.

    Raises:
        BadInputError: The file is missing, is no YAML or does not fit the schema; the message has file and field.
    """
    return parse_world(world_document(name_or_path), source=str(find_world(name_or_path)))


def world_document(name_or_path: str | Path) -> dict[str, Any]:
    """Read a world file with what it extends, unchecked: each key as the first file on the way has it, as a whole."""
    whole: dict[str, Any] = {}
    for _, document in _documents(find_world(name_or_path)):
        whole = document | whole
    if NAMED not in whole:
        raise BadInputError(f"{find_world(name_or_path)}: name: not given; a file without is no world, only extended")
    return {key: value for key, value in whole.items() if key != EXTENDS}


def world_files(name_or_path: str | Path) -> list[Path]:
    """Return the file of a world and those that it extends, in that order."""
    return [path for path, _ in _documents(find_world(name_or_path))]


def _documents(path: Path) -> list[tuple[Path, dict[str, Any]]]:
    """Read a file, the one that it extends, and so on."""
    documents = [(path, _read_document(path))]
    while EXTENDS in documents[-1][1]:
        here, document = documents[-1]
        base = _find_base(document[EXTENDS], here)
        way = [file for file, _ in documents]
        if base.resolve() in {file.resolve() for file in way}:
            names = " extends ".join(file.stem for file in [*way, base])
            raise BadInputError(f"{path}: extends: {names}, in a circle; one of them must extend nothing")
        documents.append((base, _read_document(base)))
    return documents


def _read_document(path: Path) -> dict[str, Any]:
    try:
        document = read_yaml(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError, OSError) as error:
        raise BadInputError(f"{path}: not readable as YAML: {' '.join(str(error).split())}") from error
    if not isinstance(document, dict):
        raise BadInputError(f"{path}: holds {type(document).__name__}, not a mapping of world fields to values")
    return document


def _find_base(name: object, extending: Path) -> Path:
    """Return the file that a file extends: the one beside it, else the shipped one; names alone, so no other folder."""
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise BadInputError(
            f"{extending}: extends: {name!r} is no name of a world file; letters, digits and underscores would be "
            "right, without folder and ending, such as building"
        )
    places = (extending.parent / f"{name}.yaml", assets.worlds_folder() / f"{name}.yaml")
    for place in places:
        if place.is_file():
            return place
    raise BadInputError(f"{extending}: extends: {name!r} is not there; neither {places[0]} nor {places[1]} is a file")


def save_world(world: World, path: Path, remark: str) -> None:
    """Write a world as a file that `load_world` reads, with a remark, one line, on top."""
    text = yaml.safe_dump(world.model_dump(mode="json"), sort_keys=False, default_flow_style=None, width=120)
    write_at_once(path, f"# {remark}\n{text}".encode())


def parse_world(document: dict[str, Any], source: str = "world") -> World:
    """Check a world given as plain values; see `load_world`."""
    try:
        return World.model_validate(document)
    except ValidationError as error:
        raise BadInputError(f"{source}: {first_fault(error, 'docs/world_file.md')}") from error


def first_fault(error: ValidationError, page: str) -> str:
    """Tell the first fault of a document in a sentence: field, what is wrong, the value given; a page has the keys."""
    # A misspelt key shows as a missing one too: the unknown key is what helps.
    first, *others = sorted(error.errors(), key=lambda fault: fault["type"] != "extra_forbidden")
    kinds = {"go_to", "hand_over", "ceiling", "onboard", "stand", "sit", "walk"}
    kinds |= {"frozen", "black", "dropped", "late", "knocked", "slip"}
    steps = [f"[{step}]" if isinstance(step, int) else f".{step}" for step in first["loc"] if step not in kinds]
    field = "".join(steps).lstrip(".") or "the document"
    message = first["msg"].removeprefix("Value error, ")
    if first["type"] == "extra_forbidden":
        message = f"unknown key; see {page} for the keys that exist"
    elif first["type"] == "union_tag_invalid":
        message = f"kind is {first['ctx']['tag']!r}; there are {first['ctx']['expected_tags']}"
    elif first["type"] != "value_error" and not isinstance(first["input"], dict | list):
        message += f" (it is {first['input']!r})"
    more = f" (and {len(others)} more)" if others else ""
    return f"{field}: {message}{more}"


def find_world(name_or_path: str | Path) -> Path:
    """Return the file of a world.

    Raises:
        BadInputError: Neither a shipped world nor a file.
    """
    given = Path(name_or_path)
    if given.suffix in {".yaml", ".yml"}:
        if not given.is_file():
            raise BadInputError(f"world file {str(given)!r} does not exist")
        return given
    path = assets.worlds_folder() / f"{name_or_path}.yaml"
    if not path.is_file():
        raise BadInputError(
            f"world {str(name_or_path)!r} is not known; there are {', '.join(world_names())}, or a path to a YAML file"
        )
    return path


def world_names() -> list[str]:
    """Return the names of the shipped worlds; a file that is only there to be extended is none."""
    files = sorted(assets.worlds_folder().glob("*.yaml"))
    return [file.stem for file in files if any(NAMED in document for _, document in _documents(file))]


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of a world file; what one extends may hold what is required."""
    schema = World.model_json_schema()
    required = schema.pop("required")
    text = "name of a world file whose keys hold where this one gives none"
    base = {"type": "string", "pattern": f"^{NAME.pattern}$", "description": text}
    schema["properties"][EXTENDS] = base
    return schema | {"anyOf": [{"required": [EXTENDS]}, {"required": required}]}
