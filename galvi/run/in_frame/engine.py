"""Runs in a moving frame: the engine of methods whose chart is a frame.

What a moving frame leaves is too strong where bodies that pass each other break a hierarchy for
some steps, and doubles lose an orbit at its pericentre where it has become very eccentric. Such a
step is done in the inertial frame, by Gauss collocation of the whole force, in the fewest parts
that end at the same place as a quarter as many. It depends on the state at the step's start alone.
"""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array
from galvi.charts.chart import Cayley
from galvi.curves.curves import Curves, FrameCurves, IdentityChart
from galvi.kernels.nystrom.advance import NOTHING
from galvi.kernels.nystrom.solve import DIVERGED, FORCES, ITERATIONS, NOT_FINITE, SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.rules.rule import gauss
from galvi.run.in_frame import stepper as steppers
from galvi.run.in_lanes.engine import INERTIAL
from galvi.run.point_masses.encounters import encounter
from galvi.run.request import ROUND_OFF, RunRequest, from_start
from galvi.run.run_arrays import FORCES_IN_LANES, LEFT_OVER, RunArrays, State
from galvi.run.stepper import Declined, Stepper, Substeps, solve_steps
from galvi.spaces.polynomials import Polynomials
from galvi.systems.nbody import NBody

PARTS = (1, 4, 16, 64, 256, 1024, 4096, 16384)
SAME = 1e-12  # of the largest place or velocity
PLAIN = Galerkin(Polynomials(8), gauss(8), chart=Cayley())


class InertialKernel:
    """One step in the inertial frame, and the return to the moving one."""

    def __init__(self, run: RunRequest, work: RunArrays) -> None:
        self._run, self._work = run, work

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`; one step."""
        run, work = self._run, self._work
        problem, step, d = run.problem, run.step, run.problem.q0.size
        number = run.checkpoint.first + work.done
        before = work.state[0, :d].copy(), work.state[2, :d].copy()
        parts = in_parts(_start_at(problem, problem.t0 + number * step, *before), step)
        if parts is None:
            return DIVERGED
        for k in (ITERATIONS, FORCES):
            work.counts[k] += parts.counts[k]
        work.counts[FORCES_IN_LANES] = work.counts[FORCES]
        work.counts[LEFT_OVER] += 1
        if len(work.bases):
            row = work.bases[work.done].reshape(4, -1)
            row[:] = 0.0
            row[:2, :d] = before
            work.coefficients[work.done, 0, 0] = 0.0  # the others stay NaN: see `FrameCurves`
        q, v = (parts.state[k].reshape(problem.q0.shape) for k in (0, 2))
        work.state[:] = steppers.enter_again(problem, run.method, q, v)
        work.solver_state[0] = NOTHING
        work.record(run, q.ravel(), v.ravel())
        return SOLVED


def _start_at(problem: Problem, t: float, q: Array, v: Array) -> Problem:
    """The problem from another state, given flat."""
    shape = problem.q0.shape
    return Problem(problem.system, q.reshape(shape), v.reshape(shape), t)


def inertial_curves(problem: Problem, step: float, t: float, q: Array, v: Array) -> Curves:
    """The curves of such a step, from time 0 at its start."""
    work = in_parts(_start_at(problem, t, q, v), step, curves=True)
    assert work is not None, "the step was done before"
    size = step / len(work.bases)
    shape = problem.q0.shape
    bases = work.bases.reshape(-1, *shape)
    return Curves(PLAIN.space, 0.0, size, bases, work.coefficients, IdentityChart(shape))


def in_parts(here: Problem, step: float, *, curves: bool = False) -> RunArrays | None:
    """The step from a start in the fewest parts that end as a quarter of them do, in the inertial
    frame; None where there are none."""
    last: Array | None = None
    total = np.zeros(0, dtype=np.int64)
    for parts in PARTS:
        begin = from_start("fixed_point", ROUND_OFF, parts, curves)
        inner = RunRequest(here, PLAIN, step / parts, parts, begin)
        with np.errstate(all="ignore"):  # what is not finite is a code
            stepper, code = solve_steps(INERTIAL, inner, retried=False)
        work = stepper.work
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


ELSEWHERE = (
    "{left} of {steps} steps were done in the inertial frame, in parts, since what the moving "
    "frame leaves was too strong there, or an orbit too eccentric for it."
)


def refuse(problem: Problem, method: Galerkin) -> None:
    """ValueError where the method's frame does not apply to the problem."""
    refusal = steppers.frame_of(method).refusal(problem)
    if refusal:
        raise ValueError(refusal)


class InFrame:
    """The state is that of galvi.lanes.frames.collocation."""

    velocity_row, guess_kind = 2, 0
    in_other_way = "inertial_steps", ELSEWHERE

    def initial_state(self, problem: Problem, method: Galerkin) -> State:
        """See `Formulation`."""
        return steppers.frame_start(problem, method)

    def is_compiled(self, problem: Problem, method: Galerkin) -> bool:
        """See `Formulation`."""
        return True

    def momenta(self, problem: Problem, saved_v: Array) -> Array:
        """See `Formulation`."""
        return problem.system.momentum(saved_v.reshape(-1, *problem.q0.shape))

    def curve_size(self, problem: Problem, method: Galerkin) -> tuple[int, int]:
        """See `Formulation`."""
        start = steppers.frame_start(problem, method)[0]
        return 4 * start.shape[1], 2 * steppers.frame_of(method).rows(problem)

    def curves(
        self, problem: Problem, method: Galerkin, step: float, t0: float, bases: Array, x: Array
    ) -> FrameCurves:
        """See `Formulation`."""
        motion = steppers.motion_of(problem, method, step)
        path = steppers.Path(problem, method, step, motion.clock, motion.stretch, inertial_curves)
        first = round((t0 - problem.t0) / step)
        bases = bases.reshape(len(bases), 4, steppers.frame_start(problem, method)[0].shape[1])
        return FrameCurves(method.space, t0, step, bases, x, first, path)

    def guess(self, substeps: Substeps, run: RunRequest, work: RunArrays) -> Array | None:
        """Nothing is guessed; None where the frame never applied."""
        checks = steppers.checks_of(run.problem, run.method, run.step, run.checkpoint.tolerance)
        return work.stages if steppers.falls_back(checks) else None

    def failure(self, run: RunRequest, code: int, work: RunArrays) -> str:
        """See `Formulation`."""
        problem, method, step = run.problem, run.method, run.step
        frame = steppers.frame_of(method)
        q, v = (work.state[row, : problem.q0.size].reshape(problem.q0.shape) for row in (0, 2))
        outside = ""
        if np.all(np.isfinite([q, v])):
            outside = frame.leaves(problem.with_initial_state(q, v), step)
        if outside:
            return outside
        name = frame.name
        why = (
            f"the state became infinite or NaN in the {name}"
            if code == NOT_FINITE
            else f"the passes did not converge: what the {name} leaves is too strong for this step"
        )
        if isinstance(problem.system, NBody):
            where = encounter(
                problem,
                problem.system,
                method.stages,
                step,
                work.state[:4, : problem.q0.size],
                framed=True,
            )
            return f"{why}. In the inertial frame, {where}"
        return f"{why}. Use a smaller step, or another chart."


IN_FRAME = InFrame()


class Frame:
    """The engine of moving frames."""

    name = "frame"

    def offers(self, request: RunRequest) -> Stepper | Declined:
        """A stepper for a method whose chart is a frame; ValueError where that does not apply."""
        problem, method = request.problem, request.method
        if not method.in_frame:
            return Declined()
        refuse(problem, method)
        if request.checkpoint.solver == "newton":
            raise ValueError(
                "in a moving frame the solver must be one of auto, fixed_point; received 'newton'."
            )
        reason = f"the method's chart is the {steppers.frame_of(method).name}"
        return Stepper(request, IN_FRAME, self.name, reason, steppers.FrameKernel, InertialKernel)


FRAME = Frame()
