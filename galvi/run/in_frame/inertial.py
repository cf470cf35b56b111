"""Steps of a run in a moving frame that are done in the inertial frame.

The perturbation of a frame's motion is too strong where bodies that pass each other break a
hierarchy for some steps, and double precision loses an orbit at its pericentre where it has become
very eccentric. Such a step is done in the inertial frame, by Gauss collocation of the whole force,
in the smallest number of parts whose end agrees with that of a quarter as many. It depends only on
the state at the start of the step.
"""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array
from galvi.charts.chart import Cayley
from galvi.curves.curves import Curves, IdentityChart
from galvi.kernels.nystrom.advance import NOTHING
from galvi.kernels.nystrom.solve import DIVERGED, FORCES, ITERATIONS, SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.rules.rule import gauss
from galvi.run.equal_steps import EQUAL_STEPS
from galvi.run.in_frame.kernel import frame_of
from galvi.run.request import ROUND_OFF, RunRequest, from_start
from galvi.run.run_arrays import FORCES_IN_LANES, SECOND_KERNEL_STEPS, RunArrays
from galvi.run.stepper import solve_steps
from galvi.spaces.polynomials import Polynomials

PARTS = (1, 4, 16, 64, 256, 1024, 4096, 16384)  # numbers of parts of a step
PARTS_TOLERANCE = 1e-12  # difference of two ends, relative to the largest coordinate or velocity
INERTIAL_METHOD = Galerkin(Polynomials(8), gauss(8), chart=Cayley())


class InertialKernel:
    """One step in the inertial frame, and the return to the moving one."""

    def __init__(self, request: RunRequest, work: RunArrays) -> None:
        self._request, self._work = request, work

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`; does one step, whatever n."""
        request, work = self._request, self._work
        problem, step, d = request.problem, request.step, request.problem.q0.size
        number = request.checkpoint.first + work.steps_done
        before = work.state[0, :d].copy(), work.state[2, :d].copy()
        parts = step_in_parts(_start_at(problem, problem.t0 + number * step, *before), step)
        if parts is None:
            return DIVERGED
        for k in (ITERATIONS, FORCES):
            work.counts[k] += parts.counts[k]
        work.counts[FORCES_IN_LANES] = work.counts[FORCES]
        work.counts[SECOND_KERNEL_STEPS] += 1
        if len(work.bases):
            row = work.bases[work.steps_done].reshape(4, -1)
            row[:] = 0.0
            row[:2, :d] = before
            work.coefficients[work.steps_done, 0, 0] = 0.0  # the others stay NaN: see `FrameCurves`
        q, v = (parts.state[k].reshape(problem.q0.shape) for k in (0, 2))
        work.state[:] = frame_of(request.method).enter(problem, q, v)
        work.solver_state[0] = NOTHING
        work.record(request, q.ravel(), v.ravel())
        return SOLVED


def _start_at(problem: Problem, t: float, q: Array, v: Array) -> Problem:
    """The problem from another state with flat q and v."""
    shape = problem.q0.shape
    return Problem(problem.system, q.reshape(shape), v.reshape(shape), t)


def inertial_curves(problem: Problem, step: float, t: float, q: Array, v: Array) -> Curves:
    """The curves of a step in the inertial frame, with time 0 at its start."""
    work = step_in_parts(_start_at(problem, t, q, v), step, curves=True)
    assert work is not None, "the step was done before"
    size = step / len(work.bases)
    shape = problem.q0.shape
    bases = work.bases.reshape(-1, *shape)
    return Curves(INERTIAL_METHOD.space, 0.0, size, bases, work.coefficients, IdentityChart(shape))


def step_in_parts(start: Problem, step: float, *, curves: bool = False) -> RunArrays | None:
    """The arrays of a step in the inertial frame, in the smallest number of PARTS whose end agrees
    with that of a quarter as many; None where none does. Their counts are those of all attempts."""
    end_before: Array | None = None
    counts = np.zeros(0, dtype=np.int64)
    for parts in PARTS:
        begin = from_start("fixed_point", ROUND_OFF, parts, curves)
        inner = RunRequest(start, INERTIAL_METHOD, step / parts, parts, begin)
        with np.errstate(all="ignore"):  # the code says where numbers are not finite
            stepper, code = solve_steps(EQUAL_STEPS, inner, retried=False)
        work = stepper.work
        counts = work.counts if counts.size == 0 else counts + work.counts
        if code != SOLVED:
            end_before = None
            continue
        end = work.state[[0, 2]] + work.state[[1, 3]]
        if end_before is not None:
            sizes = np.max(np.abs(end), axis=1)
            if np.all(np.max(np.abs(end - end_before), axis=1) <= PARTS_TOLERANCE * sizes):
                return work._replace(counts=counts)
        end_before = end
    return None
