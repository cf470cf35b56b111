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
from benchmarks.claims.v12 import V12
from benchmarks.claims.v13 import V13
from benchmarks.claims.v14 import V14
from benchmarks.claims.v15 import V15
from benchmarks.claims.v16 import V16
from benchmarks.claims.v17 import V17
from benchmarks.claims.v18 import V18
from benchmarks.claims.v19 import V19
from benchmarks.claims.v20 import V20
from benchmarks.claims.v21 import V21
from benchmarks.claims.v22 import V22
from benchmarks.claims.v23 import V23
from benchmarks.claims.v24 import V24
from benchmarks.claims.v25 import V25

CLAIMS: tuple[Claim, ...] = (
    *(V1, V2, V3, V4, V5, V6, V7, V8, V9, V10, V11),
    *(V12, V13, V14, V15, V16, V17, V18, V19, V20, V21, V22, V23, V24, V25),
    *(L1, L2, L3, L4, L5, L6, L7, L8, L9, L10, L11, L12, L13, L14, L15, L16),
)

__all__ = ["CLAIMS", "Claim"]
