"""Are the Galerkin curves as good as the step ends? The scan of T for L2 and L6.

H prints no T in chapter 3. The errors of the ends grow with T, the curve's own does not: the two
agree for as many n as T is long enough.
"""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.pendulum_motion import TRUTH
from references import Contender

ENDS, CURVE = "one-step error", "curve error"
STEP, DURATIONS, NS = 0.5, (5.0, 50.0, 500.0), range(3, 11)
SAME = 2.0  # "the same error": one line in a plot over ten decades
BOTH = "the Galerkin curves have the same error as the one-step map"
WHY = (
    "The curve's own error inside a step does not depend on T, that of the ends grows with T: with "
    "x(n) their ratio less 1 at T = 5, it is 5 x(n) / T, and n* is where that is 1. For fewer n "
    "both errors are the ends', as H suspects, for more the curve is behind. H prints no T, so "
    "that the sentence cannot be decided: true below n*(T), false above."
)


def scan_of(duration: float, what: str = "") -> str:
    """The study of one duration."""
    return f"{what}curves and ends, T = {duration:g}"


def scan(
    problem: Problem, make_method: MakeMethod, report: Report, what: str = ""
) -> list[dict[str, Any]]:
    """Series of both errors in n for each of DURATIONS, in Cayley's chart, against DOP853."""
    found = []
    for duration in DURATIONS:
        cases = [Case(n, STEP, round(duration / STEP)) for n in NS]
        options = (make_method, report, method_on_group)
        found += refine(scan_of(duration, what), problem, TRUTH, cases, (ENDS, CURVE), *options)
    return found


def between(problem: Problem, duration: float, second: Contender, **setting: Any) -> float:
    """Largest entry of the difference of the scan's truth and a second one, at 100 times."""
    samples = {"samples": 100}
    exact, other = (
        TRUTH.run(problem, duration, samples),
        second.run(problem, duration, {**samples, **setting}),
    )
    return float(np.max(np.abs(exact.q - other.q)))


def ratio(table: DataFrame, duration: float, n: int, what: str = "") -> float:
    """Curve error over one-step error; NaN where one is missing."""
    study = scan_of(duration, what)
    both = [pick(table, study=study, n=n, quantity=name)["value"] for name in (CURVE, ENDS)]
    return float(both[0].iloc[0] / both[1].iloc[0]) if all(map(len, both)) else float("nan")


def up_to(table: DataFrame, duration: float, what: str = "", by_law: bool = False) -> float:
    """n*: where the curve's own error is that of the ends, a ratio of SAME, between two n; with
    ``by_law`` from the ratios at the shortest of DURATIONS alone."""
    measured = DURATIONS[0] if by_law else duration
    own = np.array([ratio(table, measured, n, what) - 1.0 for n in NS]) * measured / duration
    above = np.flatnonzero(own >= SAME - 1.0)
    if not above.size or above[0] == 0 or not np.all(own[above[0] - 1 : above[0] + 1] > 0.0):
        return float("nan")
    k = int(above[0])
    below, beyond = np.log(own[k - 1 : k + 1])
    return float(NS[k - 1] - below / (beyond - below))


def rows_of(claim: Claim, table: DataFrame, setup: str, what: str = "", **texts: str) -> list[Row]:
    """n*(T) for all but the shortest of DURATIONS, against its law."""
    return [
        claim.row(
            f"n*, up to which the curves are as good as the ends, {what}T = {duration:g}",
            Finding(Near(up_to(table, duration, what, by_law=True), 0.5)),
            up_to(table, duration, what),
            setup=setup % f"{duration:g}, of T = {listed()} (H prints none)",
            claimed=BOTH,
            reason=WHY,
            **texts,
        )
        for duration in DURATIONS[1:]
    ]


def listed(durations: Iterable[float] = DURATIONS) -> str:
    """The durations in words."""
    return ", ".join(f"{duration:g}" for duration in durations)
