"""The engine of methods whose chart is a moving frame."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from galvi.arrays import Array
from galvi.curves.curves import FrameCurves
from galvi.kernels.nystrom.solve import NOT_FINITE
from galvi.lanes.frames.collocation import ALARM_CHANGE
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.in_frame.curves import FrameOfRun
from galvi.run.in_frame.inertial import InertialKernel
from galvi.run.in_frame.kernel import FrameKernel, frame_of, frame_start, motion_of
from galvi.run.in_frame.passes import checks_of
from galvi.run.point_masses.encounters import encounter
from galvi.run.request import RunRequest
from galvi.run.run_arrays import RunArrays, State
from galvi.run.stepper import Declined, Engine, Stepper, Substeps
from galvi.systems.nbody import NBody

INERTIAL_STEPS_NOTE = (
    "{left} of {steps} steps were done in the inertial frame, in parts, since what the moving "
    "frame leaves was too strong there, or an orbit too eccentric for it."
)


@lru_cache(maxsize=32)
def refuse(problem: Problem, method: Galerkin) -> None:
    """ValueError where the method's frame does not apply to the problem."""
    refusal = frame_of(method).refusal(problem)
    if refusal:
        raise ValueError(refusal)


class InFrame:
    """`Formulation` in a moving frame; the state is that of galvi.lanes.frames.collocation."""

    velocity_row, guess_kind = 2, 0
    in_other_way = "inertial_steps", INERTIAL_STEPS_NOTE

    def initial_state(self, problem: Problem, method: Galerkin) -> State:
        """See `Formulation`."""
        return frame_start(problem, method)

    def is_compiled(self, problem: Problem, method: Galerkin) -> bool:
        """See `Formulation`."""
        return True

    def momenta(self, problem: Problem, saved_moving: Array) -> Array:
        """See `Formulation`."""
        return problem.system.momentum(saved_moving.reshape(-1, *problem.q0.shape))

    def curve_size(self, problem: Problem, method: Galerkin) -> tuple[int, int]:
        """See `Formulation`."""
        start = frame_start(problem, method)[0]
        return 4 * start.shape[1], 2 * frame_of(method).rows(problem)

    def curves(
        self, problem: Problem, method: Galerkin, step: float, t0: float, bases: Array, x: Array
    ) -> FrameCurves:
        """See `Formulation`."""
        motion = motion_of(problem, method, step)
        path = FrameOfRun(problem, method, step, motion.clock, motion.stretch)
        first = round((t0 - problem.t0) / step)
        bases = bases.reshape(len(bases), 4, frame_start(problem, method)[0].shape[1])
        return FrameCurves(method.space, t0, step, bases, x, first, path)

    def guess(self, substeps: Substeps, request: RunRequest, work: RunArrays) -> Array | None:
        """The current stages, since the step is retried in the inertial frame; None where the
        checks rule that out."""
        checks = checks_of(
            request.problem, request.method, request.step, request.checkpoint.tolerance
        )
        return work.stages if checks[ALARM_CHANGE] >= 0.0 else None

    def failure(self, request: RunRequest, code: int, work: RunArrays) -> str:
        """See `Formulation`."""
        problem, method, step = request.problem, request.method, request.step
        frame = frame_of(method)
        q, v = (work.state[row, : problem.q0.size].reshape(problem.q0.shape) for row in (0, 2))
        outside = ""
        if np.all(np.isfinite([q, v])):
            outside = frame.leaves(problem.with_initial_state(q, v), step)
        if outside:
            return outside
        name = frame.name
        failure = (
            f"the state became infinite or NaN in the {name}"
            if code == NOT_FINITE
            else f"the passes did not converge: what the {name} leaves is too strong for this step"
        )
        if isinstance(problem.system, NBody):
            encounter_message = encounter(
                problem,
                problem.system,
                method.stages,
                step,
                work.state[:4, : problem.q0.size],
                in_frame=True,
            )
            return f"{failure}. In the inertial frame, {encounter_message}"
        return f"{failure}. Use a smaller step, or another chart."


IN_FRAME = InFrame()


def frame_kernel(request: RunRequest, work: RunArrays) -> FrameKernel:
    """The kernel of a run, with the number of passes that `checks_of` measures."""
    checks = checks_of(request.problem, request.method, request.step, request.checkpoint.tolerance)
    return FrameKernel(request, work, np.array(checks))


def stepper_in_frame(request: RunRequest) -> Stepper | Declined:
    """A stepper for a method whose chart is a frame; ValueError where that does not apply."""
    problem, method = request.problem, request.method
    if not method.in_frame:
        return Declined()
    refuse(problem, method)
    if request.checkpoint.solver == "newton":
        raise ValueError(
            "in a moving frame the solver must be one of auto, fixed_point; received 'newton'. Use "
            "the solver auto."
        )
    reason = f"the method's chart is the {frame_of(method).name}"
    return Stepper(request, IN_FRAME, FRAME.name, reason, frame_kernel, InertialKernel)


FRAME = Engine("frame", stepper_in_frame)
