"""Run the studies of the claims and judge them; a study that raises spoils its own claim only.

A row that could not be had because an engine is absent is expected not to run: it is listed with
the sentence that says so, and `verify --require` makes the absence a failure.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from typing import Any

import pandas as pd

from benchmarks.checks.bounds import NOT_RUN
from benchmarks.checks.claim import Claim, Row
from benchmarks.store.frames import frame
from reports.build.parallel_claims import ahead
from reports.results.cache import Parts
from reports.results.progress import Studies


@dataclass(frozen=True, eq=False)
class ClaimResult:
    """A claim with what came of it.

    frame    the study's tidy frame; None when the study raised
    rows     the judge's rows; those of a claim whose study raised are "not run", with the exception
    seconds  the study took
    run      when the run began that measured it; empty for this one
    """

    claim: Claim
    frame: pd.DataFrame | None
    rows: tuple[Row, ...]
    seconds: float
    run: str = ""


def check(
    claims: Iterable[Claim],
    make_method: Any,
    quick: bool,
    absent: Collection[str] = (),
    parts: Parts | None = None,
) -> list[ClaimResult]:
    """Study and judge each claim, those that take times at the end; progress on stderr.

    absent  the sentences by which engines that are not there say so
    parts   of a build: its studies; None keeps none
    """
    claims, parts = tuple(claims), parts or Parts()
    with Studies(len(claims)) as studies:
        untimed = [claim for claim in claims if not claim.timed]
        with ahead(parts, untimed, quick):
            found = [_check(one, make_method, quick, absent, studies, parts) for one in untimed]
        timed = [claim for claim in claims if claim.timed]
        found += [_check(one, make_method, quick, absent, studies, parts) for one in timed]
    places = {id(claim): place for place, claim in enumerate(claims)}
    return sorted(found, key=lambda one: places[id(one.claim)])


def _check(
    claim: Claim,
    make_method: Any,
    quick: bool,
    absent: Collection[str],
    studies: Studies,
    parts: Parts,
) -> ClaimResult:
    start = time.perf_counter()
    part = None
    try:
        with studies(claim.id, claim.title) as report:
            part = parts.part(claim.id, lambda: claim.study(make_method, quick, report))
            rows = tuple(_explained(row, part.frame) for row in claim.judge(part.frame))
            if not rows:
                raise ValueError("its judge gave no row, so that nothing of it was checked")
    except Exception as error:
        rows = _spoiled(claim, error)
    excused = tuple(_excused(row, absent) for row in rows)
    if part is None:
        return ClaimResult(claim, None, excused, time.perf_counter() - start)
    return ClaimResult(claim, part.frame, excused, part.seconds, part.run)


def _excused(row: Row, absent: Collection[str]) -> Row:
    """A row that was not run and says that an engine is absent is as expected; others stay."""
    if row.verdict != NOT_RUN or not any(sentence in row.reason for sentence in absent):
        return row
    return replace(row, expected=NOT_RUN)


def _explained(row: Row, measured: pd.DataFrame) -> Row:
    """A row that could not be judged tells what its study's runs say of it; others stay."""
    if row.verdict != NOT_RUN or row.expected == NOT_RUN:
        return row
    said = dict.fromkeys(text for text in measured.get("status", ()) if text)
    why = " ".join(said) or "There are too few numbers to judge by."
    return replace(row, reason=f"{why} Expected was {row.expected}: {row.reason}")


def _spoiled(claim: Claim, error: Exception) -> tuple[Row, ...]:
    """The rows that the claim has when nothing was measured, with what the exception says."""
    why = f"{type(error).__name__}: {' '.join(str(error).split()) or 'no message'}"
    try:
        rows = claim.judge(frame([]))
    except Exception:
        rows = []
    blank = Row(
        id=claim.id,
        quantity=claim.title,
        source="",
        setup="",
        claimed="",
        bound="",
        measured=None,
        uncertainty=None,
        expected="",
        reason="",
        reference="",
        verdict=NOT_RUN,
    )
    return tuple(
        replace(row, measured=None, uncertainty=None, verdict=NOT_RUN, reason=why)
        for row in rows or [blank]
    )
