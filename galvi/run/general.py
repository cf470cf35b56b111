"""The general kernel: Newton's method, or fixed-point iteration, for any functions.

It does the runs that the other engines decline, and is the oracle that they are compared with.
"""

from __future__ import annotations

from galvi.environment import FAST
from galvi.input_checks import shown
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.group_system import group_system
from galvi.run.on_group import ON_GROUP, GeneralGroupKernel
from galvi.run.request import RunRequest
from galvi.run.stepper import Declined, Engine, Formulation, Stepper
from galvi.run.vector_space import VECTOR_SPACE, GeneralVectorKernel

NO_OTHER_ENGINE = "" if FAST else "with GALVI_FAST=0 there is no other engine"


def inertial_formulation(problem: Problem, method: Galerkin) -> Formulation:
    """The formulation of a run without a frame or a clock; ValueError for component degrees that
    the system does not allow."""
    return VECTOR_SPACE if group_system(problem, method) is None else ON_GROUP


def general_equal_steps(request: RunRequest) -> Stepper | Declined:
    """A stepper of equal steps by the general kernel; declines moving frames, and fixed-point
    iteration on groups."""
    problem, method, solver = request.problem, request.method, request.checkpoint.solver
    if method.in_frame:
        return Declined("moving frames need the lanes, which GALVI_FAST=0 leaves out.")
    formulation, name = inertial_formulation(problem, method), GENERAL_EQUAL_STEPS.name
    if formulation is VECTOR_SPACE:
        return Stepper(
            request, formulation, name, NO_OTHER_ENGINE, GeneralVectorKernel, GeneralVectorKernel
        )
    if solver == "fixed_point":
        reason = getattr(problem.system, "untraced", "")
        return Declined(
            f"with a group, an external force or a degree for each component, the solver "
            f"fixed_point needs functions that are built in (EIH for at most 11 "
            f"bodies), from SymPy, or could be traced; received {shown(problem)} with "
            f"{method.name}{f' ({reason})' if reason else ''}. Use the solver auto"
            f"{'' if FAST else ', or leave out GALVI_FAST=0'}."
        )
    return Stepper(
        request, formulation, name, NO_OTHER_ENGINE, GeneralGroupKernel, GeneralGroupKernel
    )


GENERAL_EQUAL_STEPS = Engine("general", general_equal_steps)
