"""The origins of the numbers on the pages: date, commit and command."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from reports.results.claim_results import ClaimResult
from reports.results.comparison import Comparison
from reports.results.origins import describe_origins, read_origins, short_commit
from reports.results.rows import ORIGIN_COLUMNS, read_with_origin
from reports.results.section_result import SectionResult

CLAIMS = "claims.csv"
RUN_FIELDS = (*ORIGIN_COLUMNS, "command")  # entries of an origin other than versions and machine


@dataclass(frozen=True)
class Source:
    """A part of the pages, with the origins of its rows.

    Attributes
    ----------
    part
        name of the part
    origins
        see `reports.results.origins`
    """

    part: str
    origins: tuple[Mapping[str, str], ...]


def sources(
    out: Path,
    checked: Sequence[ClaimResult],
    comparison: Comparison,
    sections: Sequence[SectionResult],
) -> list[Source]:
    """The parts with rows; their origins are those of the files, for claims those of each row."""
    origins = read_origins(out)
    parts = []
    if checked:
        parts.append(Source("Claims", _origins_of_claims(out, checked, origins.get(CLAIMS, {}))))
    for part, file, table in (
        ("Comparisons", "work_precision.csv", comparison.work_precision),
        ("Cost of a step", "cost.csv", comparison.cost),
    ):
        if table is not None:
            parts.append(Source(part, (origins.get(file, {}),)))
    files = [f"{study.section.name}.csv" for study in sections if study.table is not None]
    if files:
        parts.append(Source("Studies", tuple(origins.get(file, {}) for file in files)))
    return parts


def _origins_of_claims(
    out: Path, checked: Sequence[ClaimResult], last: Mapping[str, str]
) -> tuple[Mapping[str, str], ...]:
    """The distinct origins of the rows of these claims; `last` is that of the last measurement."""
    rows = read_with_origin(out / CLAIMS, "id", last)
    if rows is None:
        return (last,)
    rows = rows[rows["id"].isin([claim_result.claim.id for claim_result in checked])]
    marks = rows[list(ORIGIN_COLUMNS)].drop_duplicates().astype(str).to_dict("records")
    command = last.get("command", "")
    return tuple(
        {**mark, "command": command if mark["commit"] == last.get("commit") else ""}
        for mark in marks
    )


def sentences(parts: Sequence[Source]) -> list[str]:
    """Sentences such as "Claims: 2026-01-02 03:04 UTC, commit 0123456789ab"; parts of the same
    origin share one."""
    names: dict[str, list[str]] = {}
    for source in parts:
        names.setdefault(describe_origins(source.origins), []).append(source.part)
    if len(names) == 1 and len(parts) > 1:
        return [f"All numbers: {text}" for text in names]
    return [
        f"{', '.join([first, *(name.lower() for name in further)])}: {text}"
        for text, (first, *further) in names.items()
    ]


def command_lines(parts: Sequence[Source]) -> str:
    """Shell commands that measure all parts again: for each commit its checkout and commands."""
    by_commit: dict[str, list[str]] = {}
    for origin in (origin for source in parts for origin in source.origins):
        commands = by_commit.setdefault(short_commit(origin.get("commit") or "unknown"), [])
        command = without_folder(origin.get("command", ""))
        if command and command not in commands:
            commands.append(command)
    lines = []
    for commit, commands in by_commit.items():
        digits, _, changed = commit.partition(" ")
        lines += [f"git checkout {digits}{f'  # {changed}' if changed else ''}"]
        lines += ["make install", ". .venv/bin/activate", *commands]
    return "\n".join(lines)


def without_folder(command: str) -> str:
    """The command without its option `--out`, so that it writes to the default folder."""
    return re.sub(r""" --out(?:=| +)(?:'[^']*'|"[^"]*"|\S+)""", "", command)


def file_table(origins: Mapping[str, Mapping[str, str]], shown: Mapping[str, str]) -> pd.DataFrame:
    """A line for each file; versions and machine are listed where they differ from `shown`."""
    lines = [
        {
            "file": file,
            "written": origin.get("date", ""),
            "commit": short_commit(origin.get("commit") or "unknown"),
            "setting": origin.get("setting", ""),
            "command": without_folder(origin.get("command", "")),
            "what differs from above": "; ".join(
                f"{name} {text}"
                for name, text in origin.items()
                if name not in RUN_FIELDS and shown.get(name) != text
            ),
        }
        for file, origin in origins.items()
    ]
    table = pd.DataFrame(lines)
    if len(table) and not table["what differs from above"].any():
        table = table.drop(columns="what differs from above")
    return table
