"""The table [tool.galvi] of a project's pyproject.toml: defaults of the commands' options."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import typer

from galvi.repository import repository_of
from references.setting import nearest

FILE, TABLE = "pyproject.toml", "[tool.galvi]"
CONTENDERS_CLAIMS = "contenders"  # value of --claims: the claims of all external integrators
TYPE_OF_KEY: Mapping[str, type] = {
    "contenders": list,
    "problems": list,
    "claims": list,
    "require": list,
    "timeout": float,
    "fail-under": float,
    "slower": float,
    "less-accurate": float,
    "quick": bool,
    "out": str,
}
TYPE_TEXTS = {
    list: "a list of one or more texts",
    float: "a number",
    bool: "true or false",
    str: "a text",
}
PARAMETER_OF_KEY = {
    "contenders": "contender",
    "problems": "problem",
}  # key -> another parameter name
COMMA_SEPARATED = ("claims", "require")  # keys whose command-line options are lists with commas
COMMANDS = ("verify", "compare", "build", "track")  # get all defaults; others get `out` alone
SUBFOLDERS = {  # command -> its subfolder of `out`
    **dict.fromkeys((*COMMANDS, "studies", "export", "merge", "readme"), ""),
    "judge": "judge",
    "versions": "versions",
    "tolerance": "tolerance",
    "convergence": "convergence",
}


def defaults(directory: Path) -> dict[str, dict[str, Any]]:
    """Command -> parameter -> default, from the project's table; {} without one.

    The table is taken from the folder's own pyproject.toml or, if that has no [tool.galvi], from
    that of the repository's root. Raises typer.BadParameter for a file that cannot be read, an
    unknown key, and a value of another type.
    """
    for folder in dict.fromkeys((directory, repository_of(directory))):
        table = read_table(folder / FILE)
        if table is not None:
            return _by_command(table, Path() if folder == directory else folder)
    return {}


def _by_command(table: Mapping[str, Any], folder: Path) -> dict[str, dict[str, Any]]:
    values = {
        PARAMETER_OF_KEY.get(key, key.replace("-", "_")): ",".join(value)
        if key in COMMA_SEPARATED
        else value
        for key, value in table.items()
    }
    out = values.pop("out", None)
    by_command = {command: dict(values) for command in COMMANDS}
    if "contenders" in table:  # the papers' claims are not this project's
        by_command["verify"].setdefault("claims", CONTENDERS_CLAIMS)
    if out is not None:
        for command, subfolder in SUBFOLDERS.items():
            by_command.setdefault(command, {})["out"] = folder / out / subfolder
    return by_command


def read_table(file: Path) -> Mapping[str, Any] | None:
    """The checked table of a file; None without one. Raises as `defaults`."""
    try:
        tool_tables = tomllib.loads(file.read_text(encoding="utf-8")).get("tool", {})
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError) as error:  # one of TOML, or of UTF-8
        raise typer.BadParameter(f"{file} cannot be read: {error}.") from None
    table = tool_tables.get("galvi") if isinstance(tool_tables, dict) else None
    location = f"{TABLE} of {file}"
    if not isinstance(table, dict | None):
        raise typer.BadParameter(f"{location} expects a table; received {table!r}.")
    for key, value in (table or {}).items():
        if key not in TYPE_OF_KEY:
            closest = nearest(key, TYPE_OF_KEY)
            raise typer.BadParameter(f"{location} has no key {key!r}; did you mean {closest!r}?")
        if not _has_type(value, TYPE_OF_KEY[key]):
            expected = TYPE_TEXTS[TYPE_OF_KEY[key]]
            raise typer.BadParameter(f"{location}: {key} expects {expected}; received {value!r}.")
    return table


def _has_type(value: Any, expected_type: type) -> bool:
    """Whether a TOML value has the type `expected_type`: a list must be of texts and not empty, and
    an int counts as a float."""
    if isinstance(value, list):
        return (
            expected_type is list and bool(value) and all(isinstance(text, str) for text in value)
        )
    return type(value) is expected_type or (expected_type is float and type(value) is int)
