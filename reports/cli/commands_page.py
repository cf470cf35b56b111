"""The page of the command line, from the commands themselves.

`python -m reports.cli.commands_page > docs/commands.md` renews it.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection
from typing import Any

import typer
from typer.cli import get_docs_for_click

from reports.cli import commands

INTRODUCTION = """# Command line

The command is `galvi`, or `python -m galvi`; in a checkout `.venv/bin/galvi`, or
`.venv/bin/python -m reports`. It writes to `galvi-out`, in a checkout to `reports/out`: `judge`,
`versions`, `tolerance` and `convergence` to a folder of their name there; `--out` names another.
`galvi` alone is `galvi build`, `galvi --version` shows versions.

## Exit status

"""
NOT_SHOWN = re.compile(
    r"\*\*Usage\*\*:\n\n```console\n.*?```\n\n|\*\*\w+\*\*:\n\n|^\* `--help`.*?\n"
    r"|  \[default: reports/out[/\w]*\]",
    re.DOTALL | re.MULTILINE,
)
OUT = "* `--out "  # which all but one command take
OPTION = re.compile(r"^\* `(-[^`]*)`: .*$", re.MULTILINE)


def commands_page() -> str:
    """The text of the page, as MyST."""
    group: Any = typer.main.get_command(commands.application())
    context = typer.Context(group, info_name="galvi")
    _, table = (commands.__doc__ or "").strip().split("\n\n")
    codes = re.sub(r"^(\d+) +", r"\n`\1`\n: ", table, flags=re.MULTILINE)  # a definition list
    usage = get_docs_for_click(obj=group, ctx=context, name="galvi", indent=1)
    _, *sections = re.split(r"^### ", NOT_SHOWN.sub("", usage), flags=re.MULTILINE)
    uses = Counter(line[0] for text in sections for line in OPTION.finditer(text))
    shared = [line for line, count in uses.items() if count > 1]
    lines = "\n".join(shared)
    described = "\n".join(_section(text, shared) for text in sections)
    return (
        f"{INTRODUCTION}{codes.strip()}\n\n## Commands\n\n{described}\n"
        f"## Options of several commands\n\n{lines}\n"
    )


def _section(text: str, shared: Collection[str]) -> str:
    """That of a command, which names the options that several share and describes the others."""
    lines = text.rstrip().splitlines()
    names = [
        match[1].split()[0]
        for line in lines
        if line in shared and (match := OPTION.match(line)) and not line.startswith(OUT)
    ]
    section = "\n".join(line for line in lines if line not in shared).rstrip()
    also = f"\n\nAlso {', '.join(f'`{name}`' for name in names)}." if names else ""
    return f"### {section}{also}\n"


if __name__ == "__main__":
    print(commands_page(), end="")
