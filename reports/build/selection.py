"""Claims that `verify` is to check: those with checks that match an expression, or that failed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pandas as pd
import typer
from _pytest.mark.expression import Expression

from benchmarks.checks.claim import Claim
from reports.results.comparison import written
from reports.results.options import Options
from reports.results.suite import Suite


def selected(suite: Suite, options: Options, expression: str, last_failed: bool) -> Options:
    """The options with fewer claims.

    expression   words of a check's name, source or claim, with `and`, `or`, `not`; "" for any
    last_failed  only claims that have failed in this folder; all, where none of them has

    Raises typer.BadParameter where no check matches.
    """
    claims = [claim for claim in suite.claims if not options.claims or claim.id in options.claims]
    if expression:
        claims = _matching(claims, expression)
    rows = written(options.out / "claims.csv", "id", {}) if last_failed else None
    if rows is not None:
        failed = set(rows["id"][rows["verdict"] != rows["expected"]])
        claims = [claim for claim in claims if claim.id in failed] or claims
    return replace(options, claims=tuple(claim.id for claim in claims))


def _matching(claims: Sequence[Claim], expression: str) -> list[Claim]:
    """The claims with a check that matches."""
    try:
        compiled = Expression.compile(expression)
    except Exception as error:  # of a class that depends on the version of pytest
        raise typer.BadParameter(f"-k {expression} is no expression of pytest: {error}.") from None
    matching = [
        claim
        for claim in claims
        if any(compiled.evaluate(lambda word, text=text: word.lower() in text)
               for text in _texts(claim))
    ]  # fmt: skip
    if not matching:
        raise typer.BadParameter(
            f"-k {expression} leaves no check; it takes words of names, ids and sources."
        )
    return matching


def _texts(claim: Claim) -> list[str]:
    """What names each check of a claim; only its title, where just a measurement shows them."""
    try:
        rows = claim.judge(pd.DataFrame())
    except Exception:  # it is judged, and told, when it has been measured
        rows = []
    names = [(row.quantity, row.source) for row in rows] or [(claim.title,)]
    return [" ".join((claim.id, *texts)).lower() for texts in names]
