"""A claim of a paper as an executable check: a study that measures, and a comparison."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pandas as pd

from benchmarks.checks.bounds import (
    ATTAINED,
    HOLDS,
    NOT_RUN,
    Bound,
    Finding,
    Order,
    Reported,
)
from benchmarks.checks.faults import Fault
from benchmarks.statistics.convergence_fits import Fit
from benchmarks.statistics.estimate import Measurement, estimate

MakeMethod = Callable[..., Any]  # (space, rule, and perhaps a chart) -> method
Report = Callable[[str], None]
SHOWN_SLOPES = 4  # largest number of local slopes in the text of a row
AGREEMENT = "agreement"  # the source of rows that compare two codes instead of checking a claim


@dataclass(frozen=True)
class Row:
    """One line of claims.csv: the claim, the measurement and the verdict.

    Attributes
    ----------
    id
        id of the claim, e.g. "V3"; several rows may share one
    quantity
        the measured quantity, e.g. "base of one-step error"
    source
        figure or theorem of the paper
    setup
        problem, method and steps in one line
    claimed
        the paper's statement, verbatim
    bound
        the bound that the verdict rests on, in words
    measured
        the measured number
    uncertainty
        standard error of the measured number; None where it is not known
    slack
        factor between measured number and bound of a row that holds; None for others
    slopes
        local slopes of a fitted order, coarse to fine, at most SHOWN_SLOPES of the finest; "" for
        others
    misses
        distance of an order from its expected value, in its standard errors; None where that value
        is not known
    expected
        the verdict expected when the row was written
    reason
        reason for the expected verdict
    reference
        the independent truths, with the versions of their engines
    verdict
        a verdict of `benchmarks.checks.bounds.VERDICTS`
    absent
        the missing package because of which it was not run, which is then expected; or ""
    """

    id: str
    quantity: str
    source: str = ""
    setup: str = ""
    claimed: str = ""
    bound: str = ""
    measured: float | None = None
    uncertainty: float | None = None
    slack: float | None = None
    slopes: str = ""
    misses: float | None = None
    expected: str = HOLDS
    reason: str = ""
    reference: str = ""
    verdict: str = NOT_RUN
    absent: str = ""


def checked_row(id: str, quantity: str, bound: Bound, measured: Measurement, **texts: str) -> Row:
    """The row of a measurement and its bound; `texts` are further fields.

    Without `expected` in `texts`, the expected verdict is that of a bound that is met.
    """
    estimated = estimate(measured)
    texts = {"expected": bound.met, **texts}
    return Row(
        id=id,
        quantity=quantity,
        bound=bound.text,
        measured=_finite(estimated.value),
        uncertainty=_finite(estimated.uncertainty),
        slack=_finite(bound.slack(measured)),
        slopes=_slopes(measured),
        misses=_misses(bound, texts["expected"], measured),
        verdict=bound.verdict(measured),
        **texts,
    )


def _slopes(measured: Measurement) -> str:
    if not isinstance(measured, Fit):
        return ""
    finest = ", ".join(f"{slope:.2f}" for slope in measured.slopes[-SHOWN_SLOPES:])
    return f"{finest}; not settled" if measured.bend else finest


def _misses(bound: Bound, expected: str, measured: Measurement) -> float | None:
    """The distance of a fitted order from the order of its bound, in standard errors; None where
    the bound names no order."""
    if isinstance(bound, Reported):
        bound = bound.reported if expected == bound.reported.met else bound.instead
    elif isinstance(bound, Finding) and bound.our_bound is not None:
        bound = bound.our_bound
    elif expected != ATTAINED:
        return None
    if not (isinstance(bound, Order) and isinstance(measured, Fit) and measured.uncertainty > 0.0):
        return None
    error = math.hypot(measured.uncertainty, bound.uncertainty or 0.0)
    return _finite((measured.rate - bound.claimed) / error)


def _finite(number: float | None) -> float | None:
    return number if number is not None and math.isfinite(number) else None


@dataclass(frozen=True)
class Claim:
    """A study, which runs the methods once, and a function that reads its tidy table.

    Attributes
    ----------
    id
        e.g. "V3"
    title
        one line for a heading
    study
        (make_method, quick, report) -> tidy table; make_method is `galvi.Galerkin`, or a broken one
        in tests; report(sentence) reports progress
    check
        table -> rows
    figures
        the paper's figures, e.g. "H fig. 2.6"
    timed
        whether the study measures times and must run alone
    statement
        what the paper says, and what was measured where that differs, for the page
    notes
        derivations and remarks, for the page
    caught
        mistakes, each of which at least one row must contradict
    """

    id: str
    title: str
    study: Callable[[MakeMethod, bool, Report], pd.DataFrame]
    check: Callable[[pd.DataFrame], list[Row]]
    figures: tuple[str, ...] = ()
    timed: bool = False
    statement: str = ""
    notes: str = ""
    caught: tuple[Fault, ...] = ()
