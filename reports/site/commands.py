"""The page of the command line, from the commands themselves."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

from reports.cli import commands

FILE = "commands.md"
INTRODUCTION = """# Command line

In an installation the command is `galvi`; `python -m galvi` is the same. In a checkout, after
`make install`, it is `.venv/bin/galvi`, or `.venv/bin/python -m reports`. Without a command it
builds the report, as `galvi build` does. Outside of a checkout the default output folder is
`galvi-out`. [Using the suite](../suite.md) says what each command is good for.
"""


def pages() -> Iterator[tuple[str, str]]:
    """(file, text) of the page."""
    group: Any = typer.main.get_command(commands.application())
    lines = [INTRODUCTION, "## Exit status", "", *_exit_codes(), ""]
    for name, command in group.commands.items():
        lines += [f"## galvi {name}", "", command.help, "", *_usage(name, command), ""]
        for one in command.params:
            if not getattr(one, "hidden", False):
                lines += [_title(one), f": {_explained(one)}", ""]
    yield FILE, "\n".join(lines)


def _exit_codes() -> Iterator[str]:
    """A definition list, from the docstring of the commands."""
    _, table = (commands.__doc__ or "").strip().split("\n\n")
    for entry in re.split(r"\n(?=\d)", table):
        code, meaning = entry.split(maxsplit=1)
        yield from (f"`{code}`", f": {' '.join(meaning.split())}", "")


def _usage(name: str, command: Any) -> Iterator[str]:
    arguments = [one.metavar if one.required else f"[{one.metavar}]" for one in command.params
                 if one.param_type_name == "argument"]  # fmt: skip
    options = any(one.param_type_name == "option" for one in command.params)
    words = ["galvi", name, *arguments, *(["[OPTIONS]"] if options else [])]
    yield from ("```sh", " ".join(words), "```")


def _title(one: Any) -> str:
    if one.param_type_name == "argument":
        return f"`{one.metavar}`"
    taken = "" if one.is_flag else f" {one.metavar}"
    return f"`{', '.join(one.opts)}{taken}`"


def _explained(one: Any) -> str:
    """Its help and its default, where that says something."""
    text = (one.help or "").strip()
    default = one.default
    if isinstance(default, str | Path) and str(default):
        text += f" Default: `{default}`."
    elif isinstance(default, int | float) and not isinstance(default, bool):
        text += "" if default == float("inf") else f" Default: `{default}`."
    return text.strip()
