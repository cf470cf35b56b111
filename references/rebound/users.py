"""REBOUND's integrators on a user's own simulation, with its particles in their order.

Everything else in `references.rebound` builds one from a problem, the heaviest body first.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from galvi import NBody, Problem
from galvi.arrays import Array
from galvi.interop.rebound_forces import Forced
from references.rebound.adaptive import ReboundAdaptive
from references.rebound.fixed_steps import ReboundSteps
from references.rebound.simulation import Builder, Simulation, arithmetic_kept, messages

Kind = TypeVar("Kind", ReboundSteps, ReboundAdaptive)


def of_user(contender: Kind, sim: Any, problem: Problem, keep_settings: bool = True) -> Kind:
    """The contender on a copy of this `rebound.Simulation`, which `problem` was read from, or of
    one that is `Forced`, with its forces.

    Parameters
    ----------
    keep_settings
        True: keep the routine of gravity, the time and, if the integrator is the simulation's own,
        its options and unsynchronised state. False: sum the gravity of point masses directly, with
        a new integrator

    Notes
    -----
    A run of ``problem`` itself starts at the simulation's own numbers, a run of another problem at
    that problem's. It does not end where a particle passes exit_max_distance.
    """
    build = _builder(sim, problem, keep_settings)
    if not isinstance(sim, Forced):
        return replace(contender, build=build)
    system = problem.system
    plain = NBody(system.masses, system.G)

    def fits(candidate: Problem) -> bool:
        return candidate.system is system and contender.supports(replace(candidate, system=plain))

    return replace(contender, build=build, fits=fits)


def _builder(sim: Any, read: Problem, keep_settings: bool) -> Builder:
    def build(problem: Problem, integrator: str, options: Mapping[str, Any]) -> Simulation:
        with messages():
            copy = sim.copy()
        copy.exit_max_distance = copy.exit_min_distance = 0.0
        keep_options = keep_settings and copy.integrator.name.decode() == integrator
        if not (keep_options and _same_start(problem, read)):
            with messages(), arithmetic_kept():
                copy.synchronize()
            copy.gravity_ignore = 0  # of WHFast; BS does not set it
            copy.integrator = integrator
        for key, value in options.items():
            try:
                if getattr(copy.integrator, key) != value:
                    setattr(copy.integrator, key, value)
            except (AttributeError, TypeError, ValueError) as error:
                raise ValueError(f"{key} cannot be {value!r} in REBOUND: {error}") from None
        if not keep_settings:
            copy.gravity, copy.t = "basic", 0.0
        if not _same_start(problem, read):
            _set_state(copy, problem.q0, problem.v0)
            copy.t = problem.t0 if keep_settings else 0.0
        return Simulation(copy, np.arange(copy.N), problem.q0.shape[1])

    return build


def _same_start(problem: Problem, read: Problem) -> bool:
    return np.array_equal(problem.q0, read.q0) and np.array_equal(problem.v0, read.v0)


def _set_state(sim: Any, q: Array, v: Array) -> None:
    padding = ((0, 0), (0, 3 - q.shape[1]))
    states = np.pad(q, padding).tolist(), np.pad(v, padding).tolist()
    for particle, position, speed in zip(sim.particles, *states, strict=True):
        particle.xyz, particle.vxyz = position, speed


def defaults(integrator: str) -> dict[str, Any]:
    """The options of a new integrator of REBOUND's, by their names."""
    import rebound

    sim = rebound.Simulation()
    sim.integrator = integrator
    options = {}
    for word in repr(sim.integrator).split(", ")[1:]:
        name, equals, text = word.partition("=")
        if equals and name != "name" and not text.startswith("None"):
            options[name] = getattr(sim.integrator, name)
    return options
