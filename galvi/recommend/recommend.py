"""Recommends a degree and a step for a required accuracy, from a short scan of the problem."""

from __future__ import annotations

import math
import statistics
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from galvi import input_checks
from galvi.clocks.clock import AnyClock
from galvi.input_checks import shown
from galvi.problem import Problem
from galvi.recommend import scan as scans
from galvi.recommend.extrapolation import extrapolation_objection
from galvi.recommend.recommendation import Candidate, Recommendation

DEGREES = (8, 12, 6, 16, 4)
DEFAULT_BUDGETS = {
    scans.TIME: 10.0,
    scans.EVALUATIONS: 2e7,
}  # default budgets: seconds, evaluations
ERROR_SHARE = 0.7  # share of the required error that a candidate may have
RUNS_PER_DEGREE = 8  # expected number of runs of one degree
SEARCH_SHARE = 0.6  # share of the budget for the search
ROUGH_SEARCH_SHARE = 1 / 16  # share of the measured part that a first, rough search integrates
TIMED_ROUNDS = 5  # rounds of interleaved runs
MAX_CONFIRMATIONS = 4  # largest number of candidates that are compared a second time
MAX_DEGREE = 60  # largest accepted degree
# Ratio of the equal steps that the closest passage needs to those of a clock, from which a clock is
# advised.
CLOCK_ADVICE_RATIO = 5.0


def recommend(
    problem: Problem,
    error: float,
    duration: float,
    *,
    degrees: Sequence[int] = DEGREES,
    clock: AnyClock | None = None,
    by: str = scans.TIME,
    budget: float | None = None,
    measured: float | None = None,
) -> Recommendation:
    """The degree s of Galerkin(Polynomials(s), gauss(s)) and the step that reach an error cheapest.

    Parameters
    ----------
    error
        largest position error of a body at any time of the run, in the problem's unit of length
    duration
        length of the run, in the problem's unit of time
    degrees
        degrees to try, in this order, from 1 to 60
    clock
        clock of the steps, on vector spaces; ``step`` is then in its units, ``steps`` is the
        approximate number of steps, and ``duration`` is the argument to give to `galvi.integrate`.
        A first run of at most 4,096 steps, which measures the duration in the clock, is not charged
        to the budget
    by
        "time", from interleaved runs on this machine, or "evaluations" of the force, which gives
        the same answer every time on one machine
    budget
        seconds, or evaluations, that the scan may take; default 10 s or 2e7
    measured
        length of the part of the run over which errors are measured; by default the whole run, or
        as much as the budget allows; the choice is then checked over the whole run if the budget
        permits

    Raises
    ------
    ValueError, TypeError
        For bad input; exceptions of user functions pass through.
    KeyboardInterrupt
        For Ctrl-C.

    Notes
    -----
    For each degree, the largest step within the error is searched; each run is compared with a more
    accurate one (see ``galvi.recommend.scan``), the cheapest with two. An extrapolated error is
    assumed to grow as t^1.5, or as fast as measured, and is accepted only after one run over the
    whole duration (see ``galvi.recommend.recommendation``). Failed candidates are kept in
    ``scanned`` with the reason. If no candidate reaches the error, the result is the most accurate
    one found, and ``reached`` and ``status`` say so. On groups, methods have the exponential chart.

    Examples
    --------
    >>> choice = galvi.recommend(galvi.problems.kepler(0.3), error=1e-6, duration=30.0,
    ...                          by="evaluations")
    >>> choice.reached, choice.error <= 1e-6, choice.method.stages in (4, 6, 8, 12, 16)
    (True, True, True)
    """
    if not isinstance(problem, Problem):
        raise TypeError(f"problem must be a galvi.Problem; received {shown(problem)}.")
    required_error = input_checks.positive(
        "error", error, "Give it in the problem's unit of length."
    )
    length = input_checks.positive(
        "duration",
        duration,
        "Give the length of the run; of one backwards, without friction, with velocities reversed.",
    )
    if not isinstance(by, str) or by not in DEFAULT_BUDGETS:
        raise ValueError(f"by must be one of {', '.join(DEFAULT_BUDGETS)}; received {shown(by)}.")
    degree_list = _checked_degrees(degrees)
    total_budget = (
        DEFAULT_BUDGETS[by] if budget is None else input_checks.positive("budget", budget)
    )
    measured_length = (
        length if measured is None else min(length, input_checks.positive("measured", measured))
    )
    if clock is not None and problem.q0.shape != problem.v0.shape:
        raise ValueError("recommend scans clocks on vector spaces; this problem is on a group.")
    scan_length = length if clock is None else scans.length_in(clock, problem, length)
    unit = scan_length / length
    scan = scans.Scan(
        problem, scan_length, unit * measured_length, by, total_budget, clock=clock, unit=unit
    )
    steps = scan.first_guess(degree_list[0], required_error)
    if measured is None:
        steps = _fit_to_budget(
            scan, degree_list[0], steps, required_error, RUNS_PER_DEGREE * len(degree_list)
        )
    reasons = _search_degrees(scan, degree_list, steps, required_error)
    if not scan.candidates:
        unaffordable = Candidate(
            degree_list[0],
            steps,
            scan_length / steps,
            math.inf,
            0.0,
            math.nan,
            math.nan,
            math.nan,
            f"One run over a time of {scan.measured / unit:.3g} takes more than the budget, "
            f"{total_budget:g}.",
        )
        return _answer(scan, unaffordable, required_error, {scans.Ended.BUDGET: []})
    sufficient = [
        candidate
        for candidate in scan.candidates
        if candidate.error <= ERROR_SHARE * required_error
    ]
    if not sufficient:
        return _answer(scan, _most_accurate(scan), required_error, reasons)
    answer = _confirm(scan, _cheapest(scan, sufficient), required_error, measured is None)
    if scans.Ended.BUDGET in reasons and answer.reached:
        degrees_left = _degree_names(reasons[scans.Ended.BUDGET])
        text = f"{answer.status} The budget ended before the search for {degrees_left}."
        answer = replace(answer, status=text)
    return answer


def _checked_degrees(degrees: Sequence[int]) -> list[int]:
    """The degrees; ValueError unless they are several whole numbers from 1 to HIGHEST_DEGREE."""
    if not isinstance(degrees, (tuple, list, range)) or not degrees:
        raise ValueError(
            f"degrees must be a tuple or list of whole numbers, as (6, 8); "
            f"received {shown(degrees)}."
        )
    return [input_checks.whole("each of degrees", s, 1, MAX_DEGREE) for s in degrees]


def _search_degrees(
    scan: scans.Scan, degrees: list[int], steps: int, required_error: float
) -> dict[scans.Ended, list[int]]:
    """Search the largest step of each degree; returns reason -> degrees whose search found none.

    Parameters
    ----------
    steps
        number of steps with which the search for the first degree begins
    """
    total_budget, scan.budget = scan.budget, SEARCH_SHARE * scan.budget
    reasons: dict[scans.Ended, list[int]] = {}
    for k, s in enumerate(degrees):
        start = steps if k == 0 else max(scan.fewest, math.ceil(steps * degrees[k - 1] / s))
        steps, reason = scans.fewest_steps(scan, s, start, ERROR_SHARE * required_error)
        if reason is not None:
            reasons.setdefault(reason, []).append(s)
        if reason is scans.Ended.PARTED:  # of any degree
            break
    scan.budget = total_budget
    return reasons


def _cheapest(scan: scans.Scan, good: list[Candidate]) -> Candidate:
    """The cheapest candidate; if time decides, the cheapest of each degree are timed again
    first."""

    def cost(candidate: Candidate) -> float:
        return candidate.cost(scan.by)

    cheapest_of_degrees = [
        min((candidate for candidate in good if candidate.degree == s), key=cost)
        for s in dict.fromkeys(candidate.degree for candidate in good)
    ]
    return min(
        _time_candidates(scan, cheapest_of_degrees)
        if scan.by == scans.TIME
        else cheapest_of_degrees,
        key=cost,
    )


def _fit_to_budget(
    scan: scans.Scan, degree: int, steps: int, required_error: float, runs: int
) -> int:
    """Set the scan's measured length to what the budget allows; returns the number of steps of a
    rough search."""
    budget, scan.budget = scan.budget, SEARCH_SHARE * scan.budget
    scan.measured = ROUGH_SEARCH_SHARE * scan.reach(degree, steps, runs)
    steps, _ = scans.fewest_steps(scan, degree, steps, required_error)
    scan.measured = scan.reach(degree, steps, runs)
    scan.budget = budget
    scan.candidates.clear()
    return steps


def _time_candidates(scan: scans.Scan, candidates: list[Candidate]) -> list[Candidate]:
    """The candidates with times from interleaved runs, which use about a tenth of the budget."""
    share = min(
        1.0, 0.1 * scan.budget / TIMED_ROUNDS / sum(candidate.seconds for candidate in candidates)
    )
    samples: list[list[float]] = [[] for _ in candidates]
    for _ in range(TIMED_ROUNDS):
        for candidate, seconds in zip(candidates, samples, strict=True):
            part = max(1, math.ceil(share * candidate.steps))
            seconds.append(
                scan.run(candidate.degree, candidate.steps, part)[1] * candidate.steps / part
            )
    return [
        replace(candidate, seconds=statistics.median(seconds))
        for candidate, seconds in zip(candidates, samples, strict=True)
    ]


def _confirm(
    scan: scans.Scan, choice: Candidate, required_error: float, extend: bool
) -> Recommendation:
    """The recommendation of a choice that is compared a second time, over the whole duration where
    the budget allows that, and with more steps where its error is too large."""
    part, rate = scan.measured, choice.seconds / choice.steps
    if extend and part < scan.duration:
        scan.measured = scan.duration
        if not scan.affords(choice.degree, choice.steps, scans.WITH_CHECK):
            scan.measured = part
    confirmed = []
    for attempt in range(MAX_CONFIRMATIONS):
        if attempt or scan.measured > part:
            choice = scan.measure(choice.degree, choice.steps)
        error = max(choice.error, scan.half_step_error(choice))
        confirmed.append(replace(choice, error=error, seconds=rate * choice.steps))
        step_ratio = (error / (ERROR_SHARE * required_error)) ** (0.5 / choice.degree)
        choice = replace(choice, steps=math.ceil(choice.steps * min(max(step_ratio, 1.05), 2.0)))
        if error <= required_error or not scan.affords(
            choice.degree, choice.steps, scans.WITH_CHECK
        ):
            break
    best = min(confirmed, key=lambda candidate: candidate.error)
    if best.error > required_error:
        best = min(
            best,
            _most_accurate(scan, {(candidate.degree, candidate.steps) for candidate in confirmed}),
            key=lambda candidate: candidate.error,
        )
    return _answer(scan, best, required_error, {scans.Ended.UNCONFIRMED: []})


def _most_accurate(scan: scans.Scan, compared: Collection[tuple[int, int]] = ()) -> Candidate:
    """The most accurate of the first candidates, at most MAX_CONFIRMATIONS, whose degree and steps
    are not in ``compared``, after a second comparison of each over the measured length."""
    ranked = sorted(scan.candidates, key=lambda candidate: (candidate.error, -candidate.steps))
    best = ranked[0]
    checked: list[Candidate] = []
    for candidate in ranked:
        is_too_costly = checked and not scan.affords(
            candidate.degree, candidate.steps, scans.WITH_CHECK
        )
        if is_too_costly or not math.isfinite(candidate.error) or len(checked) == MAX_CONFIRMATIONS:
            break
        if (candidate.degree, candidate.steps) not in compared:
            repeated = candidate
            if candidate.measured < scan.length(candidate.degree, candidate.steps):
                repeated = scan.measure(candidate.degree, candidate.steps)
            checked.append(
                replace(repeated, error=max(repeated.error, scan.half_step_error(repeated)))
            )
    return min(
        checked, key=lambda candidate: candidate.error, default=replace(best, error=math.inf)
    )


def _degree_names(degrees: list[int]) -> str:
    return f"degree{'s' * (len(degrees) > 1)} {', '.join(map(str, degrees))}"


def _parting_sentence(scan: scans.Scan) -> str:
    """Sentences on the time up to which a run predicts a motion whose neighbouring starts part."""
    predicted_time = (
        max(candidate.parted for candidate in scan.candidates if math.isfinite(candidate.parted))
        / scan.unit
    )
    return (
        f"Neighbouring starts part: rounding alone decides where bodies are after a time of about "
        f"{predicted_time:.3g}, whichever integrator is used. Ask for a shorter duration; "
        f"galvi.judge says how far a start predicts the motion."
    )


def _answer(
    scan: scans.Scan,
    best: Candidate,
    required_error: float,
    reasons: Mapping[scans.Ended, list[int]],
) -> Recommendation:
    """The recommendation of a candidate.

    Parameters
    ----------
    whys
        reason why the error was not reached -> its degrees; [] for no degree in particular
    """
    reason_text = "; ".join(
        f"{reason.value}{f' for {_degree_names(degrees)}' if degrees else ''}"
        for reason, degrees in reasons.items()
    )
    reached, error, covers_duration = (
        best.error <= required_error,
        best.error,
        best.measured >= scan.duration,
    )
    measured, duration = best.measured / scan.unit, scan.duration / scan.unit
    objection = (
        "" if covers_duration or not math.isfinite(error) else extrapolation_objection(scan, best)
    )
    status = "" if reached else f"An error of {required_error:g} was not reached: {reason_text}. "
    if scans.Ended.PARTED in reasons and not reached:
        status = f"An error of {required_error:g} was not reached. {_parting_sentence(scan)}"
    elif not math.isfinite(error):
        last_status = best.status or "With half the step its result is entirely different."
        status = f"No run tried is usable: {reason_text}. The last one: {last_status}"
    elif objection:
        reached, error = False, math.inf
        status += (
            f"The error found, {best.error:.1e}, is unreliable. It was measured over too short a "
            f"part, the first {measured:.4g} of {duration:.4g}: {objection}. Raise budget "
            f"or measured, or ask for a shorter duration."
        )
    elif not reached:
        status += f"The smallest error found is {error:.1e}. "
        status += "Ask for a larger error or a shorter duration, or raise budget."
    elif covers_duration:
        status = "Its error was measured over the whole duration."
    else:
        status = f"Its error was measured over the first {measured:.4g} and extrapolated."
    if scan.uneven >= CLOCK_ADVICE_RATIO:
        status += (
            f" The closest passage sets all steps, about {scan.uneven:.0f} times as many as the "
            f"motion needs in the mean: try clock=galvi.DynamicalTime()."
        )
    return Recommendation(
        scans.collocation(scan.problem, best.degree, scan.clock),
        best.step,
        best.steps,
        duration,
        required_error,
        error,
        best.seconds,
        best.evaluations,
        reached,
        status,
        measured,
        tuple(scan.candidates),
    )
