"""The examples of the reference, one for each public name, from ``examples.txt``."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

FILE = Path(__file__).with_name("examples.txt")
HEADING = re.compile(r"^== (\S+) ==$\n", re.MULTILINE)


@cache
def examples() -> dict[str, str]:
    """Name -> lines of an interpreter and what they print; raises ValueError for a name twice."""
    _, *parts = HEADING.split(FILE.read_text(encoding="utf-8"))
    names = parts[::2]
    if len(set(names)) < len(names):
        raise ValueError(f"{FILE.name} has two examples of one name")
    return {name: text.strip() + "\n" for name, text in zip(names, parts[1::2], strict=True)}
