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
from benchmarks.store.tables import table_of
from references import EngineMissing
from reports.results.cache import BuildCache, CachedResult, Study


@dataclass(frozen=True, eq=False)
class ClaimResult:
    """A claim with its table and rows.

    Attributes
    ----------
    table
        the study's tidy table; None if the study raised, or its table is not stored
    rows
        its checks; "not run", with the exception as reason, if the study raised
    seconds
        run time of the study; 0 if it raised, NaN if unknown
    run
        start date of the run that measured it; "" for this run
    """

    claim: Claim
    table: pd.DataFrame | None
    rows: tuple[Row, ...]
    seconds: float
    run: str = ""


def claim_studies(claims: Iterable[Claim], quick: bool) -> list[Study]:
    """The studies of these claims; the names of their results are the ids of the claims."""
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
    """Run the studies that the cache lacks, those with timings last, and check each claim.

    Progress goes to stderr.

    Parameters
    ----------
    cache
        the build's result cache; None stores nothing
    """
    cache = cache or BuildCache()
    errors = cache.measure(sorted(claim_studies(claims, quick), key=lambda study: study.timed))
    return [
        ClaimResult(claim, None, _rows_not_run(claim, errors[claim.id]), 0.0)
        if claim.id in errors
        else _claim_result(claim, cache.entries[claim.id])
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


def _claim_result(claim: Claim, measurement: CachedResult) -> ClaimResult:
    try:
        rows = tuple(
            _with_statuses(row, measurement.table) for row in claim.check(measurement.table)
        )
        if not rows:
            raise ValueError("its judge returned no row, so nothing was checked")
    except Exception as error:
        rows = _rows_not_run(claim, error)
    return ClaimResult(claim, measurement.table, rows, measurement.seconds, measurement.run)


def _with_statuses(row: Row, measured: pd.DataFrame) -> Row:
    """The row; if it was unexpectedly not run, with the statuses of its study as reason."""
    if row.verdict != NOT_RUN or row.expected == NOT_RUN:
        return row
    statuses = dict.fromkeys(text for text in measured.get("status", ()) if text)
    why = " ".join(statuses) or "There are too few numbers to judge by."
    return replace(row, reason=f"{why} Expected was {row.expected}: {row.reason}")


def _rows_not_run(claim: Claim, error: Exception) -> tuple[Row, ...]:
    """The claim's rows without measurements, with the exception as reason.

    If an engine is missing, "not run" is the expected verdict.
    """
    why = visible(f"{type(error).__name__}: {' '.join(str(error).split()) or 'no message'}")
    try:
        rows = claim.check(table_of([]))
    except Exception:
        rows = []
    missing_engine = error.name or "" if isinstance(error, EngineMissing) else ""
    return tuple(
        replace(
            row,
            measured=None,
            uncertainty=None,
            verdict=NOT_RUN,
            reason=why,
            absent=missing_engine,
            expected=NOT_RUN if missing_engine else row.expected,
        )
        for row in rows or [Row(claim.id, claim.title, expected="")]
    )
