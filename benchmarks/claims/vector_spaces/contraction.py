"""The passes of a fixed-point iteration: their ratios, and where their stages are."""

from __future__ import annotations

from benchmarks.claims.kit import *

REACH, SPREAD = "reach of the iterates over rho", "|q| of the iterates over rho"
SAME = "galvi's step less the fixed point"
PASSES = 400
DONE = 1e-9  # of the first pass: below it differences are rounded
LOST = 1e9


@dataclass(frozen=True, eq=False)
class Passes:
    """A sequence w -> pass(w) down to round-off.

    limit   the last iterate
    first   size of the first difference
    ratio   the largest ratio of successive differences
    spread  the largest |value| at the stages, over all iterates
    """

    limit: Array
    first: float
    ratio: float
    spread: float


def passes(
    once: Callable[[Array], Array],
    start: Array,
    size: Callable[[Array], float],
    stages: Callable[[Array], Array],
) -> Passes:
    """From `start`; NaN for ratio and limit where passes do not converge.

    size    norm of a difference
    stages  w -> values at the quadrature points
    """
    w, after = start, once(start)
    differences, spread = [size(after - w)], float(np.max(abs(stages(w))))
    for _ in range(PASSES):
        w, after = after, once(after)
        spread = max(spread, float(np.max(abs(stages(w)))))
        differences.append(size(after - w))
        if not 1e-16 * max(1.0, size(w)) < differences[-1] < LOST * differences[0]:
            break
    found = np.array(differences)
    settled = bool(found[-1] <= DONE * found[0])
    before, later = found[:-1], found[1:]
    large = before > DONE * found[0]
    ratio = float(np.max(later[large] / before[large])) if settled else float("nan")
    return Passes(after if settled else np.full_like(after, np.nan), found[0], ratio, spread)
