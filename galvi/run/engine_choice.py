"""Selects the engine that runs a problem."""

from __future__ import annotations

from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.engine import Engine
from galvi.run.group_engine import ON_GROUP
from galvi.run.group_system import group_system
from galvi.run.nystrom_engine import NYSTROM


def engine_for(problem: Problem, method: Galerkin) -> Engine:
    """`NYSTROM` or `ON_GROUP`. Raises ValueError for component degrees that do not match."""
    return NYSTROM if group_system(problem, method) is None else ON_GROUP
