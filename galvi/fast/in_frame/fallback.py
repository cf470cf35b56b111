"""Steps in the inertial frame, where what a moving frame leaves is too strong.

Bodies that pass each other break a hierarchy for some steps. Such a step is done by Gauss
collocation of the whole force, in the fewest parts that end at the same place as a quarter as many.
It depends on the state at the step's start alone.
"""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array
from galvi.charts.chart import Cayley
from galvi.checkpoint import Checkpoint
from galvi.curves.curves import Curves, IdentityChart
from galvi.fast.in_frame.stepper import checks_of, enter_again, falls_back
from galvi.kernels.nystrom.advance import NOTHING
from galvi.kernels.nystrom.solve import DIVERGED, FORCES, ITERATIONS, SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.rules.rule import gauss
from galvi.run.nystrom_engine import nystrom_start
from galvi.run.nystrom_steppers import ROUND_OFF, stepper
from galvi.run.plan import Call, Run
from galvi.run.run_arrays import FORCES_IN_LANES, LEFT_OVER, RunArrays
from galvi.spaces.polynomials import Polynomials

PARTS = (1, 4, 16, 64, 256, 1024, 4096, 16384)
SAME = 1e-12  # of the largest place or velocity
PLAIN = Galerkin(Polynomials(8), gauss(8), chart=Cayley())


def allowed(substeps: object, run: Run, work: RunArrays) -> Array | None:
    """`Engine.guess_from_substeps`: nothing is guessed; None where the frame never applied."""
    checks = checks_of(run.problem, run.method, run.step, run.start.tolerance)
    return work.stages if falls_back(checks) else None


def inertial_stepper(run: Run, work: RunArrays) -> Call:
    """A `Call` that does one step in the inertial frame and returns to the moving one."""
    problem, step = run.problem, run.step
    d, shape = problem.q0.size, problem.q0.shape

    def call(todo: int) -> int:
        number = run.start.first + work.done
        before = work.state[0, :d].copy(), work.state[2, :d].copy()
        found = _in_parts(problem, step, problem.t0 + number * step, *before, curves=False)
        if found is None:
            return DIVERGED
        for k in (ITERATIONS, FORCES):
            work.counts[k] += found.counts[k]
        work.counts[FORCES_IN_LANES] = work.counts[FORCES]
        work.counts[LEFT_OVER] += 1
        if len(work.bases):
            row = work.bases[work.done].reshape(4, -1)
            row[:] = 0.0
            row[:2, :d] = before
            work.coefficients[work.done, 0, 0] = 0.0  # the others stay NaN: see `FrameCurves`
        q, v = (found.state[k].reshape(shape) for k in (0, 2))
        work.state[:] = enter_again(problem, run.method, q, v)
        work.solver_state[0] = NOTHING
        work.record(run, q.ravel(), v.ravel())
        return SOLVED

    return call


def inertial_curves(problem: Problem, step: float, t: float, q: Array, v: Array) -> Curves:
    """The curves of such a step, from time 0 at its start."""
    work = _in_parts(problem, step, t, q, v, curves=True)
    assert work is not None, "the step was done before"
    size = step / len(work.bases)
    shape = problem.q0.shape
    bases = work.bases.reshape(-1, *shape)
    return Curves(PLAIN.space, 0.0, size, bases, work.coefficients, IdentityChart(shape))


def _in_parts(
    problem: Problem, step: float, t: float, q: Array, v: Array, *, curves: bool
) -> RunArrays | None:
    """The step in the fewest parts that end as a quarter of them do; None where there are none."""
    here = Problem(problem.system, q.reshape(problem.q0.shape), v.reshape(problem.q0.shape), t)
    last: Array | None = None
    total = np.zeros(0, dtype=np.int64)
    for parts in PARTS:
        begin = Checkpoint(
            0, *nystrom_start(here, PLAIN.stages), "fixed_point", ROUND_OFF, parts, curves
        )
        run = Run(here, PLAIN, step / parts, parts, begin)
        work = RunArrays.of(run, 2, (q.size, q.size), watched=False)
        with np.errstate(all="ignore"):  # what is not finite is a code
            code = stepper(run, work)(parts)
        total = work.counts if total.size == 0 else total + work.counts
        if code != SOLVED:
            last = None
            continue
        end = work.state[[0, 2]] + work.state[[1, 3]]
        if last is not None:
            sizes = np.max(np.abs(end), axis=1)
            if np.all(np.max(np.abs(end - last), axis=1) <= SAME * sizes):
                return work._replace(counts=total)
        last = end
    return None
