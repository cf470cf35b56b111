"""Compiles forces of potentials for lanes, from generated source that is cached on disk."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from galvi.fast.symbolic import code as symbolic_code

WIDEST, WIDEST_COUPLED = 64, 12  # coordinates up to which a force in lanes is written out
PASS = """from galvi.fast.lanes.force_pass import force_pass
{slopes}

pass_of_force = force_pass(slopes, {d}, {coupled})


def force_pass_DIGEST(Q, t, constants, a):
    pass_of_force(Q, t, constants, a)
"""


def fits(d: int, coupled: bool) -> bool:
    """Whether the accelerations on R^d are written out; ``coupled`` as for `force_source`."""
    return d <= (WIDEST_COUPLED if coupled else WIDEST)


def force_source(slopes: str, d: int, coupled: bool) -> str:
    """The source of the accelerations on R^d from the lines that define ``slopes``.

    slopes   a function (q, t, constants) -> dV/dq, as in galvi.fast.lanes.potentials
    coupled  whether the inverse mass is a full matrix
    """
    return symbolic_code.with_digest(PASS.format(slopes=slopes, d=d, coupled=coupled))


def compiled_force(source: str) -> Callable[..., Any]:
    """The potential's galvi.fast.lanes.force_pass, compiled at the first call."""
    return cast(Callable[..., Any], symbolic_code.functions(source)["force_pass"])
