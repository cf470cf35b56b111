"""The engine of steps in vector instructions."""

from __future__ import annotations

from galvi.run.general import inertial_formulation
from galvi.run.in_lanes.lagrangian import group_kernel
from galvi.run.in_lanes.nystrom import vector_kernel
from galvi.run.on_group import NewtonFallback
from galvi.run.request import RunRequest
from galvi.run.stepper import Declined, Engine, Stepper
from galvi.run.vector_space import VECTOR_SPACE


def stepper_in_lanes(request: RunRequest) -> Stepper | Declined:
    """A stepper of equal steps in vector instructions, by fixed-point iteration, where the forces
    are known as expressions: built in, from SymPy or traced."""
    problem, method = request.problem, request.method
    if method.in_frame or method.clock is not None:
        return Declined()
    if request.checkpoint.solver == "newton":
        return Declined("steps are iterated there, and the solver newton was asked for")
    formulation = inertial_formulation(problem, method)
    is_vector_space = formulation is VECTOR_SPACE
    kernel = vector_kernel(request) if is_vector_space else group_kernel(request)
    if isinstance(kernel, str):
        return Declined(kernel)
    return Stepper(
        request,
        formulation,
        LANES.name,
        "its forces are known as expressions",
        kernel,
        kernel if is_vector_space else NewtonFallback,
    )


LANES = Engine("lanes", stepper_in_lanes)
