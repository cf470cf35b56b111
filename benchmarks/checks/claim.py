"""A claim of a paper as an executable check: a study that measures, and a judge that compares."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

MakeMethod = Callable[..., Any]  # of a space, a rule and perhaps a chart
Report = Callable[[str], None]
AGREEMENT = "agreement"  # the source of a row that is no claim of a paper, but of two codes


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
    verdict      "holds", "exceeds", "contradicted" or "not run"
    """

    id: str
    quantity: str
    source: str
    setup: str
    claimed: str
    bound: str
    measured: float | None
    uncertainty: float | None
    expected: str
    reason: str
    reference: str
    verdict: str


@dataclass(frozen=True)
class Claim:
    """A study, which runs methods once, and a judge, which only reads its tidy frame.

    id      e.g. "V3"
    title   one line for a heading
    study   (make_method, quick, report) -> tidy frame; make_method is `galvi.Galerkin` unless a
            test hands in a broken one; report(sentence) tells progress
    judge   frame -> rows
    timed   whether the study takes times, and has to be alone
    """

    id: str
    title: str
    study: Callable[[MakeMethod, bool, Report], pd.DataFrame]
    judge: Callable[[pd.DataFrame], list[Row]]
    figures: tuple[str, ...] = field(default=())
    timed: bool = False
