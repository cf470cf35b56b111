"""Add external integrators, named on the command line, to a suite."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import typer

from benchmarks.applications.external.checks import contender_checks
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.applications.external.loading import ContenderError
from reports.results.suite import Suite


@contextmanager
def joined(suite: Suite, paths: Sequence[str]) -> Iterator[Suite]:
    """The suite with these external integrators in its checks and in every open comparison.

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
                external = ExternalIntegrator.open(path)
            except ContenderError as error:
                raise typer.BadParameter(f"--contender {path}: {error}") from None
            stack.callback(external.close)
            if external.name in [one.name for one in externals]:
                raise typer.BadParameter(f"--contender: two are called {external.name!r}.")
            externals.append(external)
        open_to_them = {section.title for section in suite.sections if section.open}
        yield replace(
            suite,
            in_workers={k: v for k, v in suite.in_workers.items() if k not in open_to_them},
            claims=(*suite.claims, *contender_checks(externals)),
            work_precision=partial(suite.work_precision, externals=externals),
            sections=tuple(_with_externals(section, externals) for section in suite.sections),
            faults=lambda: [fault for external in externals for fault in external.faults],
        )


def _with_externals(one: Any, externals: Sequence[ExternalIntegrator]) -> Any:
    """The section with these participants, if it is open to external integrators."""
    return replace(one, measure=partial(one.measure, externals=externals)) if one.open else one
