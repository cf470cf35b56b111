"""The engines of runs, in the order in which they are asked for a stepper."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np

from galvi.environment import FAST
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.clocked.motion import Motion
from galvi.run.clocked.run import CLOCK, energy_at_start, in_transformed_time
from galvi.run.clocked.stepper import ClockStepper
from galvi.run.general import GENERAL_EQUAL_STEPS, inertial_formulation
from galvi.run.in_frame.engine import FRAME, IN_FRAME
from galvi.run.in_lanes.engine import LANES
from galvi.run.request import RunRequest, from_start
from galvi.run.stepper import Declined, Engine, Formulation, Stepper, first_offer


def general_stepper(request: RunRequest) -> Stepper | ClockStepper | Declined:
    """A stepper of the general kernel: with a clock in transformed time, else the offer of
    `GENERAL_EQUAL_STEPS`, which declines moving frames."""
    if request.method.clock is not None:
        reason = "GALVI_FAST=0 leaves the clock's lanes out"
        return in_transformed_time(request, GENERAL.name, reason, energy_at_start(request))
    return GENERAL_EQUAL_STEPS.offer(request)


GENERAL = Engine("general", general_stepper)
# The first engine that offers a stepper does the run.
ENGINES: tuple[Engine, ...] = (CLOCK, FRAME, LANES, GENERAL) if FAST else (GENERAL,)


def stepper_for(request: RunRequest) -> Stepper | ClockStepper:
    """The stepper of the first engine that offers one; ValueError where none does."""
    return first_offer(ENGINES, request)


def has_fixed_point_solver(problem: Problem, method: Galerkin) -> bool:
    """Whether an engine offers the solver fixed_point for runs of this problem and method."""
    try:
        stepper_for(RunRequest(problem, method, 1.0, 1, from_start("fixed_point")))
    except ValueError:
        return False
    return True


def formulation_of(problem: Problem, method: Galerkin) -> Formulation:
    """The formulation of a run of equal steps."""
    return IN_FRAME if method.in_frame else inertial_formulation(problem, method)


def motion_in_clock(
    problem: Problem, method: Galerkin, solver: str, tolerance: float, energy: float | None = None
) -> Motion:
    """The motion of a problem in a method's clock; ValueError where no engine has one.

    Parameters
    ----------
    energy
        E of the clock; None: the energy at the start
    """
    start = from_start(solver, tolerance)
    if energy is not None:
        start = replace(start, clock=np.array([problem.t0, 0.0, energy, 0.0]))
    stepper = stepper_for(RunRequest(problem, method, 1.0, None, start))
    return cast(ClockStepper, stepper).motion
