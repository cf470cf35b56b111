"""The double pendulum."""

from __future__ import annotations

from collections.abc import Sequence

from galvi import input_checks
from galvi.groups.rn import Rn
from galvi.problem import Problem
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.planar_chain import PlanarChain


def double_pendulum(
    masses: Sequence[float] = (1.0, 1.0),
    lengths: Sequence[float] = (1.0, 1.0),
    gravity: float = 9.81,
    angles: Sequence[float] = (2.0, 2.5),
    rates: Sequence[float] = (0.0, 0.0),
) -> Problem:
    """Two point masses on weightless rods, the second hanging from the first.

    masses, lengths  (2,) starting at the fixed pivot
    angles, rates    (2,) angles of the rods from the downward vertical, in radians, and their rates

    Chaotic for the default angles (tests/references/test_chains.py measures how fast). Raises
    ValueError unless masses and lengths are two positive numbers each.
    """
    two = (2,)
    chain = PlanarChain(
        input_checks.array("masses", masses, two),
        input_checks.array("lengths", lengths, two),
        gravity,
    )
    return Problem(
        system=Lagrangian(chain, Rn(2)),
        q0=input_checks.array("angles", angles, two),
        v0=input_checks.array("rates", rates, two),
        name="double pendulum",
        parameters={
            "masses": chain.masses,
            "lengths": chain.lengths,
            "gravity": chain.gravity,
        },
        units="those of masses, lengths and gravity; angles in radians",
    )
