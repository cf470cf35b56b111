"""From galvi's docstrings, which are plain text, to the reStructuredText that Sphinx reads.

A block between blank lines is a paragraph, a list, a formula, or a legend: lines of a name, two
spaces and its meaning, which goes on in indented lines.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence

ENTRY = re.compile(r"([A-Za-z_]\S*(?:, \S+)*) {2,}(\S.*)")
ITEM = re.compile(r"- (.*)")
CODE = re.compile(r"(``.+?``|`.+?`)")
CALL = re.compile(r"(?:galvi\.)?([A-Za-z_]\w*(?:\.\w+)*)(?:\([^<>`]*\))?")
SPECIAL = re.compile(r"([\\*|_`])")
LEAD = re.compile(r"^(?=[-+.:]|\w{1,4}[.)] )")  # what would begin a list, an option, a comment


def restructured(text: str, known: Collection[str], own: str = "") -> list[str]:
    """The lines of a docstring as reStructuredText.

    known  names to which code in backticks is linked, without "galvi."
    own    the name that the text explains, which needs no link
    """
    lines: list[str] = []
    for block in re.split(r"\n\s*\n", text.strip()):
        lines += [*_block(block.rstrip().splitlines(), known, own), ""]
    return lines


def _block(lines: Sequence[str], known: Collection[str], own: str) -> Iterator[str]:
    if len(lines) == 1 and " = " in lines[0] and lines[0][-1] not in ".;:,":
        yield from (".. code-block:: text", "", f"    {lines[0].strip()}")
        return
    entries = _entries(lines, ENTRY)
    if entries:
        for names, words in entries:
            yield ", ".join(f"``{name}``" for name in names.split(", "))
            yield f"    {_inline(words, known, own)}"
        return
    items = _entries(lines, ITEM)
    if items:
        yield from (f"* {_inline(words, known, own)}" for (words,) in items)
        return
    yield _inline(" ".join(line.strip() for line in lines), known, own)


def _entries(lines: Sequence[str], form: re.Pattern[str]) -> list[list[str]]:
    """The parts of each entry, when all lines are entries or go on with one; else none."""
    entries: list[list[str]] = []
    for line in lines:
        found = form.fullmatch(line)
        if found:
            entries.append(list(found.groups()))
        elif entries and line.startswith("  "):
            entries[-1][-1] += f" {line.strip()}"
        else:
            return []
    return entries


def _inline(text: str, known: Collection[str], own: str) -> str:
    parts = CODE.split(text)
    plain = [SPECIAL.sub(r"\\\1", part) for part in parts[::2]]
    code = [_code(part, known, own) for part in parts[1::2]]
    for place, part in enumerate(code):
        plain[place] += "" if not plain[place][-1:].isalnum() else "\\ "
        after = "\\ " if plain[place + 1][:1].isalnum() else ""
        plain[place] += part + after
    return LEAD.sub(r"\\", "".join(plain))


def _code(part: str, known: Collection[str], own: str) -> str:
    """Code in backticks: a link where it names a class, or anything public in single ones."""
    text = part.strip("`")
    found = CALL.fullmatch(text)
    named = found is not None and found[1] in known and found[1] != own
    if named and (text[0].isupper() or text.startswith("galvi.") or not part.startswith("``")):
        return f":py:obj:`{text} <galvi.{found[1]}>`"
    return f"``{text}``"
