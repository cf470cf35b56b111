"""Searches the fewest steps of one degree that stay within an error."""

from __future__ import annotations

import math

from galvi.recommend.recommendation import Candidate
from galvi.recommend.scan import FINEST, Scan

TRIES = 14  # numbers of steps tried
BUDGET_ENDED = "the budget ended"
CLOSE = 1.06  # ratio of upper to lower number of steps at which the search ends
COARSER = 0.9  # ratio to the next number when all so far were within the error
DEARER = 4.0  # it also ends where fewer steps cost this much more, being hard to solve
HARD = 0.1  # share of steps by Newton's method from which on smaller steps may cost less
PERHAPS_ROUNDING = 1e-5  # largest error, over the largest coordinate, that may be round-off
LONGER = 1.05  # ratio of times of use below which smaller steps did not help
PART = "neighbouring starts part"  # see `_parting` of galvi.recommend.recommend
FLAT = 2  # consecutive refinements without gain after which the error counts as round-off


def fewest_steps(scan: Scan, degree: int, steps: int, error: float) -> tuple[int, str]:
    """The fewest steps within the error, searched from ``steps``, or the last number tried.

    Also why the search ended without reaching the error, else an empty string. Each next number is
    the one for which an error of order 2 s would be as required, kept between those known to be too
    few and enough. Where only Newton's method solves the steps, twice as many are tried until they
    need it no more, or cost far more.
    """
    enough, why = _within(scan, degree, steps, error)
    last = next((one for one in reversed(scan.tried) if one.steps == enough), None)
    least = last.cost(scan.by) if last is not None else 0.0
    while last is not None and last.degree == degree and last.newton > HARD:
        finer = 2 * last.steps
        if finer > scan.most or not scan.affords(degree, finer):
            break
        last = scan.measure(degree, finer)
        if last.cost(scan.by) > DEARER * least:
            break
        least = min(least, last.cost(scan.by))
    return enough, why


def _within(scan: Scan, degree: int, steps: int, error: float) -> tuple[int, str]:
    low, high, flat, least = 0, 0, 0, math.inf
    before: Candidate | None = None
    for _ in range(TRIES):
        if not scan.affords(degree, steps):
            return high or steps, "" if high else BUDGET_ENDED
        found = scan.measure(degree, steps)
        if found.error <= error:
            high, cost = steps, found.cost(scan.by)
            best = min(one.cost(scan.by) for one in scan.tried if one.error <= error)
            if cost > DEARER * (best if found.newton > HARD else least):
                break
            least = min(least, cost)
        else:
            flat = flat + 1 if before is not None and _no_better(before, found) else 0
            low, before = steps, found
            if flat == FLAT and found.error < PERHAPS_ROUNDING * scan.size:
                return high or steps, "" if high else "rounding decides"
            if flat and math.isfinite(found.parted) and not high:
                return steps, PART
        if high and (high <= CLOSE * low or high - low <= 1):
            break
        if not high and low >= scan.most:
            break
        steps = min(_next(found, low, high, error), scan.most)
    return high or steps, "" if high else "no number of steps that was tried is enough"


def _next(found: Candidate, low: int, high: int, error: float) -> int:
    """The next number of steps; ``low`` are known to be too few and ``high`` enough."""
    if found.error == math.inf:
        wanted = 2.0
    else:
        wanted = (found.error / error) ** (0.5 / found.degree)
    steps = math.ceil(min(found.steps * wanted, float(FINEST)))
    if low and high:
        return steps if low < steps < high else round(math.sqrt(low * high))
    if high:
        return min(max(steps, high // 2, 1), max(1, math.floor(COARSER * high)))
    return min(max(steps, low + max(1, low // 25)), 4 * low)


def _no_better(before: Candidate, after: Candidate) -> bool:
    """Whether the error fell by less than half the decades that the order predicts.

    Where neither is of use, whether they are so from the same time on.
    """
    if after.steps <= before.steps:
        return False
    if math.isfinite(before.parted) and math.isfinite(after.parted):
        return after.parted <= LONGER * before.parted
    if not (math.isfinite(before.error) and after.error > 0.0):
        return False
    if not math.isfinite(after.error):
        return True
    promised = 2.0 * after.degree * math.log(after.steps / before.steps)
    return math.log(before.error / after.error) < 0.5 * promised
