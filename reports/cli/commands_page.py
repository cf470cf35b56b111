"""The page of the command line, from the commands themselves.

`python -m reports.cli.commands_page > docs/commands.md` renews it.
"""

from __future__ import annotations

import re
from typing import Any

import typer
from typer.cli import get_docs_for_click

from reports.cli import commands

INTRODUCTION = """# Command line

In an installation the command is `galvi`; `python -m galvi` is the same. In a checkout, after
`make install`, it is `.venv/bin/galvi`, or `.venv/bin/python -m reports`. Outside of a checkout the
default output folder is `galvi-out`. [Using the suite](suite.md) says what each command is good
for.

## Exit status

"""


def commands_page() -> str:
    """The text of the page, as MyST."""
    group: Any = typer.main.get_command(commands.application())
    context = typer.Context(group, info_name="galvi")
    _, table = (commands.__doc__ or "").strip().split("\n\n")
    codes = re.sub(r"^(\d+) +", r"\n`\1`\n: ", table, flags=re.MULTILINE)  # a definition list
    usage = get_docs_for_click(obj=group, ctx=context, name="galvi", indent=1)
    return f"{INTRODUCTION}{codes.strip()}\n\n{usage}"


if __name__ == "__main__":
    print(commands_page(), end="")
