"""The general kernel: Newton's method, or fixed-point iteration, for any functions.

It does what the other engines decline, and is the oracle of all of them.
"""

from __future__ import annotations

from galvi.environment import FAST
from galvi.input_checks import shown
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.group_system import group_system
from galvi.run.on_group import ON_GROUP, GeneralGroupKernel
from galvi.run.request import RunRequest
from galvi.run.stepper import Declined, Formulation, Stepper
from galvi.run.vector_space import VECTOR_SPACE, GeneralVectorKernel

WHY = "" if FAST else "with GALVI_FAST=0 there is no other engine"


def inertial_formulation(problem: Problem, method: Galerkin) -> Formulation:
    """What the state of a run is, without a frame or a clock; ValueError for component degrees that
    do not match."""
    return VECTOR_SPACE if group_system(problem, method) is None else ON_GROUP


class GeneralEqualSteps:
    """The engine of equal steps by the general kernel."""

    name = "general"

    def offers(self, request: RunRequest) -> Stepper | Declined:
        """A stepper for all but moving frames, and fixed-point iteration on groups."""
        problem, method, solver = request.problem, request.method, request.checkpoint.solver
        if method.in_frame:
            return Declined("moving frames need the lanes, which GALVI_FAST=0 leaves out.")
        formulation = inertial_formulation(problem, method)
        if formulation is VECTOR_SPACE:
            make = GeneralVectorKernel
            return Stepper(request, formulation, self.name, WHY, make, make)
        if solver == "fixed_point":
            reason = getattr(problem.system, "untraced", "")
            return Declined(
                f"with a group, an external force or a degree for each component, the solver "
                f"fixed_point needs functions that are built in (EIH for at most 11 "
                f"bodies), from SymPy, or could be traced; received {shown(problem)} with "
                f"{method.name}{f' ({reason})' if reason else ''}. Use the solver auto"
                f"{'' if FAST else ', or leave out GALVI_FAST=0'}."
            )
        return Stepper(request, formulation, self.name, WHY, GeneralGroupKernel, GeneralGroupKernel)


GENERAL_EQUAL_STEPS = GeneralEqualSteps()
