"""Checks that the functions of a problem are unchanged, before steps of a run are repeated."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.clocks.clock import Clock
from galvi.problem import Problem
from galvi.run.energies import energy_calls_functions
from galvi.systems.forces.external_force import force_at
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.nbody import NBody
from galvi.systems.traces import Traces, traces
from galvi.systems.user_functions import arguments

FUNCTION_TOLERANCE = 1e-10  # relative: values that differ by less come from rounding
State = tuple[Array, Array, float]  # q, v, t


class SameFunctions:
    """A call of this check raises ValueError if the problem's functions return other values than
    when the check was made. They are compared at the start, where there may be no force, and at the
    last finite state of the run.

    Parameters
    ----------
    q, v, t
        states of the run (k, ...); v may be momenta
    clock
        the clock of the run's method, or None
    traced
        whether the run used traced functions: these are not called again as long as the system
        has the same traces
    """

    def __init__(
        self, problem: Problem, q: Array, v: Array, t: Array, clock: Any, traced: bool
    ) -> None:
        self.problem, self.clock = problem, clock
        last = max(int(np.count_nonzero(np.isfinite(q.reshape(len(t), -1)).all(axis=1))) - 1, 0)
        end = q[last].reshape(problem.q0.shape), v[last].reshape(problem.v0.shape), float(t[last])
        self.states = (problem.q0, problem.v0, problem.t0), end
        self.values = [_values(problem, clock, state) for state in self.states]
        self.system_traces: Traces | None = traces(problem.system) if traced else None

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "system_traces": None}

    def __call__(self) -> None:
        if self.system_traces is not None and traces(self.problem.system) is self.system_traces:
            return
        for state, values in zip(self.states, self.values, strict=True):
            now = _values(self.problem, self.clock, state)
            if values is None or (now is None and not np.all(np.isfinite(values))):
                continue
            if now is None or not np.allclose(values, now, FUNCTION_TOLERANCE, 0.0, equal_nan=True):
                raise ValueError(
                    "this run keeps no curves, so that its steps are done again, and the functions "
                    "of its system do not return what they did: a number to which they refer has "
                    "changed. Change it back, or keep the curves of a run with curves=True."
                )


def _values(problem: Problem, clock: Any, state: State) -> Array | None:
    """The values (n,) of the functions at a state; None without functions and where one raises."""
    system: Any = problem.system
    q, v, t = state
    values: list[Any] = []
    with np.errstate(all="ignore"):
        try:
            if isinstance(system, NBody):
                values += [system.acceleration(q, t, v)] if system.forces else []
            elif isinstance(system, Lagrangian):
                values += [] if system.brings_slopes else [system.value(q, v, t)]
                values += [system.slopes(*arguments(system, q, v, t))] if system.slopes else []
            elif energy_calls_functions(system) or getattr(system, "gradient", None) is not None:
                has_gradient = getattr(system, "gradient", None) is not None
                slope, energy = system.potential_gradient, system.potential_energy
                values += [slope(q, t) if has_gradient else energy(q[None], np.array([t]))]
            if isinstance(clock, Clock):
                values += [clock.rate(problem)(q.ravel())]
            if callable(getattr(system, "force", None)):
                values += [force_at(system, q, v, t)]
        except Exception:  # a user's function may raise anything
            return None
    return np.concatenate([np.ravel(x) for x in values]) if values else None
