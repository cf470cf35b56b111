"""Run the studies of the claims and check them; an exception affects only its own claim.

A row whose engine is missing is expected not to run: it is listed with the reason, and
`verify --require` turns the missing engine into a failure.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import pandas as pd

import galvi
from benchmarks.checks.bounds import NOT_RUN
from benchmarks.checks.claim import Claim, Row
from benchmarks.store.foreign_texts import visible
from benchmarks.store.frames import frame
from references import EngineMissing
from reports.results.cache import BuildCache, CachedResult, Study


@dataclass(frozen=True, eq=False)
class ClaimResult:
    """A claim with its table and rows.

    Attributes
    ----------
    table
        the study's tidy table; None when the study raised
    rows
        its checks; "not run", with the exception as reason, when the study raised
    seconds
        run time of the study; 0 when it raised
    run
        start date of the run that measured it; empty for this run
    """

    claim: Claim
    table: pd.DataFrame | None
    rows: tuple[Row, ...]
    seconds: float
    run: str = ""


def claim_studies(claims: Iterable[Claim], quick: bool) -> list[Study]:
    """The studies of these claims; their results are named by the ids."""
    return [
        Study(
            claim.id,
            claim.id,
            claim.title,
            partial(claim.study, galvi.Galerkin, quick),
            claim.timed,
        )
        for claim in claims
    ]


def check(
    claims: Sequence[Claim], quick: bool, cache: BuildCache | None = None
) -> list[ClaimResult]:
    """Check each claim; first run the studies that the cache lacks, those with timings last.
    Progress goes to stderr.

    Parameters
    ----------
    cache
        the build's result cache; None stores nothing
    """
    cache = cache or BuildCache()
    errors = cache.measure(sorted(claim_studies(claims, quick), key=lambda study: study.timed))
    return [
        ClaimResult(claim, None, _spoiled(claim, errors[claim.id]), 0.0)
        if claim.id in errors
        else _judged(claim, cache.entries[claim.id])
        for claim in claims
    ]


def first_measured(checked: Iterable[ClaimResult], claims: Sequence[str]) -> ClaimResult | None:
    """The first of these claims whose study returned a table; None if there is none."""
    measured = {
        claim_result.claim.id: claim_result
        for claim_result in checked
        if claim_result.table is not None
    }
    return next((measured[name] for name in claims if name in measured), None)


def _judged(claim: Claim, measurement: CachedResult) -> ClaimResult:
    try:
        rows = tuple(_explained(row, measurement.table) for row in claim.judge(measurement.table))
        if not rows:
            raise ValueError("its judge gave no row, so that nothing of it was checked")
    except Exception as error:
        rows = _spoiled(claim, error)
    return ClaimResult(claim, measurement.table, rows, measurement.seconds, measurement.run)


def _explained(row: Row, measured: pd.DataFrame) -> Row:
    """Give a row without a verdict the statuses of its study's runs as reason."""
    if row.verdict != NOT_RUN or row.expected == NOT_RUN:
        return row
    statuses = dict.fromkeys(text for text in measured.get("status", ()) if text)
    why = " ".join(statuses) or "There are too few numbers to judge by."
    return replace(row, reason=f"{why} Expected was {row.expected}: {row.reason}")


def _spoiled(claim: Claim, error: Exception) -> tuple[Row, ...]:
    """The claim's rows without measurements, with the exception as reason; for want of an engine
    they are expected."""
    why = visible(f"{type(error).__name__}: {' '.join(str(error).split()) or 'no message'}")
    try:
        rows = claim.judge(frame([]))
    except Exception:
        rows = []
    absent = error.name or "" if isinstance(error, EngineMissing) else ""
    return tuple(
        replace(
            row,
            measured=None,
            uncertainty=None,
            verdict=NOT_RUN,
            reason=why,
            absent=absent,
            expected=NOT_RUN if absent else row.expected,
        )
        for row in rows or [Row(claim.id, claim.title, expected="")]
    )
