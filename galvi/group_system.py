"""Which kernel a problem needs: that of Lie groups, or that of canonical systems."""

from __future__ import annotations

from typing import Any, cast

from galvi.groups.rn import Rn
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.canonical_on_rn import CanonicalOnRn
from galvi.systems.system import GroupSystem


def group_system(problem: Problem, method: Galerkin | None = None) -> GroupSystem | None:
    """The problem's system on a group; None where the kernel of canonical systems serves.

    That kernel is a Nystrom method, in which no force depends on the velocity and all components
    share a space; a Canonical system with more than that is one on R^d. Raises ValueError for
    component degrees that do not match, or that the system does not allow.
    """
    system: Any = problem.system
    degrees = getattr(method.space, "degrees", None) if method else None
    if degrees is not None and len(degrees) != problem.v0.size:
        raise ValueError(
            f"the space must have a degree for each of the {problem.v0.size} components; received "
            f"{len(degrees)} degrees, {degrees}."
        )
    if hasattr(system, "group"):
        return cast(GroupSystem, system)
    if isinstance(system, Canonical) and (system.force is not None or degrees is not None):
        return CanonicalOnRn(system, Rn(problem.q0.size))
    if degrees is not None:
        raise ValueError(
            f"degrees for each component are for Canonical and Lagrangian systems; received a "
            f"{type(system).__name__} system. Use galvi.Polynomials."
        )
    return None
