"""The command that judges a model: sentences on the terminal, a page, JSON, and a status."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import typer

import galvi
from benchmarks.judging.judgement import judge
from benchmarks.store.provenance import provenance
from galvi import Problem
from galvi.doors.judge import MODELS
from reports.judge.page import write
from reports.judge.sentences import sentences


def judge_command(
    file: Path, duration: float | None, error: float | None, own: str,
    start: Mapping[str, Any], out: Path,
    command: str,
) -> int:  # fmt: skip
    """0, or 1 when an error was asked for that the user's own run does not reach."""
    try:
        problem = read_model(file, **start)
        found = judge(problem, duration, error, read_own(own), _progress)
    except (ValueError, TypeError, FileNotFoundError, ImportError, RuntimeError) as refused:
        raise typer.BadParameter(str(refused)) from None
    _progress("")
    page = write(found, file.name, provenance(command), out)
    for sentence in sentences(found):
        print(sentence)
    print(f"See {page}.")
    return int(error is not None and not found.passed)


def read_model(file: Path, snapshot: int, key: int | None, ignore: str) -> Problem:
    """The problem of a file: of MuJoCo's by its suffix, else of REBOUND's. Raises what they do, and
    ValueError for an option of the other kind."""
    if file.suffix in MODELS:
        if snapshot != -1:
            raise ValueError(f"--snapshot is of REBOUND's files; received {file}.")
        left_out = tuple(filter(None, (word.strip() for word in ignore.split(","))))
        return galvi.from_mujoco(file, left_out, key)
    if key is not None or ignore:
        raise ValueError(f"--key and --ignore are of models of MuJoCo's; received {file}.")
    return galvi.from_rebound(file, snapshot)


def read_own(text: str) -> dict[str, Any]:
    """{"integrator": "whfast", "dt": 0.1} from integrator=whfast,dt=0.1; numbers where they are.

    Raises ValueError for a part that is not name=value.
    """
    result: dict[str, Any] = {}
    for part in filter(None, (word.strip() for word in text.split(","))):
        name, equals, value = part.partition("=")
        if not (name and equals and value):
            raise ValueError(f"--own expects name=value, separated by commas; received {part!r}.")
        result[name.strip()] = _number(value.strip())
    return result


def _number(text: str) -> Any:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _progress(sentence: str) -> None:
    """Show a sentence in place of the last one, on a terminal."""
    if sys.stderr.isatty():
        print(f"\r\033[K{sentence}", end="", file=sys.stderr, flush=True)
