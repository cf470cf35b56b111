"""Errors and costs of runs of a degree at several steps, without an exact solution, and the longest
step within an error.

Each run is compared with one whose degree is higher by four, at the same step and times, which is
far more accurate whenever either is usable, and has similar round-off. The reliability of the
comparison and of its extrapolation was measured by benchmarks/studies/recommendation.py of commit
03c0fc22; tests/properties/test_recommend.py holds choices to it.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from galvi.arrays import Array
from galvi.charts.chart import Cayley, Exponential
from galvi.clocks.clock import AnyClock, DynamicalTime
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.recommend.recommendation import Candidate
from galvi.rules.rule import gauss
from galvi.run.engines import has_fixed_point_solver
from galvi.run.group_system import group_system
from galvi.run.integrate import integrate
from galvi.run.interruption import uninterrupted
from galvi.spaces.polynomials import Polynomials
from galvi.systems.nbody import NBody
from galvi.systems.system import WithLimits
from galvi.trajectory import Trajectory

MAX_TRIES = 14  # largest number of tried numbers of steps
BRACKET_RATIO = 1.06  # ratio of upper to lower number of steps at which the search ends
COARSER_RATIO = 0.9  # ratio to the next number when all so far were within the error
# The search also ends where fewer steps cost more than this many times as much, since their
# equations are hard to solve.
LARGEST_COST_RATIO = 4.0
NEWTON_SHARE = 0.1  # of steps by Newton's method, above which smaller steps may cost less
PERHAPS_ROUNDING = 1e-5  # largest error, over the largest coordinate, that may be round-off
PARTING_GAIN = 1.05  # ratio of times of use below which smaller steps did not help
# Consecutive refinements without gain after which the error counts as round-off.
REFINEMENTS_WITHOUT_GAIN = 2


class Ended(Enum):
    """Reasons why no number of steps reached the error, as clauses of the status."""

    BUDGET = "the budget ended"
    PARTED = "neighbouring starts part"  # see `_parting` of galvi.recommend.recommend
    ROUNDING = "rounding decides"
    STOPPED = "a force reaches its limit at the same time whatever the step"
    TRIED = "no number of steps that was tried is enough"
    UNCONFIRMED = "the candidate that seemed to reach it did not when compared again"


def fewest_steps(scan: Scan, degree: int, steps: int, error: float) -> tuple[int, Ended | None]:
    """The smallest number of steps found within the error, searched from ``steps``, and None; where
    no number reached it, the last one tried and the reason.

    The next number is that for which an error of order 2 s would be as required, kept between
    numbers that are too small and sufficient ones. Where more than NEWTON_SHARE of the steps need
    Newton's method, twice as many are tried until they do not, or cost far more.
    """
    sufficient_steps, reason = _search_steps(scan, degree, steps, error)
    last = next(
        (
            candidate
            for candidate in reversed(scan.candidates)
            if candidate.steps == sufficient_steps
        ),
        None,
    )
    cheapest = last.cost(scan.by) if last is not None else 0.0
    while last is not None and last.degree == degree and last.newton > NEWTON_SHARE:
        finer = 2 * last.steps
        if finer > scan.most_steps or not scan.affords(degree, finer):
            break
        last = scan.measure(degree, finer)
        if last.cost(scan.by) > LARGEST_COST_RATIO * cheapest:
            break
        cheapest = min(cheapest, last.cost(scan.by))
    return sufficient_steps, reason


def _search_steps(scan: Scan, degree: int, steps: int, error: float) -> tuple[int, Ended | None]:
    low, high, without_gain, cheapest = 0, 0, 0, math.inf
    candidate_before: Candidate | None = None
    for _ in range(MAX_TRIES):
        if not scan.affords(degree, steps):
            return high or steps, None if high else Ended.BUDGET
        candidate = scan.measure(degree, steps)
        if candidate.error <= error:
            high, cost = steps, candidate.cost(scan.by)
            best = min(
                earlier.cost(scan.by) for earlier in scan.candidates if earlier.error <= error
            )
            if cost > LARGEST_COST_RATIO * (best if candidate.newton > NEWTON_SHARE else cheapest):
                break
            cheapest = min(cheapest, cost)
        else:
            without_gain = (
                without_gain + 1
                if candidate_before is not None and _is_no_better(candidate_before, candidate)
                else 0
            )
            low, candidate_before = steps, candidate
            why = _reason_to_stop(scan, candidate, without_gain)
            if why and not high:
                return steps, why
            if why is Ended.ROUNDING:
                break
        if _is_bracketed(scan, low, high):
            break
        steps = max(scan.fewest, min(_next_steps(candidate, low, high, error), scan.most_steps))
    return high or steps, None if high else Ended.TRIED


def _reason_to_stop(scan: Scan, candidate: Candidate, without_gain: int) -> Ended | None:
    """The reason why more steps do not help after ``without_gain`` refinements without gain; None
    where they may help."""
    if without_gain == REFINEMENTS_WITHOUT_GAIN and candidate.error < PERHAPS_ROUNDING * scan.size:
        return Ended.ROUNDING
    if without_gain and math.isfinite(candidate.parted):
        return Ended.PARTED
    return Ended.STOPPED if without_gain and math.isfinite(candidate.stopped) else None


def _is_bracketed(scan: Scan, low: int, high: int) -> bool:
    """Whether no number of steps is left to try between ``low``, too few, and ``high``, sufficient;
    0 stands for an unknown number."""
    if not high:
        return low >= scan.most_steps
    return high <= BRACKET_RATIO * low or high - low <= 1 or high == scan.fewest


def _next_steps(candidate: Candidate, low: int, high: int, error: float) -> int:
    """The next number of steps, between ``low``, too few, and ``high``, sufficient; 0 stands for an
    unknown number."""
    if candidate.error == math.inf:
        step_ratio = 2.0
    else:
        step_ratio = (candidate.error / error) ** (0.5 / candidate.degree)
    steps = math.ceil(min(candidate.steps * step_ratio, float(MAX_STEPS)))
    if low and high:
        return steps if low < steps < high else round(math.sqrt(low * high))
    if high:
        return min(max(steps, high // 2, 1), max(1, math.floor(COARSER_RATIO * high)))
    return min(max(steps, low + max(1, low // 25)), 4 * low)


def _is_no_better(before: Candidate, after: Candidate) -> bool:
    """Whether the error fell by less than half the decades that the order predicts.

    Where both runs stopped, or parted from their comparisons, whether that was not later after more
    steps.
    """
    if after.steps <= before.steps:
        return False
    if math.isfinite(before.stopped) and math.isfinite(after.stopped):
        return before.stopped / PARTING_GAIN <= after.stopped <= PARTING_GAIN * before.stopped
    if math.isfinite(before.parted) and math.isfinite(after.parted):
        return after.parted <= PARTING_GAIN * before.parted
    if not (math.isfinite(before.error) and after.error > 0.0):
        return False
    if not math.isfinite(after.error):
        return True
    expected_decrease = 2.0 * after.degree * math.log(after.steps / before.steps)
    return math.log(before.error / after.error) < 0.5 * expected_decrease


CLOCK_STEP = 0.25  # largest step, in the clock, of a first run that measures a duration
MAX_CLOCK_STEPS = 4096  # its largest number of steps
LEAST_CLOCK_STEPS = 16  # its least number of steps, in the rate at the start
LEAST_RATE = 1e-300  # replaces a g of 0, which `integrate` then refuses
LENGTH_MARGIN = 1.001  # scans in a clock are longer by this factor, so as not to end too early
STEP_HALVINGS = 12  # largest number of halvings of CLOCK_STEP where a run fails
CHECK_DEGREES = 4  # additional degrees of the run used for comparison
COMPARED_TIMES = 64  # times at which two runs are compared
POWERS = (1.5, 3.0)  # range of the power of time with which an unmeasured error may grow
WITH_CHECK = 2.5  # cost of a run and its comparison over that of the run
STEP_DOUBLINGS = 60  # largest number of doublings of a number of steps
LEAST_STAGES = 512  # least stages in the measured part: some 4 to 10 periods
MAX_STEPS = 2**50  # largest number of steps in a duration
# Largest ratio of the duration to the measured part: its powers must not overflow.
LARGEST_DURATION_RATIO = 1e100
UNUSABLE_SHARE = 0.1  # error over the size of the motion above which a run is unusable
ROUND_OFF_SHARE = 1e-8  # relative position error below which an error may be round-off
TIME, EVALUATIONS = "time", "evaluations"


def collocation(problem: Problem, degree: int, clock: AnyClock | None = None) -> Galerkin:
    """The cheapest method of order 2 s; on a group with the exponential chart."""
    space, rule = Polynomials(degree), gauss(degree)
    on_group = group_system(problem) is not None
    return Galerkin(space, rule, Exponential() if on_group else Cayley(), clock)


def length_in(clock: AnyClock, problem: Problem, duration: float) -> float:
    """A duration in units of a clock, times LENGTH_MARGIN: that of a run in small steps, or
    extrapolated from its first ``MAX_CLOCK_STEPS`` steps. ValueError where no run is possible."""
    method = collocation(problem, 8, clock)
    rate = max(abs(float(clock.rate(problem)(problem.q0.ravel()))), LEAST_RATE)
    step = min(CLOCK_STEP, duration / (LEAST_CLOCK_STEPS * rate))
    for _ in range(STEP_HALVINGS):
        run = uninterrupted(
            integrate(problem, method, step, MAX_CLOCK_STEPS, duration=duration, curves=False)
        )
        if run.tau is not None and (run.success or run.counts["steps"] == MAX_CLOCK_STEPS):
            return LENGTH_MARGIN * float(run.tau[-1]) * duration / abs(float(run.t[-1] - run.t[0]))
        step *= 0.5
    raise ValueError(f"no run in this clock was possible: {run.status}")


def distances(first: Array, second: Array) -> Array:
    """The largest distances (saved,) of a body, a vector or a row of a matrix between two arrays of
    configurations (saved, ..., d)."""
    gaps = np.linalg.norm(first - second, axis=-1).reshape(len(first), -1)
    return np.max(gaps, axis=1)


def elapsed(run: Trajectory) -> Array:
    """Times (saved,) since the start; with a clock, in its units."""
    return np.abs(run.t - run.t[0]) if run.tau is None else run.tau


def positions_at_times_of(run: Trajectory, better: Trajectory) -> Array:
    """Positions of a better run at the times of a run, from which its own differ slightly in a
    clock."""
    if run.tau is None:
        return better.q
    time_differences = (run.t - better.t).reshape(-1, *(1,) * (better.q.ndim - 1))
    return better.q + time_differences * better.v


@dataclass
class Scan:
    """Runs of one problem over the first part of a duration, within a budget.

    Attributes
    ----------
    problem
        the problem integrated
    duration
        length for which errors and costs are stated; with a clock, all lengths of a scan are in its
        units
    measured
        length of the integrated part, at most the duration; longer if it would have fewer than
        LEAST_STAGES stages
    by
        "time" or "evaluations": the unit of cost, budget and spent
    budget
        total cost of runs allowed
    spent
        cost of the runs, in the unit of ``by``
    candidates
        tried candidates, in order
    size
        largest coordinate of all runs
    clock
        of the steps; None for equal ones
    unit
        mean length in the clock of a unit of time
    uneven
        for point masses in equal steps, the largest rate of `DynamicalTime` over its mean: how many
        times too short the steps are for the rest of the motion
    """

    problem: Problem
    duration: float
    measured: float
    by: str
    budget: float
    spent: float = 0.0
    candidates: list[Candidate] = field(default_factory=list)
    size: float = 0.0
    clock: AnyClock | None = None
    unit: float = 1.0
    uneven: float = 1.0
    _per_step: dict[int, float] = field(
        default_factory=dict
    )  # cost per step of each degree, with its comparison

    @property
    def most_steps(self) -> int:
        """Largest number of steps in the duration such that each still changes the time."""
        time_spacing = math.ulp(abs(self.problem.t0) + self.duration)
        return int(min(MAX_STEPS, max(1.0, 0.25 * self.duration / time_spacing)))

    @property
    def fewest(self) -> int:
        """Least number of steps in the duration that the clock allows."""
        return math.ceil(self.duration / getattr(self.clock, "longest", math.inf)) or 1

    def affords(self, degree: int, steps: int, runs: float = 1.0) -> bool:
        """Whether ``runs`` runs with their comparisons are expected to fit into the budget."""
        costs = self._per_step
        if not costs:
            return self.spent < self.budget
        nearest = min(costs, key=lambda s: abs(s - degree))
        cost = costs[nearest] * (degree / nearest) * self.part(degree, steps)
        return self.spent + runs * cost <= self.budget

    def part(self, degree: int, steps: int) -> int:
        """The number of steps in the measured part."""
        share = min(1.0, self.measured / self.duration)
        return min(steps, max(math.ceil(LEAST_STAGES / degree), math.ceil(share * steps)))

    def length(self, degree: int, steps: int) -> float:
        """Length of the measured part when the duration has ``steps`` steps."""
        return self.duration * (self.part(degree, steps) / steps)

    def run(
        self,
        degree: int,
        steps: int,
        part: int,
        finer: int = 1,
        solver: str = "auto",
        samples: int = COMPARED_TIMES,
    ) -> tuple[Trajectory, float, float]:
        """The run of the first ``part`` steps, each divided into ``finer``, its seconds and its
        evaluations of the force; KeyboardInterrupt for Ctrl-C."""
        began = time.perf_counter()
        run = uninterrupted(
            integrate(
                self.problem,
                collocation(self.problem, degree, self.clock),
                self.duration / (steps * finer),
                part * finer,
                save_every=max(1, part // samples) * finer,
                curves=False,
                solver=solver,
            )
        )
        seconds = time.perf_counter() - began
        counts, size = run.counts, self.problem.v0.size
        evaluations = float(counts["force_evaluations"] + size * counts["hessian_evaluations"])
        self.spent += seconds if self.by == TIME else evaluations
        return run, seconds, evaluations

    def first_guess(self, degree: int, error: float) -> int:
        """A number of steps for which the first step has at most its share of the error.

        These runs are not charged to the budget, since they include compilation and loading.
        """
        size, spent, steps = float(np.max(np.abs(self.problem.q0))), self.spent, self.fewest
        method = collocation(self.problem, degree)
        can_iterate = self.clock is None and has_fixed_point_solver(self.problem, method)
        solver = "fixed_point" if can_iterate else "auto"
        for _ in range(STEP_DOUBLINGS):
            run, check = (
                self.run(s, steps, 1, solver=solver)[0] for s in (degree, degree + CHECK_DEGREES)
            )
            if run.success and check.success:
                difference = float(np.max(distances(run.q, positions_at_times_of(run, check))))
                if difference * steps <= error or difference <= 1e-14 * size:
                    break
            if 2 * steps > self.most_steps:
                break
            steps *= 2
        if self.clock is None or not getattr(self.problem.system, "has_massless", False):
            self.run(degree, steps, 1, solver="newton")  # which a clock does not do without mass
        self.spent = spent
        return steps

    def reach(self, degree: int, steps: int, runs: int) -> float:
        """Length over which ``runs`` such runs and their comparisons fit into the budget."""
        part = math.ceil(LEAST_STAGES / degree)
        for _ in range(STEP_DOUBLINGS):
            before = self.spent
            run, _, _ = self.run(degree, steps, min(part, steps))
            cost = (self.spent - before) / min(part, steps)
            if part >= steps or not run.success or cost * part >= 5e-3 * self.budget:
                break
            part *= 4
        self._per_step[degree], self.spent = WITH_CHECK * cost, 0.0
        share = self.budget / (runs * WITH_CHECK * cost * steps) if cost else 1.0
        return self.duration * min(1.0, share)

    def measure(self, degree: int, steps: int) -> Candidate:
        """The candidate of a degree and a number of steps in the duration, which is added to
        ``candidates``."""
        part, before = self.part(degree, steps), self.spent
        run, seconds, evaluations = self.run(degree, steps, part)
        error, growth, status, parted = math.inf, math.nan, failure(run), math.inf
        stopped = math.inf
        if run.counts["steps"] < part and reached_limit(run):
            stopped = run.counts["steps"] * abs(run.step or 0.0)
        if not status:
            check, _, _ = self.run(degree + CHECK_DEGREES, steps, part)
            error, growth, status, parted = self._error(run, check)
        self._per_step[degree] = (self.spent - before) / part
        scale, length = steps / part, self.length(degree, steps)
        if self.clock is not None and part == steps:  # if the pace changed, shorter than it should
            length *= min(1.0, abs(float(run.t[-1] - run.t[0])) * self.unit / self.duration)
        candidate = Candidate(
            degree,
            steps,
            self.duration / steps,
            error,
            length,
            growth,
            scale * seconds,
            scale * evaluations,
            status,
            run.counts.get("newton_steps", 0) / part,
            parted,
            stopped,
        )
        self.candidates.append(candidate)
        return candidate

    def half_step_error(self, candidate: Candidate) -> float:
        """The error against the same degree at half the step, which has different round-off."""
        part = self.part(candidate.degree, candidate.steps)
        run, _, _ = self.run(candidate.degree, candidate.steps, part)
        half, _, _ = self.run(candidate.degree, candidate.steps, part, finer=2)
        return math.inf if failure(run) or failure(half) else self._error(run, half)[0]

    def _error(self, run: Trajectory, better: Trajectory) -> tuple[float, float, str, float]:
        """The error over the duration, the power of time with which it grew, the reason why it is
        unusable or "", and the time from which it is, or infinity."""
        if status := failure(better):
            return math.inf, math.nan, f"The run to compare with failed. {status}", math.inf
        gaps = np.maximum.accumulate(distances(run.q, positions_at_times_of(run, better)))
        extent = float(np.max(distances(better.q, np.broadcast_to(better.q[:1], better.q.shape))))
        self.size = max(self.size, float(np.max(np.abs(better.q))))
        last, quarter = len(gaps) - 1, max(1, (len(gaps) - 1) // 4)
        error, early = float(gaps[last]), float(gaps[quarter])
        t = elapsed(run)
        growth = math.nan
        if 0.0 < early <= error and last > quarter:
            growth = math.log(error / early) / math.log(t[last] / t[quarter])
        unusable_error = max(UNUSABLE_SHARE * extent, ROUND_OFF_SHARE * self.size)
        if error > unusable_error:
            sentence = f"It is off by {error:.1e}, where bodies move by {extent:.1e}."
            return math.inf, growth, sentence, float(t[np.argmax(gaps > unusable_error)])
        self._watch(better)
        if run.counts["steps"] * abs(run.step or 0.0) < (1.0 - 1e-9) * self.duration:
            power = min(max(growth, POWERS[0]), POWERS[1]) if growth == growth else POWERS[0]
            error *= min(LARGEST_DURATION_RATIO, self.duration / float(t[last])) ** power
        return error, growth, "", math.inf

    def _watch(self, run: Trajectory) -> None:
        """Update ``uneven`` by a run of point masses."""
        system = run.problem.system
        if self.clock is None and isinstance(system, NBody) and system.masses.size > 1:
            flat = run.q.reshape(len(run.t), -1).T
            with np.errstate(all="ignore"):
                rates = 1.0 / DynamicalTime().rate(run.problem)(flat)
                self.uneven = max(self.uneven, float(np.max(rates) / np.mean(rates)))


def reached_limit(run: Trajectory) -> bool:
    """Whether a force is beyond its limit at the end of a run, which no step size changes."""
    system, end = run.problem.system, run.checkpoint
    if not isinstance(system, WithLimits) or end is None:
        return False
    q = end.state[0, : run.problem.q0.size].reshape(run.problem.q0.shape)
    return bool(system.beyond_limits(q, end.stages[:, -1], run.step or 0.0))


def failure(run: Trajectory) -> str:
    """The status of a run that is no success or in doubt; else ""."""
    return run.status if run.outcome.in_doubt or not run.success else ""
