"""Every claim sees the mistakes that its file declares."""

from __future__ import annotations

import pytest

from benchmarks.checks.claim import Claim
from benchmarks.checks.faults import Fault
from benchmarks.claims import AGREEMENTS, CLAIMS
from tests.suite.benchmarks.planted_tables import contradicted
from tests.suite.benchmarks.quick_studies import quick

FAULTS = [(claim, fault) for claim in (*CLAIMS, *AGREEMENTS) for fault in claim.caught]
# Claims whose quick studies take more than a second; the faults of others are of the same kinds.
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
            id=f"{claim.id}: {fault.what}",
            marks=[pytest.mark.slow] * (claim.id in SLOW),
        )
        for claim, fault in FAULTS
    ],
)
def test_a_planted_fault_is_caught(claim: Claim, fault: Fault) -> None:
    assert fault.seen <= contradicted(claim, fault) | not_run_for_want_of_an_engine(claim)


def not_run_for_want_of_an_engine(claim: Claim) -> set[str]:
    if claim not in AGREEMENTS:
        return set()
    return {row.quantity for row in claim.judge(quick(claim)) if row.absent}


def test_every_claim_declares_a_fault_and_tells_them_apart() -> None:
    assert [claim.id for claim in CLAIMS if not claim.caught] == []
    assert len({(claim.id, fault.what) for claim, fault in FAULTS}) == len(FAULTS)
