"""Integrators and problems of users; which optional engines are installed."""

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
    """Every optional engine.

    Attributes
    ----------
    absence
        name -> why it cannot be used here; empty when it can
    required
        names of engines that must be available
    """

    absence: Mapping[str, str] = field(default_factory=dict)
    required: tuple[str, ...] = ()

    @property
    def wanting(self) -> tuple[str, ...]:
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
def joined(suite: Suite, paths: Sequence[str], timeout: float | None = None) -> Iterator[Suite]:
    """The suite with these external integrators in its checks and in every open comparison.

    Parameters
    ----------
    timeout
        seconds for each of their answers; None for the default

    Notes
    -----
    Their processes end with the context. Raises typer.BadParameter for a path that cannot be
    loaded, and for two integrators of the same name.
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
            stack.callback(_say_printed, external)
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
                )  # in this process, which theirs answer
                if section.open
                else section
                for section in suite.sections
            ),
            faults=lambda: [fault for external in externals for fault in external.faults],
        )


def _say_printed(external: ExternalIntegrator) -> None:
    """Say on standard error that the processes of an integrator, which have ended, printed."""
    if printed := external.printed.sentence():
        typer.echo(f"{external.name} {printed}", err=True)


Own = Mapping[str, tuple[Problem, float]]


def with_problems(suite: Suite, paths: Sequence[str], sent: bool = False) -> Suite:
    """The suite with the comparisons on these problems, and no other ones, no studies or targets.

    Parameters
    ----------
    sent
        whether they are sent to the process of an external integrator

    Notes
    -----
    Raises typer.BadParameter for a path that cannot be loaded, for two problems of one name, and
    for one that must be sent and cannot be.
    """
    by_name: dict[str, tuple[Problem, float]] = {}
    for path in dict.fromkeys(paths):
        try:
            problem, duration = load_problem(path)
            if sent:
                require_sendable(problem)
        except ContenderError as error:
            raise typer.BadParameter(f"--problem {path}: {error}.") from None
        if problem.name in by_name:
            raise typer.BadParameter(f"--problem: two are called {problem.name!r}.")
        by_name[problem.name] = (problem, duration)
    return replace(
        suite,
        problems=lambda quick: tuple(by_name),
        work_precision=partial(_compared, suite.work_precision, by_name),
        cost=lambda quick, report: pd.DataFrame(columns=[column.name for column in COLUMNS]),
        targets=(),
        sections=(),
    )


def _compared(
    measure: Any,
    by_name: Own,
    quick: bool,
    report: Callable[[str], None],
    problem: str,
    **options: Any,
) -> pd.DataFrame:
    """The measurements on one of the user's problems."""
    case = own_problem(*by_name[problem], quick, report)
    return measure(quick, report, problem=problem, cases=(case,), **options)


def narrowed(suite: Suite, text: str, quick: bool) -> Suite:
    """The suite with the comparisons, costs and targets of some problems, and no studies.

    Parameters
    ----------
    text
        parts of their names, in any case, separated by commas

    Raises
    ------
    ValueError
        Without a part, or where one is in no name.
    """
    names = suite.problems(quick)
    parts = [word.strip() for word in text.split(",") if word.strip()]
    if not parts:
        raise ValueError(f"give a part of a problem's name; received {text!r}.")
    for word in parts:
        if not any(word.casefold() in name.casefold() for name in names):
            raise ValueError(
                f"there is no problem {word!r} to compare on; did you mean "
                f"{nearest(word, names)!r} (known: {', '.join(names)})?"
            )
    chosen = [name for name in names if any(word.casefold() in name.casefold() for word in parts)]
    return replace(
        suite,
        problems=lambda quick: chosen,
        cost=partial(suite.cost, only=chosen),
        targets=tuple(target for target in suite.targets if target.problem in chosen),
        sections=(),
    )
