"""Selects the engine that runs a problem."""

from __future__ import annotations

from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.group_engine import ON_GROUP
from galvi.run.group_system import group_system
from galvi.run.in_frame.engine import IN_FRAME, refuse
from galvi.run.nystrom_engine import NYSTROM
from galvi.run.plan import Engine


def engine_for(problem: Problem, method: Galerkin) -> Engine:
    """The engine. ValueError for component degrees that do not match, or a frame that does not."""
    if method.in_frame:
        refuse(problem, method)
        return IN_FRAME
    return NYSTROM if group_system(problem, method) is None else ON_GROUP
