"""Every work-precision study of the report."""

from __future__ import annotations

from benchmarks.arena import Arena, applegate, kepler, outer_solar_system, solar_system
from benchmarks.body_arenas import free_body, pendulum
from benchmarks.chain_arenas import double_pendulum, planar_chain


def arenas(quick: bool) -> tuple[Arena, ...]:
    """Shorter runs and fewer settings when quick."""
    orbits = (kepler(10 if quick else 100, quick), outer_solar_system(quick), solar_system(quick))
    bodies = (free_body(quick), pendulum(quick), double_pendulum(quick), planar_chain(quick))
    return (*orbits, *bodies) if quick else (*orbits, applegate(quick), *bodies)
