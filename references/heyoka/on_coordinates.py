"""heyoka on the coordinates and velocities of a system: what its integrators of these share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import Problem, Trajectory
from references.as_trajectory import as_trajectory
from references.contender import require
from references.heyoka import engine as heyoka_engine
from references.heyoka.engine import DEFAULT
from references.setting import check_keys, described, sample_times


@dataclass(frozen=True)
class OnCoordinates:
    """Taylor's method on states (q, v), in double or quadruple precision.

    precision  "double", or "real128": numbers, times and states are quadruple throughout

    Setting as `references.heyoka.taylor.HeyokaTaylor`.
    """

    name: str
    precision: str = "double"
    exact: bool = False

    @property
    def missing(self) -> str:
        """Why heyoka cannot be used here; empty when it can."""
        return heyoka_engine.missing(self.precision)

    def supports(self, problem: Problem) -> bool:
        """Whether the equations of motion of a problem are known."""
        raise NotImplementedError

    def integrator(self, problem: Problem, tolerance: float, accurate: bool, compact: bool) -> Any:
        """heyoka's integrator for any start of the system."""
        raise NotImplementedError

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        require(self, problem)
        check_keys(setting, ("samples", *DEFAULT))
        times = sample_times(problem.t0, duration, setting)
        options = heyoka_engine.options(setting, self.precision)
        engine = self.integrator(problem, *heyoka_engine.switches(options))
        start = np.concatenate([problem.q0, problem.v0])
        states, steps, failure = heyoka_engine.propagated(
            engine, start.astype(heyoka_engine.kind(self.precision)), times - problem.t0,
            problem.t0, "the state is not finite.",
        )  # fmt: skip
        q, v = np.split(states.astype(np.float64), 2, axis=1)
        return as_trajectory(
            problem,
            described(self.name, {**setting, **options}, heyoka_engine.engine_name(self.precision)),
            times,
            q,
            v,
            counts={"steps": steps},
            failure=failure,
        )


def compiled(
    q: Sequence[Any], v: Sequence[Any], acceleration: Sequence[Any], precision: str,
    tolerance: float, accurate: bool, compact: bool,
) -> Any:  # fmt: skip
    """heyoka's integrator of q' = v, v' = acceleration, its expressions."""
    import heyoka

    number, state = heyoka_engine.kind(precision), [*q, *v]
    return heyoka.taylor_adaptive(
        list(zip(state, [*v, *acceleration], strict=True)),
        np.zeros(len(state)).astype(number),
        time=number(0.0),
        tol=number(tolerance),
        high_accuracy=accurate,
        compact_mode=compact,
        fp_type=number,
    )
