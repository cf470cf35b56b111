"""Every claim sees the mistakes that its file declares."""

from __future__ import annotations

import pytest

from benchmarks.checks.claim import Claim
from benchmarks.checks.faults import Fault
from benchmarks.claims import CLAIMS
from tests.benchmarks.planted_tables import contradicted

FAULTS = [(claim, fault) for claim in CLAIMS for fault in claim.caught]


@pytest.mark.parametrize(
    ("claim", "fault"), FAULTS, ids=[f"{claim.id}: {fault.what}" for claim, fault in FAULTS]
)
def test_a_planted_fault_is_caught(claim: Claim, fault: Fault) -> None:
    assert fault.is_seen(contradicted(claim, fault))


def test_every_claim_declares_a_fault_and_tells_them_apart() -> None:
    assert [claim.id for claim in CLAIMS if not claim.caught] == []
    assert len({(claim.id, fault.what) for claim, fault in FAULTS}) == len(FAULTS)
