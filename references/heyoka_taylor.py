"""heyoka: Taylor's method, compiled for one problem (Biscani and Izzo, MNRAS 504 (2021) 2614)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from galvi import Canonical, CentralForce, NBody, Problem, Trajectory, checks
from galvi.arrays import Array
from references.contender import require
from references.outcome import Failure, outcome
from references.setting import check_keys, described, sample_times

DEFAULT: Mapping[str, Any] = {"tolerance": 2.0**-52, "high_accuracy": False, "compact_mode": False}
BEST: Mapping[str, Any] = {"tolerance": 1e-18, "high_accuracy": True, "compact_mode": False}
QUADRUPLE: Mapping[str, Any] = {"tolerance": 1e-25, "high_accuracy": True, "compact_mode": True}


@dataclass(frozen=True)
class HeyokaTaylor:
    """heyoka's adaptive Taylor integrator, in double or quadruple precision.

    precision  "double", or "real128": masses, G, times and states are quadruple throughout

    Setting: samples; tolerance, high_accuracy (compensated sums), compact_mode (quick to compile,
    slower to run) as in heyoka, where the default is heyoka's own (DEFAULT) in double and QUADRUPLE
    in real128. Add BEST for what its authors advise at machine precision: a tolerance below it.
    An integrator is compiled for its system and setting, in seconds, and kept: run once before
    timing. Samples are ends of steps.
    """

    name: str = "heyoka"
    precision: str = "double"
    exact: bool = False

    @property
    def missing(self) -> str:
        """Why heyoka cannot be used here; empty when it can."""
        try:
            import heyoka
        except ImportError as error:
            return f"{error}. Install heyoka, which has wheels for Linux on x86-64."
        if self.precision != "double" and not hasattr(heyoka, self.precision):
            return f"heyoka {heyoka.__version__} has no {self.precision} on this machine."
        return ""

    def supports(self, problem: Problem) -> bool:
        """N bodies, or a scalar mass about a fixed centre in 2 or 3 dimensions."""
        return bool(_law(problem))

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        require(self, problem)
        check_keys(setting, ("samples", *DEFAULT))
        times = sample_times(problem.t0, duration, setting)
        options = {**self._defaults(), **{key: setting[key] for key in DEFAULT if key in setting}}
        states, steps, failure = self.states(problem, times - problem.t0, options)
        states = states.astype(np.float64).reshape(len(times), -1, 2, 3)
        q, v = (states[:, :, k, : problem.q0.shape[-1]] for k in (0, 1))
        return outcome(
            problem,
            described(self.name, {**setting, **options}, self.engine()),
            times,
            q,
            v,
            counts={"steps": steps},
            failure=failure,
        )

    def states(
        self, problem: Problem, times: Array, options: Mapping[str, Any]
    ) -> tuple[Any, int, Failure | None]:
        """Rows of x, y, z, vx, vy, vz of each body in this precision, (saved, 6 bodies), at times
        since the start, the first 0; NaN past a failure. The steps taken, and the failure.
        """
        import heyoka

        kind = heyoka.real128 if self.precision == "real128" else float
        tolerance = checks.positive("tolerance", options["tolerance"])
        switches = bool(options["high_accuracy"]), bool(options["compact_mode"])
        engine = _compiled(_law(problem), self.precision, tolerance, *switches)
        pad = ((0, 0), (0, 3 - problem.q0.shape[-1]))
        start = [np.pad(np.atleast_2d(x), pad) for x in (problem.q0, problem.v0)]
        states = np.full((len(times), engine.state.size), np.nan).astype(kind)
        states[0] = np.concatenate(start, axis=1).ravel().astype(kind)
        engine.time = kind(0.0)
        engine.state[:] = states[0]
        done = 0
        for row, t in enumerate(times.tolist()[1:], start=1):
            ended, _, _, steps, *_ = engine.propagate_until(kind(t))
            done += int(steps)
            if ended != heyoka.taylor_outcome.time_limit:
                why = f"heyoka stopped before t = {problem.t0 + t:.6g} ({ended}): bodies met. "
                return states, done, Failure(row=row, step=row, why=why + "End the run earlier.")
            states[row] = engine.state
        return states, done, None

    def _defaults(self) -> Mapping[str, Any]:
        return DEFAULT if self.precision == "double" else QUADRUPLE

    def engine(self) -> str:
        """Name, version and precision."""
        import heyoka

        return f"heyoka {heyoka.__version__}, {self.precision}"


def _law(problem: Problem) -> tuple[Any, ...]:
    """What the equations of motion depend on, hashable; empty when heyoka is not given them."""
    system = problem.system
    if isinstance(system, NBody):
        return ("bodies", system.G, 1.0, *system.masses.tolist())
    if not isinstance(system, Canonical) or not isinstance(system.potential, CentralForce):
        return ()
    known = system.gradient is None and not system.explicit_time and system.mass.ndim == 0
    if not known or problem.q0.size not in (2, 3):
        return ()
    return ("centre", system.potential.mu, float(system.mass), 1.0)


@lru_cache(maxsize=8)
def _compiled(
    law: tuple[Any, ...], precision: str, tolerance: float, accurate: bool, compact: bool
) -> Any:
    """heyoka's integrator; G times mass is formed in its precision, not in double."""
    import heyoka

    kind = heyoka.real128 if precision == "real128" else float
    system, strength, divisor, *masses = law
    options = {"Gconst": kind(strength) / kind(divisor), "masses": [kind(m) for m in masses]}
    if system == "bodies":
        equations = heyoka.model.nbody(len(masses), **options)
    else:
        equations = heyoka.model.fixed_centres(positions=np.zeros((1, 3)).astype(kind), **options)
    return heyoka.taylor_adaptive(
        equations,
        np.zeros(6 * len(masses)).astype(kind),
        time=kind(0.0),
        tol=kind(tolerance),
        high_accuracy=accurate,
        compact_mode=compact,
        fp_type=kind,
    )


HEYOKA = HeyokaTaylor()
HEYOKA_QUADRUPLE = HeyokaTaylor("heyoka, quadruple precision", precision="real128", exact=True)
