"""Random numbers as a function of a key and a counter: Philox4x32-10.

Salmon, Moraes, Dror and Shaw, Parallel random numbers: as easy as 1, 2, 3, SC '11 (2011). The
random numbers of a grain depend on its identifying number alone, not on other grains or the order.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from galvi.arrays import Array

Words = npt.NDArray[np.uint64]  # each below 2^32
PHILOX_ROUNDS = 10
PHILOX_FACTORS = 0xD2511F53, 0xCD9E8D57
KEY_STEPS = 0x9E3779B9, 0xBB67AE85  # added to the two words of the key in each round
LOW_BITS = np.uint64(0xFFFFFFFF)
WORD_BITS = np.uint64(32)


def philox(counter: Any, key: Any) -> Words:
    """The four words (4, ...) of counters (4, ...) and keys (2, ...), all below 2^32."""
    a, b, c, d = (np.asarray(x, dtype=np.uint64) for x in counter)
    k, l = (np.asarray(x, dtype=np.uint64) for x in key)
    for _ in range(PHILOX_ROUNDS):
        first, second = a * np.uint64(PHILOX_FACTORS[0]), c * np.uint64(PHILOX_FACTORS[1])
        a, b, c, d = (
            (second >> WORD_BITS) ^ b ^ k,
            second & LOW_BITS,
            (first >> WORD_BITS) ^ d ^ l,
            first & LOW_BITS,
        )
        k, l = (k + np.uint64(KEY_STEPS[0])) & LOW_BITS, (l + np.uint64(KEY_STEPS[1])) & LOW_BITS
    return np.stack(np.broadcast_arrays(a, b, c, d))


def uniforms(grains: Any, attempt: int, seed: int) -> Array:
    """Four random numbers (4, n) in (0, 1) for each grain number (n,) and an attempt."""
    grain = np.asarray(grains, dtype=np.uint64)
    zero = np.zeros_like(grain)
    draws = philox(
        (grain & LOW_BITS, grain >> WORD_BITS, zero + np.uint64(attempt), zero), (seed, 0)
    )
    return (draws.astype(np.float64) + 0.5) / 2.0**32
