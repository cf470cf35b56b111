"""The claims of the papers as executable checks, one file each."""

from benchmarks.claim import Claim
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

CLAIMS: tuple[Claim, ...] = (V1, V2, V3, V4, V5, V6, V7, V8, V9, V10, V11)

__all__ = ["CLAIMS", "Claim"]
