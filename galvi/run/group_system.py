"""Selects the kernel for a problem: that of Lie groups, or that of canonical systems."""

from __future__ import annotations

from typing import Any, cast

from galvi.groups.matrix_groups import Rn
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.canonical_on_rn import CanonicalOnRn, checked_degrees
from galvi.systems.nbody import NBody
from galvi.systems.nbody_on_rn import NBodyOnRn
from galvi.systems.system import GroupSystem


def group_system(problem: Problem, method: Galerkin | None = None) -> GroupSystem | None:
    """The problem's system on a group; None where the kernel of canonical systems applies.

    The latter is a Nystrom method: forces do not depend on the velocity and all components share
    one space. Other Canonical systems are treated on the group R^d. Raises ValueError for component
    degrees that do not match, or that the system does not allow.
    """
    system: Any = problem.system
    degrees = checked_degrees(method.space, system, problem.v0.size) if method else None
    if hasattr(system, "group"):
        return cast(GroupSystem, system)
    if isinstance(system, Canonical) and (system.force is not None or degrees is not None):
        return CanonicalOnRn(system, Rn(problem.q0.size))
    if isinstance(system, NBody) and system.acting.of_velocity:
        return NBodyOnRn(system, problem.q0.shape[1])
    return None
