"""Suites with integrators and problems of users, and the availability of optional engines."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import pandas as pd
import typer

from benchmarks.applications.external.checks import contender_checks
from benchmarks.applications.external.integrator import TIME_LIMIT, ExternalIntegrator
from benchmarks.applications.external.loading import ContenderError
from benchmarks.applications.external.own_problems import load_problem, require_sendable
from benchmarks.work_precision.cost import COLUMNS
from benchmarks.work_precision.own_problem import own_problem
from galvi import Problem
from references.setting import nearest
from reports.results.suite import Suite


@dataclass(frozen=True)
class Engines:
    """The optional engines.

    Attributes
    ----------
    absence
        name of an engine -> why it cannot be used here; "" if it can
    required
        names of engines that must be available
    """

    absence: Mapping[str, str] = field(default_factory=dict)
    required: tuple[str, ...] = ()

    @property
    def missing(self) -> tuple[str, ...]:
        """The required engines that are missing."""
        return tuple(name for name in self.required if self.absence[name])

    def sentences(self) -> list[str]:
        """One sentence for each missing engine."""
        return [
            f"{name} is absent{', and was required' if name in self.required else ''}: {why}"
            for name, why in self.absence.items()
            if why
        ]


@contextmanager
def with_contenders(
    suite: Suite, paths: Sequence[str], timeout: float | None = None
) -> Iterator[Suite]:
    """The suite with external integrators in its claims, its comparisons and its open studies.

    Parameters
    ----------
    paths
        "package.module:Class" of each integrator
    timeout
        seconds for each answer of an integrator; None for the default

    Notes
    -----
    The processes of the integrators end with the context. Raises typer.BadParameter for a path
    that cannot be loaded, and for two integrators of the same name.
    """
    if not paths:
        yield suite
        return
    with ExitStack() as stack:
        externals: list[ExternalIntegrator] = []
        for path in dict.fromkeys(paths):
            try:
                external = ExternalIntegrator.open(path, TIME_LIMIT if timeout is None else timeout)
            except ContenderError as error:
                raise typer.BadParameter(f"--contender {path}: {error}") from None
            stack.callback(_report_printed, external)
            stack.callback(external.close)
            if external.name in [opened.name for opened in externals]:
                raise typer.BadParameter(f"--contender: two are called {external.name!r}.")
            externals.append(external)
        claims = contender_checks(externals)
        definitions = {
            claim.id: external.defined_at for claim, external in zip(claims, externals, strict=True)
        }
        yield replace(
            suite,
            claims=(*suite.claims, *claims),
            definitions=definitions,
            work_precision=partial(suite.work_precision, externals=externals),
            sections=tuple(
                replace(
                    section, measure=partial(section.measure, externals=externals), timed=True
                )  # timed studies run in this process, to which those of the integrators answer
                if section.open
                else section
                for section in suite.sections
            ),
            faults=lambda: [fault for external in externals for fault in external.faults],
        )


def _report_printed(external: ExternalIntegrator) -> None:
    """Report on standard error what the processes of an integrator, which have ended, printed."""
    if printed := external.printed.sentence():
        typer.echo(f"{external.name} {printed}", err=True)


ProblemsByName = Mapping[str, tuple[Problem, float]]


def with_problems(suite: Suite, paths: Sequence[str], must_be_sendable: bool = False) -> Suite:
    """The suite with comparisons on these problems alone, without costs, studies and targets.

    Parameters
    ----------
    paths
        "package.module:function" of each problem
    sent
        whether the problems are sent to the process of an external integrator

    Notes
    -----
    Raises typer.BadParameter for a path that cannot be loaded, for two problems of the same name,
    and for a problem that must be sent but cannot be.
    """
    by_name: dict[str, tuple[Problem, float]] = {}
    for path in dict.fromkeys(paths):
        try:
            problem, duration = load_problem(path)
            if must_be_sendable:
                require_sendable(problem)
        except ContenderError as error:
            raise typer.BadParameter(f"--problem {path}: {error}.") from None
        if problem.name in by_name:
            raise typer.BadParameter(f"--problem: two are called {problem.name!r}.")
        by_name[problem.name] = (problem, duration)
    return replace(
        suite,
        problems=lambda quick: tuple(by_name),
        work_precision=partial(_compare_on, suite.work_precision, by_name),
        cost=lambda quick, report: pd.DataFrame(columns=[column.name for column in COLUMNS]),
        targets=(),
        sections=(),
    )


def _compare_on(
    measure: Any,
    by_name: ProblemsByName,
    quick: bool,
    report: Callable[[str], None],
    problem: str,
    **options: Any,
) -> pd.DataFrame:
    """The rows of `measure` on the user's problem of this name."""
    case = own_problem(*by_name[problem], quick, report)
    return measure(quick, report, problem=problem, cases=(case,), **options)


def with_selected_problems(suite: Suite, text: str, quick: bool) -> Suite:
    """The suite with the comparisons, costs and targets of some problems, and without studies.

    Parameters
    ----------
    text
        parts of the problems' names, in any case, separated by commas

    Raises
    ------
    ValueError
        If `text` has no part, or no name contains one of the parts.
    """
    names = suite.problems(quick)
    parts = [word.strip() for word in text.split(",") if word.strip()]
    if not parts:
        raise ValueError(f"expected parts of problems' names; received {text!r}.")
    for word in parts:
        if not any(word.casefold() in name.casefold() for name in names):
            raise ValueError(
                f"there is no problem {word!r} to compare on; did you mean "
                f"{nearest(word, names)!r} (known: {', '.join(names)})?"
            )
    selected_names = [
        name for name in names if any(word.casefold() in name.casefold() for word in parts)
    ]
    return replace(
        suite,
        problems=lambda quick: selected_names,
        cost=partial(suite.cost, only=selected_names),
        targets=tuple(target for target in suite.targets if target.problem in selected_names),
        sections=(),
    )
