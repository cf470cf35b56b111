"""Quick studies: each claim has its expected verdict, and its check catches planted faults."""

from __future__ import annotations

from dataclasses import fields

import pandas as pd
import pytest

from benchmarks.checks.bounds import HOLDS, NOT_RUN, VERDICTS, AtMost
from benchmarks.checks.claim import Claim, Row, checked_row
from benchmarks.checks.faults import Fault
from benchmarks.claims import AGREEMENTS, CLAIMS
from benchmarks.store.tables import COLUMNS
from tests.suite.benchmarks.planted_tables import contradicted
from tests.suite.benchmarks.quick_studies import quick

BY_ID = pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.id)


def test_the_claims_are_numbered_without_a_gap() -> None:
    ids = [claim.id for claim in CLAIMS]
    for letter, at_least in (("V", 25), ("L", 16)):
        numbered = [id for id in ids if id[0] == letter]
        assert numbered == [f"{letter}{k}" for k in range(1, max(at_least, len(numbered)) + 1)]
    assert {id[0] for id in ids} == {"V", "L"}


def test_every_statement_begins_with_its_source() -> None:
    without = [claim.id for claim in CLAIMS if not claim.statement.startswith(("H ", "M ", "Ours"))]
    assert without == []


def test_a_row_has_its_numbers_and_a_verdict() -> None:
    row = checked_row("V0", "an error", AtMost(1.0), 0.5, claimed="O(h^2)", reason="none")
    assert (row.claimed, row.reason, row.bound) == ("O(h^2)", "none", "at most 1")
    assert (row.measured, row.uncertainty, row.verdict) == (0.5, None, HOLDS) and row.slack == 2.0
    missing = checked_row("V0", "an error", AtMost(1.0), float("nan"))
    assert (missing.measured, missing.uncertainty, missing.verdict) == (None, None, NOT_RUN)
    with pytest.raises(TypeError, match="colour"):
        checked_row("V0", "an error", AtMost(1.0), 0.5, colour="blue")


@pytest.mark.slow_cases(
    but=[
        "V2",
        "V8",
        "V10",
        "V12",
        "V13",
        "V17",
        "V18",
        "V21",
        "V24",
        "V27",
        "V32",
        "V36",
        "L2",
        "L3",
        "L4",
        "L5",
        "L6",
        "L7",
        "L10",
        "L12",
        "L13",
        "L15",
    ]
)
@BY_ID
def test_every_row_has_the_verdict_expected_of_it(claim: Claim) -> None:
    table = quick(claim)
    assert tuple(table.columns) == tuple(COLUMNS)
    rows = claim.check(table)
    different = [row for row in rows if row.verdict != row.expected]
    assert different == []
    assert rows == claim.check(table.sample(frac=1.0, random_state=1)), "the order of rows matters"
    for row in rows:
        assert row.id == claim.id
        assert row.expected in VERDICTS
        assert isinstance(row.measured, float)
        assert row.uncertainty is None or row.uncertainty > 0.0
        empty = {f.name for f in fields(Row) if getattr(row, f.name) == ""}
        assert {"absent"} <= empty <= {"absent", "slopes"}  # no package absent; slopes of fits only


@pytest.mark.parametrize("claim", (*CLAIMS, *AGREEMENTS), ids=lambda claim: claim.id)
def test_nothing_measured_is_never_a_success_and_rows_are_told_apart(claim: Claim) -> None:
    rows = claim.check(pd.DataFrame())
    assert rows and all(row.verdict == NOT_RUN for row in rows)
    assert len({row.quantity for row in rows}) == len(rows)


# ---- the faults that each claim declares in `caught`

FAULTS = [(claim, fault) for claim in (*CLAIMS, *AGREEMENTS) for fault in claim.caught]
# Claims whose faults are slow to check; the faults of the others are of the same kinds.
SLOW = (
    *("V3", "V4", "V6", "V7", "V9", "V11", "V14", "V15", "V16", "V19", "V20", "V22", "V23"),
    *("V25", "V26", "V28", "V29", "V30", "V33", "V34", "V35", "V36"),
    *("L3", "L6", "L8", "L9", "L11", "L14", "L15", "L16", "L17", "L18"),
)


@pytest.mark.parametrize(
    ("claim", "fault"),
    [
        pytest.param(
            claim,
            fault,
            id=f"{claim.id}: {fault.name}",
            marks=[pytest.mark.slow] * (claim.id in SLOW),
        )
        for claim, fault in FAULTS
    ],
)
def test_a_planted_fault_is_caught(claim: Claim, fault: Fault) -> None:
    assert fault.contradicted <= contradicted(claim, fault) | not_run_for_want_of_an_engine(claim)


def not_run_for_want_of_an_engine(claim: Claim) -> set[str]:
    """The quantities of an agreement that were not measured since a package is absent."""
    if claim not in AGREEMENTS:
        return set()
    return {row.quantity for row in claim.check(quick(claim)) if row.absent}


def test_every_claim_declares_a_fault_and_tells_them_apart() -> None:
    assert [claim.id for claim in CLAIMS if not claim.caught] == []
    assert len({(claim.id, fault.name) for claim, fault in FAULTS}) == len(FAULTS)
