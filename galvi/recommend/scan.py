"""Measures the error and the cost of a degree and a step without an exact solution.

Each run is compared with one whose degree is higher by four, at the same step and times, which is
far more accurate whenever either is usable, and has similar round-off. The reliability of the
comparison and of its extrapolation is measured in benchmarks/studies/recommendation.py.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

import numpy as np

from galvi.arrays import Array
from galvi.charts.exponential import Exponential
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.recommend.recommendation import Candidate
from galvi.rules.gauss import gauss
from galvi.run.engine_choice import engine_for
from galvi.run.group_system import group_system
from galvi.run.integrate import integrate
from galvi.run.interruption import uninterrupted
from galvi.spaces.polynomials import Polynomials
from galvi.trajectory import COMPLETED, Trajectory

MORE = 4  # additional degrees of the run used for comparison
SAMPLES = 64  # times at which two runs are compared
POWERS = (1.5, 3.0)  # range of the power of time with which an unmeasured error may grow
WITH_CHECK = 2.5  # cost of a run and its comparison over that of the run
DOUBLINGS = 60
LEAST = 512  # least stages in the measured part: some 4 to 10 periods
FINEST = 2**50  # largest number of steps in a duration
FAR = 1e100  # largest ratio of the duration to the measured part: its powers must not overflow
USELESS = 0.1  # error over the size of the motion above which a run is unusable
ROUNDED = 1e-8  # relative position error below which an error may be round-off
TIME, EVALUATIONS = "time", "evaluations"


def collocation(problem: Problem, degree: int) -> Galerkin:
    """The cheapest method of order 2 s; on a group with the exponential chart."""
    space, rule = Polynomials(degree), gauss(degree)
    on_group = group_system(problem) is not None
    return Galerkin(space, rule, Exponential()) if on_group else Galerkin(space, rule)


def distances(one: Array, other: Array) -> Array:
    """Largest distance of a body, a vector or a row of a matrix, (saved,), for (saved, ..., d)."""
    apart = np.linalg.norm(one - other, axis=-1).reshape(len(one), -1)
    largest: Array = np.max(apart, axis=1)
    return largest


@dataclass
class Scan:
    """Runs of one problem over the first part of a duration, within a budget.

    problem   the problem integrated
    duration  length for which errors and costs are stated
    measured  length of the integrated part, at most the duration; longer if it would have fewer
              than LEAST stages
    by        "time" or "evaluations": the unit of cost, budget and spent
    budget    total cost of runs allowed
    spent     cost so far
    tried     candidates tried so far
    size      largest coordinate seen
    """

    problem: Problem
    duration: float
    measured: float
    by: str
    budget: float
    spent: float = 0.0
    tried: list[Candidate] = field(default_factory=list)
    size: float = 0.0
    _per_step: dict[int, float] = field(
        default_factory=dict
    )  # cost per step of each degree, with its comparison

    @property
    def most(self) -> int:
        """Largest number of steps in the duration such that each still changes the time."""
        apart = math.ulp(abs(self.problem.t0) + self.duration)
        return int(min(FINEST, max(1.0, 0.25 * self.duration / apart)))

    def affords(self, degree: int, steps: int, runs: float = 1.0) -> bool:
        """Whether ``runs`` runs with their comparisons are expected to fit into the budget."""
        known = self._per_step
        if not known:
            return self.spent < self.budget
        nearest = min(known, key=lambda other: abs(other - degree))
        cost = known[nearest] * (degree / nearest) * self.part(degree, steps)
        return self.spent + runs * cost <= self.budget

    def part(self, degree: int, steps: int) -> int:
        """How many of the steps are in the measured part."""
        share = min(1.0, self.measured / self.duration)
        return min(steps, max(math.ceil(LEAST / degree), math.ceil(share * steps)))

    def length(self, degree: int, steps: int) -> float:
        """Length of the measured part when the duration has ``steps`` steps."""
        return self.duration * (self.part(degree, steps) / steps)

    def run(
        self, degree: int, steps: int, part: int, finer: int = 1, solver: str = "auto",
        samples: int = SAMPLES,
    ) -> tuple[Trajectory, float, float]:  # fmt: skip
        """The first ``part`` steps, each cut into ``finer``, with seconds and evaluations.

        Ctrl-C raises KeyboardInterrupt, since a part of a run is of no use here.
        """
        began = time.perf_counter()
        run = uninterrupted(integrate(
            self.problem, collocation(self.problem, degree), self.duration / (steps * finer),
            part * finer, save_every=max(1, part // samples) * finer, curves=False, solver=solver,
        ))  # fmt: skip
        seconds = time.perf_counter() - began
        counts, size = run.counts, self.problem.v0.size
        evaluations = float(counts["force_evaluations"] + size * counts["hessian_evaluations"])
        self.spent += seconds if self.by == TIME else evaluations
        return run, seconds, evaluations

    def first_guess(self, degree: int, error: float) -> int:
        """A number of steps for which the first has at most its share of the error.

        Not charged to the budget, since it includes compilation and loading.
        """
        size, spent, steps = float(np.max(np.abs(self.problem.q0))), self.spent, 1
        method = collocation(self.problem, degree)
        plain = engine_for(self.problem, method).solves_by_iteration(self.problem, method)
        solver = "fixed_point" if plain else "auto"
        for _ in range(DOUBLINGS):
            one, other = (self.run(s, steps, 1, solver=solver)[0] for s in (degree, degree + MORE))
            if one.success and other.success:
                off = float(np.max(distances(one.q, other.q)))
                if off * steps <= error or off <= 1e-14 * size:
                    break
            if 2 * steps > self.most:
                break
            steps *= 2
        self.run(degree, steps, 1, solver="newton")
        self.spent = spent
        return steps

    def reach(self, degree: int, steps: int, runs: int) -> float:
        """Length over which ``runs`` such runs and their comparisons fit into the budget."""
        part = math.ceil(LEAST / degree)
        for _ in range(DOUBLINGS):
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
        """Try a degree and a number of steps in the duration."""
        part, before = self.part(degree, steps), self.spent
        run, seconds, evaluations = self.run(degree, steps, part)
        error, growth, status, parted = math.inf, math.nan, _failure(run), math.inf
        if not status:
            check, _, _ = self.run(degree + MORE, steps, part)
            error, growth, status, parted = self._error(run, check)
        self._per_step[degree] = (self.spent - before) / part
        whole = steps / part
        found = Candidate(
            degree, steps, self.duration / steps, error, self.length(degree, steps), growth,
            whole * seconds, whole * evaluations, status,
            run.counts.get("newton_steps", 0) / part, parted,
        )  # fmt: skip
        self.tried.append(found)
        return found

    def half_step_error(self, found: Candidate) -> float:
        """The error against the same degree at half the step, which has different round-off."""
        part = self.part(found.degree, found.steps)
        run, _, _ = self.run(found.degree, found.steps, part)
        half, _, _ = self.run(found.degree, found.steps, part, finer=2)
        return self._error(run, half)[0]

    def _error(self, run: Trajectory, better: Trajectory) -> tuple[float, float, str, float]:
        """The error over the duration, the power of time it grew with, why it is unusable, and
        from when on."""
        if wrong := _failure(better):
            return math.inf, math.nan, f"The run to compare with failed. {wrong}", math.inf
        apart = np.maximum.accumulate(distances(run.q, better.q))
        extent = float(np.max(distances(better.q, np.broadcast_to(better.q[:1], better.q.shape))))
        self.size = max(self.size, float(np.max(np.abs(better.q))))
        last, quarter = len(apart) - 1, max(1, (len(apart) - 1) // 4)
        error, early = float(apart[last]), float(apart[quarter])
        t = np.abs(run.t - run.t[0])
        growth = math.nan
        if 0.0 < early <= error and last > quarter:
            growth = math.log(error / early) / math.log(t[last] / t[quarter])
        useless = max(USELESS * extent, ROUNDED * self.size)
        if error > useless:
            sentence = f"It is off by {error:.1e}, where bodies move by {extent:.1e}."
            return math.inf, growth, sentence, float(t[np.argmax(apart > useless)])
        if run.counts["steps"] * abs(run.step or 0.0) < (1.0 - 1e-9) * self.duration:
            power = min(max(growth, POWERS[0]), POWERS[1]) if growth == growth else POWERS[0]
            error *= min(FAR, self.duration / float(t[last])) ** power
        return error, growth, "", math.inf


def _failure(run: Trajectory) -> str:
    """Why a run is unusable, or an empty string."""
    return "" if run.success and run.status.startswith(COMPLETED) else run.status
