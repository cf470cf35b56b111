"""Put problems of one's own, named on the command line, in the place of a suite's."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import pandas as pd
import typer

from benchmarks.applications.external.loading import ContenderError
from benchmarks.applications.external.own_problems import load_problem
from benchmarks.work_precision.cost import COLUMNS
from benchmarks.work_precision.own_problem import own_problem
from galvi import Problem
from reports.results.suite import Suite

Own = Mapping[str, tuple[Problem, float]]


def with_problems(suite: Suite, paths: Sequence[str], sent: bool = False) -> Suite:
    """The suite with the comparisons on these problems, and no other ones, no studies or targets.

    sent  whether they are sent to the process of an external integrator

    Raises typer.BadParameter for a path that cannot be loaded, for two problems of one name, and
    for one that must be sent and cannot be.
    """
    own: dict[str, tuple[Problem, float]] = {}
    for path in dict.fromkeys(paths):
        try:
            problem, duration = load_problem(path)
        except ContenderError as error:
            raise typer.BadParameter(f"--problem {path}: {error}.") from None
        try:
            pickle.dumps(problem if sent else None)
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            raise typer.BadParameter(
                f"--problem {path}: with --contender its functions must be at the top level of "
                f"their module, as it is sent to another process; received: {error}."
            ) from None
        if problem.name in own:
            raise typer.BadParameter(f"--problem: two are called {problem.name!r}.")
        own[problem.name] = (problem, duration)
    return replace(
        suite,
        problems=lambda quick: tuple(own),
        work_precision=partial(_compared, suite.work_precision, own),
        cost=lambda quick, report: pd.DataFrame(columns=[one.name for one in COLUMNS]),
        targets=(),
        sections=(),
    )


def _compared(
    measure: Any, own: Own, quick: bool, report: Callable[[str], None], problem: str, **more: Any
) -> pd.DataFrame:
    """The measurements on one of them."""
    case = own_problem(*own[problem], quick, report)
    return measure(quick, report, problem=problem, cases=(case,), **more)
