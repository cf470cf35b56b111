"""The claims of the papers as executable checks, one file each."""

from benchmarks.claim import Claim
from benchmarks.claims.l1 import L1
from benchmarks.claims.l2 import L2
from benchmarks.claims.l3 import L3
from benchmarks.claims.l4 import L4
from benchmarks.claims.l5 import L5
from benchmarks.claims.l6 import L6
from benchmarks.claims.l7 import L7
from benchmarks.claims.l8 import L8
from benchmarks.claims.l9 import L9
from benchmarks.claims.l10 import L10
from benchmarks.claims.l11 import L11
from benchmarks.claims.l12 import L12
from benchmarks.claims.l13 import L13
from benchmarks.claims.l14 import L14
from benchmarks.claims.l15 import L15
from benchmarks.claims.l16 import L16
from benchmarks.claims.v1 import V1
from benchmarks.claims.v2 import V2
from benchmarks.claims.v3 import V3
from benchmarks.claims.v4 import V4
from benchmarks.claims.v5 import V5
from benchmarks.claims.v6 import V6
from benchmarks.claims.v7 import V7
from benchmarks.claims.v8 import V8
from benchmarks.claims.v9 import V9
from benchmarks.claims.v10 import V10
from benchmarks.claims.v11 import V11

CLAIMS: tuple[Claim, ...] = (
    *(V1, V2, V3, V4, V5, V6, V7, V8, V9, V10, V11),
    *(L1, L2, L3, L4, L5, L6, L7, L8, L9, L10, L11, L12, L13, L14, L15, L16),
)

__all__ = ["CLAIMS", "Claim"]
