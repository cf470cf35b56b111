"""Selects the engine that runs a problem."""

from __future__ import annotations

from collections.abc import Callable

from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.group_engine import ON_GROUP
from galvi.run.group_system import group_system
from galvi.run.nystrom_engine import NYSTROM
from galvi.run.plan import Engine

# (problem, method) -> the engine of a moving frame, which may refuse; see galvi.fast.
FOR_FRAMES: list[Callable[[Problem, Galerkin], Engine]] = []


def engine_for(problem: Problem, method: Galerkin) -> Engine:
    """The engine. ValueError for component degrees that do not match, or a frame that does not, and
    for a method with a clock, whose runs are those of galvi.run.clocked."""
    if method.clock is not None:
        raise ValueError(
            f"this needs steps that are constant in time; received a method with the clock "
            f"{method.clock}. Leave the clock out."
        )
    if method.in_frame:
        if not FOR_FRAMES:
            raise ValueError("moving frames need galvi.fast, which GALVI_FAST=0 leaves out.")
        return FOR_FRAMES[0](problem, method)
    return NYSTROM if group_system(problem, method) is None else ON_GROUP
