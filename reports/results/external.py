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
from benchmarks.external.timed_run import Faulty
from reports.results.suite import Suite


@contextmanager
def joined(suite: Suite, paths: Sequence[str]) -> Iterator[Suite]:
    """The suite with checks of these contenders, and with them in whatever is open to them.

    Their processes end with it.

    Raises typer.BadParameter, in a sentence, for a path that leads to no contender.
    """
    if not paths:
        yield suite
        return
    with ExitStack() as stack:
        outsiders: list[ExternalIntegrator] = []
        for path in dict.fromkeys(paths):
            try:
                outsider = ExternalIntegrator.open(path)
            except Faulty as fault:
                raise typer.BadParameter(f"--contender {path}: {fault}") from None
            stack.callback(outsider.close)
            if outsider.name in [one.name for one in outsiders]:
                raise typer.BadParameter(f"--contender: two are called {outsider.name!r}.")
            outsiders.append(outsider)
        yield replace(
            suite,
            claims=(*suite.claims, *contender_checks(outsiders)),
            work_precision=partial(suite.work_precision, outsiders=outsiders),
            sections=tuple(_opened(section, outsiders) for section in suite.sections),
            faults=lambda: [fault for outsider in outsiders for fault in outsider.faults],
        )


def _opened(one: Any, outsiders: Sequence[ExternalIntegrator]) -> Any:
    """A table or a study in which these take part, where it is open."""
    return replace(one, measure=partial(one.measure, outsiders=outsiders)) if one.open else one
