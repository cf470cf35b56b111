"""Selects the engine that runs a problem."""

from __future__ import annotations

from galvi.environment import FAST
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.group_engine import ON_GROUP
from galvi.run.group_system import group_system
from galvi.run.in_frame.engine import frame_engine
from galvi.run.nystrom_engine import NYSTROM
from galvi.run.plan import Engine


def engine_for(problem: Problem, method: Galerkin) -> Engine:
    """The engine. ValueError for component degrees that do not match, or a frame that does not, and
    for a method with a clock, whose runs are those of galvi.run.clocked."""
    if method.clock is not None:
        raise ValueError(
            f"this needs steps that are constant in time; received a method with the clock "
            f"{method.clock}. Leave the clock out."
        )
    if method.in_frame:
        if not FAST:
            raise ValueError("moving frames need the lanes, which GALVI_FAST=0 leaves out.")
        return frame_engine(problem, method)
    return NYSTROM if group_system(problem, method) is None else ON_GROUP
