"""A claim of a paper as an executable check: a study that measures, and a judge that compares."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pandas as pd

from benchmarks.checks.bounds import HOLDS, NOT_RUN, Bound
from benchmarks.statistics.estimate import Measurement, estimate

MakeMethod = Callable[..., Any]  # of a space, a rule and perhaps a chart
Report = Callable[[str], None]
AGREEMENT = "agreement"  # the source of a row that is no claim of a paper, but of two codes
SHARED = ("source", "setup", "claimed", "reason", "reference")  # of a claim, for all its rows


@dataclass(frozen=True)
class Row:
    """One line of claims.csv: what is claimed, what was measured, and the verdict.

    id           of the claim, e.g. "V3"; several rows may share one
    quantity     what is measured, e.g. "base of one-step error"
    source       figure or theorem of the paper
    setup        problem, method and steps in one line
    claimed      the paper's statement as it stands there
    bound        the number or interval that the verdict compares with, in words
    measured     the number found
    uncertainty  of the measured number (one standard deviation of a fit), or None
    expected     the verdict expected when the row was written
    reason       why that is expected
    reference    the independent truth, with its version where it is an engine
    verdict      "holds", "exceeds", "contradicted", "not run" or "informative"
    """

    id: str
    quantity: str
    source: str = ""
    setup: str = ""
    claimed: str = ""
    bound: str = ""
    measured: float | None = None
    uncertainty: float | None = None
    expected: str = HOLDS
    reason: str = ""
    reference: str = ""
    verdict: str = NOT_RUN


def judged(id: str, quantity: str, bound: Bound, measured: Measurement, **texts: str) -> Row:
    """The row of a measurement and its bound; `texts` are the row's other fields."""
    seen = estimate(measured)
    return Row(
        id=id,
        quantity=quantity,
        bound=bound.text,
        measured=_finite(seen.value),
        uncertainty=_finite(seen.uncertainty),
        verdict=bound.verdict(measured),
        **texts,
    )


def _finite(number: float | None) -> float | None:
    return number if number is not None and math.isfinite(number) else None


@dataclass(frozen=True)
class Claim:
    """A study, which runs methods once, and a judge, which only reads its tidy frame.

    id       e.g. "V3"
    title    one line for a heading
    study    (make_method, quick, report) -> tidy frame; make_method is `galvi.Galerkin` unless a
             test hands in a broken one; report(sentence) reports progress
    judge    frame -> rows
    figures  of the paper, e.g. "H fig. 2.6"
    timed    whether the study takes times, and has to be alone
    source, setup, claimed, reason, reference
             of each `row` of the claim that does not state its own; see `Row`. The source is
             that of the figures where none is stated
    """

    id: str
    title: str
    study: Callable[[MakeMethod, bool, Report], pd.DataFrame]
    judge: Callable[[pd.DataFrame], list[Row]]
    figures: tuple[str, ...] = ()
    timed: bool = False
    source: str = ""
    setup: str = ""
    claimed: str = ""
    reason: str = ""
    reference: str = ""

    def row(self, quantity: str, bound: Bound, measured: Measurement, **own: str) -> Row:
        """A row of this claim, with its own texts in the place of the claim's.

        own  any of source, setup, claimed, reason, reference and expected, which is "holds"
        """
        shared = {name: getattr(self, name) for name in SHARED}
        shared["source"] = self.source or ", ".join(self.figures)
        return judged(self.id, quantity, bound, measured, **{**shared, **own})
