"""The command that judges a model: sentences on the terminal, a page, JSON, and a status."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Any

import typer

from benchmarks.applications.judging.candidate import Model
from benchmarks.applications.judging.judgement import Judgement, judge, kind_of
from benchmarks.store.atomic import write
from benchmarks.store.foreign_texts import visible
from benchmarks.store.provenance import provenance
from galvi import Problem
from galvi.interop import from_mujoco, rebound
from galvi.interop.judge import MODELS, JudgeRequest
from galvi.interop.mujoco_limits import BeyondTrees
from reports.cli.errors import words
from reports.cli.handed_over import handed_over, show_progress
from reports.cli.option_groups import ModelStart
from reports.judge.cases import junit_suites
from reports.judge.page import write_judgement
from reports.judge.sentences import own_run, sentences
from reports.results.junit import github_annotations, junit_xml
from reports.tables.number_format import capital

FLAGS = {"true": True, "false": False}
progress = partial(show_progress, "judge")
LEFT = "other sources of the truth, neighbouring starts, other integrators"


def judge_command(file: Path, request: JudgeRequest, out: Path, command: str, called: str) -> int:
    """0, or 1 when an error was asked for that the user's own run does not reach.

    command  as typed
    called   its words before "judge", such as "galvi"
    """
    try:
        model = read_model(file, request)
        found = judge(
            model, request.duration, request.error, request.own, progress, request.quick, _first
        )
    except BeyondTrees as refused:
        *lines, _ = str(refused).splitlines()
        remedy = f'Leave them out with --ignore "{",".join(refused.names)}".'
        raise typer.BadParameter(visible("\n".join([*lines, remedy]))) from None
    except (ValueError, TypeError, FileNotFoundError, ImportError, RuntimeError) as refused:
        raise typer.BadParameter(visible(str(refused))) from None
    progress("")
    page = write_judgement(found, file.name, provenance(command), out)
    suites = junit_suites(found, file.name, request.error)
    write(out / "judge.xml", junit_xml(f"{called} judge", suites))
    for sentence in (*found.notes, *sentences(found)):
        print(visible(sentence))  # it has names of bodies, joints and parts of a model
    print(
        f"See {page}.",
        *github_annotations([case for cases in suites.values() for case in cases]),
        sep="\n",
    )
    return int(request.error is not None and not found.passed)


def request_of(
    start: ModelStart,
    duration: float | None,
    error: float | None,
    own: str,
    quick: bool,
    extras: str,
) -> JudgeRequest:
    """The request that options ask for; a usage error for text that is none."""
    try:
        return JudgeRequest(
            duration, error, read_own(own), start.snapshot, words(start.ignore),
            None if start.key is None else _number(start.key), read_numbers("--qpos", start.qpos),
            read_numbers("--qvel", start.qvel), read_numbers("--ctrl", start.ctrl), quick,
            extras=extras,
        )  # fmt: skip
    except ValueError as refused:
        raise typer.BadParameter(str(refused)) from None


def read_model(file: Path, request: JudgeRequest) -> Model:
    """The model of a file: of MuJoCo's by its suffix, else of REBOUND's. Raises what they do, and
    ValueError for an option of the other kind."""
    if request.is_problem:
        problem: Problem = handed_over(file, "galvi.judge(problem)")
        return kind_of(problem).model(problem)
    asked = request.key, request.qpos, request.qvel, request.ctrl
    if file.suffix in MODELS:
        if request.snapshot != -1:
            raise ValueError(f"--snapshot is of REBOUND's files; received {file}.")
        if request.extras:
            raise ValueError(f"--extras is of REBOUND's files; received {file}.")
        problem, mine = from_mujoco.read(file, request.ignore, *asked)
        gone = "; ".join(f"{name}, {how}" for name, how in mine.differences.items())
        return Model(problem, mine, (f"Left out, as asked for: {gone}.",) if gone else ())
    if request.ignore or any(one is not None for one in asked):
        raise ValueError(
            f"--key, --ignore, --qpos, --qvel and --ctrl are of models of MuJoCo's; received "
            f"{file}."
        )
    problem, simulation = rebound.read(file, request.snapshot, request.extras)
    said = (problem.parameters.get(name) for name in ("read_as", "functions", "written_by"))
    return Model(problem, simulation, tuple(f"{capital(one)}." for one in said if one))


def read_own(text: str) -> dict[str, Any]:
    """{"integrator": "whfast", "dt": 0.1} from integrator=whfast,dt=0.1; numbers, true and false
    where they are.

    Raises ValueError for a part that is not name=value.
    """
    result: dict[str, Any] = {}
    for part in filter(None, (word.strip() for word in text.split(","))):
        name, equals, value = part.partition("=")
        if not (name and equals and value):
            raise ValueError(f"--own expects name=value, separated by commas; received {part!r}.")
        result[name.strip()] = FLAGS.get(value.strip().lower(), _number(value.strip()))
    return result


def read_numbers(option: str, text: str) -> list[float] | None:
    """[1.0, 0.5] from 1,0.5; None from nothing; ValueError, naming the option, for others."""
    words = text.replace(",", " ").split()
    try:
        return [float(word) for word in words] or None
    except ValueError:
        raise ValueError(
            f"{option} expects numbers, separated by commas; received {text!r}."
        ) from None


def _number(text: str) -> Any:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _first(found: Judgement) -> None:
    progress("")
    first = (
        f"First answer: {' '.join(own_run(found))} The truth is {found.source.label}, not yet "
        f"compared with another source."
    )
    print(f"judge: {first} Still to come: {LEFT}.", file=sys.stderr, flush=True)
