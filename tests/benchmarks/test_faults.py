"""Every claim sees the mistakes that its file declares."""

from __future__ import annotations

import pytest

from benchmarks.checks.claim import Claim
from benchmarks.checks.faults import Fault
from benchmarks.claims import CLAIMS
from tests.benchmarks.planted_tables import contradicted

FAULTS = [(claim, fault) for claim in CLAIMS for fault in claim.caught]


@pytest.mark.slow_cases(
    "V3: beta +1e-06",
    "V4: C +1e-04",
    "V6: A +1e-04",
    "V9: beta +1e-06",
    "V14: beta +1e-09, C +1e-04",
    "V15: beta +1e-06, b +1e-03",
    "V16: A +1e-04",
    "V19: velocity_coefficients +1e-12",
    "V20: C +2e+01",
    "V20: C +1e-07",
    "V20: b +1e-09",
    "V20: A +1e-06",
    "V20: beta +1e-06",
    "V22: A +1e-04, C +1e-03",
    "V22: approximations of degree 1",
    "V23: b +1e-06",
    "V23: drag stronger by a millionth",
    "V23: no drag",
    "V23: rotor late by a millionth of a second",
    "V28: a singularity elsewhere",
    "V29: a state sheared before the step: symplectic, so that only differences tell",
    "V30: C +2e-02, projection +2e-02",
    "V30: a curve from elsewhere",
    "V30: a norm that is too small",
    "V30: another motion of the pendulum",
    "V34: A +1e-06",
    "V34: another force",
    "V34: the action of another motion",
    "V35: g without its slope",
    "L3: psi +1e-04",
    "L3: slope +1e-04",
    "L9: steps in the other chart, which do not jump",
    "L11: a constant that is too good: well",
    "L14: b +1e-06",
    "L15: b +1e-06",
    "L15: integral +1e-04",
    "L15: another weight",
    "L17: b +1e-06",
    "L17: integral +1e-04",
    "L17: clock reversed",
    "L18: integral +1e-09",
    "L18: the cross product of composed with another sign",
    "L18: the cross product of relative with another sign",
)
@pytest.mark.parametrize(
    ("claim", "fault"), FAULTS, ids=[f"{claim.id}: {fault.what}" for claim, fault in FAULTS]
)
def test_a_planted_fault_is_caught(claim: Claim, fault: Fault) -> None:
    assert fault.is_seen(contradicted(claim, fault))


def test_every_claim_declares_a_fault_and_tells_them_apart() -> None:
    assert [claim.id for claim in CLAIMS if not claim.caught] == []
    assert len({(claim.id, fault.what) for claim, fault in FAULTS}) == len(FAULTS)
