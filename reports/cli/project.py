"""The table [tool.galvi] of a project's pyproject.toml: what commands take by default."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import typer

from references.setting import nearest

FILE, TABLE = "pyproject.toml", "[tool.galvi]"
CONTENDERS_CLAIMS = "contenders"  # in --claims: those of all external integrators


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and bool(value.strip())


def _is_list(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(_is_text(one) for one in value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_flag(value: Any) -> bool:
    return isinstance(value, bool)


@dataclass(frozen=True)
class Key:
    """A key of the table.

    option    the parameter of commands that it is the default of
    expected  its type, in words
    fits      whether a value is of that type
    """

    option: str
    expected: str
    fits: Callable[[Any], bool]
    joined: bool = False

    def default(self, value: Any) -> Any:
        """The value as on the command line, where some lists are words with commas."""
        return ",".join(value) if self.joined else value


LIST, NUMBER = "a list of one or more texts", "a number"
KEYS: Mapping[str, Key] = {
    "contenders": Key("contender", LIST, _is_list),
    "problems": Key("problem", LIST, _is_list),
    "claims": Key("claims", LIST, _is_list, joined=True),
    "require": Key("require", LIST, _is_list, joined=True),
    "timeout": Key("timeout", NUMBER, _is_number),
    "fail-under": Key("fail_under", NUMBER, _is_number),
    "slower": Key("slower", NUMBER, _is_number),
    "less-accurate": Key("less_accurate", NUMBER, _is_number),
    "quick": Key("quick", "true or false", _is_flag),
    "out": Key("out", "a text", _is_text),
}
COMMANDS = ("verify", "compare", "build", "track")  # that take defaults from the table


@dataclass(frozen=True)
class Project:
    """The project around the current folder.

    table  its checked [tool.galvi]; empty where it has none
    out    the output folder that the table names
    """

    table: Mapping[str, Any] = field(default_factory=dict)
    out: Path | None = None

    def default(self, key: str) -> Any:
        """What the table says of a key, as an option has it; None for nothing."""
        return KEYS[key].default(self.table[key]) if key in self.table else None

    def defaults(self, parameters: Mapping[str, set[str]]) -> dict[str, dict[str, Any]]:
        """Command -> parameter -> default.

        parameters  command -> names of its parameters
        """
        values = {KEYS[key].option: self.default(key) for key in self.table if key != "out"}
        result = {
            command: {name: value for name, value in values.items() if name in parameters[command]}
            for command in COMMANDS
        }
        if "contenders" in self.table:  # the papers' claims are not this project's
            result["verify"].setdefault("claims", CONTENDERS_CLAIMS)
        return result


def read_project(here: Path) -> Project:
    """The project of this folder: its own pyproject.toml or, where that has no [tool.galvi], that
    of the repository's root.

    Raises typer.BadParameter for a file that cannot be read, an unknown key, and a value of another
    type.
    """
    top = next((one for one in (here, *here.parents) if (one / ".git").exists()), here)
    for folder in dict.fromkeys((here, top)):
        table = _table(folder / FILE)
        if table is not None:
            checked = _checked(table, folder / FILE)
            out = checked.get("out")
            base = Path() if folder == here else folder
            return Project(checked, None if out is None else base / out)
    return Project()


def _table(file: Path) -> Any:
    try:
        contents = tomllib.loads(file.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError) as error:  # one of TOML, or of UTF-8
        raise typer.BadParameter(f"{file} cannot be read: {error}.") from None
    tool = contents.get("tool", {})
    return tool.get("galvi") if isinstance(tool, dict) else None


def _checked(table: Any, file: Path) -> Mapping[str, Any]:
    where = f"{TABLE} of {file}"
    if not isinstance(table, dict):
        raise typer.BadParameter(f"{where} expects a table; received {table!r}.")
    for name, value in table.items():
        if name not in KEYS:
            raise typer.BadParameter(
                f"{where} has no key {name!r}; did you mean {nearest(name, KEYS)!r}?"
            )
        if not KEYS[name].fits(value):
            raise typer.BadParameter(
                f"{where}: {name} expects {KEYS[name].expected}; received {value!r}."
            )
    return table
