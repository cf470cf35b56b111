"""A suite that somebody else's contenders take part in, as they were named on the command line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import typer

from benchmarks.external.checks import contender_checks
from benchmarks.external.integrator import ExternalIntegrator
from benchmarks.external.loading import ContenderError
from reports.results.suite import Suite


@contextmanager
def joined(suite: Suite, paths: Sequence[str]) -> Iterator[Suite]:
    """The suite with checks of these contenders, and with them in every comparison that is open.

    Their processes end with it.

    Raises typer.BadParameter, in a sentence, for a path that leads to no contender.
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
        yield replace(
            suite,
            claims=(*suite.claims, *contender_checks(externals)),
            work_precision=partial(suite.work_precision, externals=externals),
            sections=tuple(_with_externals(section, externals) for section in suite.sections),
            faults=lambda: [fault for external in externals for fault in external.faults],
        )


def _with_externals(one: Any, externals: Sequence[ExternalIntegrator]) -> Any:
    """A table or a study in which these take part, if it is open to external integrators."""
    return replace(one, measure=partial(one.measure, externals=externals)) if one.open else one
