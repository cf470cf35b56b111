"""`judge`: the error of a model's own run, as sentences, a page, JSON, JUnit XML and a status."""

from __future__ import annotations

import sys
from functools import partial
from html import escape
from pathlib import Path

from benchmarks.applications.judging.candidate import Model
from benchmarks.applications.judging.judgement import Judgement, judge, kind_of
from benchmarks.store.atomic import write
from benchmarks.store.foreign_texts import visible
from benchmarks.store.provenance import provenance
from galvi.interop import from_mujoco, rebound
from galvi.interop.judge import MODEL_SUFFIXES, JudgeRequest
from galvi.interop.mujoco_limits import BeyondTrees
from reports.cli.handed_over import handed_over, show_progress
from reports.judge.files import junit_suites, write_judgement
from reports.judge.sentences import own_run, sentences
from reports.results.junit import github_annotations, junit_xml
from reports.results.summary import write_job_summary
from reports.tables.number_format import capital

REFUSALS = (ValueError, TypeError, FileNotFoundError, ImportError, RuntimeError)
progress = partial(show_progress, "judge")


def judgement_of(file: Path, request: JudgeRequest) -> Judgement:
    """The judgement of the model in a file. Raises REFUSALS if it cannot be judged."""
    try:
        model = read_model(file, request)
    except BeyondTrees as error:
        python_argument, option = f"ignore={error.names!r}", f'--ignore "{",".join(error.names)}"'
        raise ValueError(str(error).replace(python_argument, option)) from None
    judgement = judge(
        model, request.duration, request.error, request.own, progress, request.quick, _show_first
    )
    progress("")
    return judgement


def read_model(file: Path, request: JudgeRequest) -> Model:
    """Read a model: by MuJoCo for its suffixes, else by REBOUND.

    Raises the exceptions of the reader, and ValueError for an option of the other engine.
    """
    if request.is_problem:
        problem = handed_over(file, "galvi.judge(problem)")
        return kind_of(problem).model(problem)
    start = request.key, request.qpos, request.qvel, request.ctrl
    if file.suffix in MODEL_SUFFIXES:
        if request.snapshot != -1 or request.extras:
            raise ValueError(f"--snapshot and --extras are for REBOUND files; received {file}.")
        problem, model = from_mujoco.read(file, request.ignore, *start)
        left_out = "; ".join(f"{name}, {change}" for name, change in model.differences.items())
        return Model(problem, model, (f"Left out, as asked for: {left_out}.",) if left_out else ())
    if request.ignore or any(value is not None for value in start):
        raise ValueError(
            f"--key, --ignore, --qpos, --qvel and --ctrl are for MuJoCo models; received {file}."
        )
    problem, simulation = rebound.read(file, request.snapshot, request.extras)
    notes = map(problem.parameters.get, ("read_as", "functions", "written_by"))
    return Model(problem, simulation, tuple(f"{capital(note)}." for note in notes if note))


def _show_first(judgement: Judgement) -> None:
    progress("")
    print(
        f"judge: First answer: {' '.join(own_run(judgement))} The truth is "
        f"{judgement.source.label}, not yet compared with another source. Still to come: other "
        "sources of the truth, neighbouring starts, other integrators.",
        file=sys.stderr,
        flush=True,
    )


def report_judgement(
    judgement: Judgement, file: Path, error: float | None, out: Path, command: str, called: str
) -> int:
    """Write the page, JSON and JUnit XML, and print sentences.

    Parameters
    ----------
    error
        largest acceptable error; None for no limit
    command
        the command line as typed
    called
        the words of the command before "judge", such as "galvi"

    Returns
    -------
    int
        The exit status: 1 if the user's own run does not reach `error`, else 0.
    """
    page = write_judgement(judgement, file.name, provenance(command), out)
    suites = junit_suites(judgement, file, error)
    write(out / "judge.xml", junit_xml(f"{called} judge", suites))
    # names of bodies, joints and parts of a model are in them
    lines = [visible(sentence) for sentence in (*judgement.notes, *sentences(judgement))]
    items = [f"- {escape(sentence, quote=False)}" for sentence in lines]
    write_job_summary("\n".join([f"## judge: {escape(visible(file.name))}", "", *items, ""]))
    print(*lines, f"See {page}.", sep="\n")
    for annotation in github_annotations([case for cases in suites.values() for case in cases]):
        print(annotation)
    return int(error is not None and not judgement.passed)
