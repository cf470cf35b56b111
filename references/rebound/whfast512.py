"""REBOUND's WHFast512: Wisdom-Holman for up to 8 planets in AVX-512 (Javaheri, Rein, Tamayo 2023).

Option: corrector, 0 or 17. Steps are concatenated between saved states (`concatenate_steps`), so
save few where time is measured. Its relativistic option has built-in units and is not offered.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from galvi import NBody, Problem
from references.rebound import simulation as rebound_simulation
from references.rebound.fixed_steps import ReboundSteps

DEFAULT: Mapping[str, Any] = {"corrector": 0}
BEST: Mapping[str, Any] = {"corrector": 17}
BODIES = 9


def missing() -> str:
    """One sentence saying why the engine cannot be used here; empty when it can."""
    if rebound_simulation.missing():
        return rebound_simulation.missing()
    import rebound

    if not getattr(rebound, "avx512_available", False):
        return "this CPU, or this build of REBOUND, has no AVX-512. Use REBOUND WHFast."
    return ""


def fits(problem: Problem) -> bool:
    """2 to 9 bodies, none massless, one of them heavier than all others together."""
    system = problem.system
    if not isinstance(system, NBody) or system.forces or not 2 <= system.masses.size <= BODIES:
        return False
    if system.has_massless:
        return False
    return bool(2.0 * system.masses.max() > system.masses.sum())


def objection(problem: Problem, options: Mapping[str, Any]) -> str:
    """Why a corrector is refused, '' if it is not: REBOUND would take any other than 0 for 17."""
    if options.get("corrector", 0) not in (0, 17):
        return f"corrector must be 0 or 17; received {options['corrector']!r}."
    return ""


def advance(engine: Any, steps: int) -> None:
    """Advance by ``steps`` steps, which REBOUND counts as one."""
    engine.integrator.concatenate_steps = steps
    engine.steps(1)


WHFAST512 = ReboundSteps(
    "REBOUND WHFast512",
    integrator="whfast512",
    options=("corrector",),
    order=2,
    advance=advance,
    objection=objection,
    engine_missing=missing,
    fits=fits,
)
