"""Point masses and potentials by heyoka's Taylor series."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from galvi import Canonical, CentralForce, Force, NBody, Problem, Trajectory
from galvi.arrays import Array
from references.as_trajectory import Failure, as_trajectory
from references.contender import times_of_run
from references.forces import celestial
from references.heyoka import engine as heyoka_engine
from references.heyoka.engine import DOUBLE
from references.newton import is_forced, replaces_force
from references.setting import described

# Many members in heyoka: batches in vector instructions, shared by threads.
#
# heyoka's ensembles copy the integrator, with its compiled code, for each batch; the loop here
# copies it once for each thread.


@dataclass(frozen=True)
class HeyokaBatches:
    """Many starts about a fixed centre, in heyoka's ``taylor_adaptive_batch``.

    Attributes
    ----------
    by_ensemble
        whether heyoka's ``ensemble_propagate_until_batch`` runs the batches; else a loop in each
        thread
    """

    name: str
    by_ensemble: bool

    @property
    def missing(self) -> str:
        """Why heyoka cannot be used here; empty when it can."""
        return heyoka_engine.missing("double")

    def supports(self, problem: Problem) -> bool:
        """A scalar mass about a fixed centre."""
        system = problem.system
        central = isinstance(system, Canonical) and isinstance(system.potential, CentralForce)
        return central and not is_forced(problem) and not replaces_force(problem)

    def prepared(
        self,
        problem: Problem,
        q0: Array,
        v0: Array,
        duration: float,
        tolerance: float,
        threads: int,
    ) -> Callable[[], Array]:
        """A function that runs all members and returns their final positions (n, d); n must be a
        multiple of the batch. The integrator is compiled before."""
        import heyoka

        d, batch = q0.shape[1], heyoka.recommended_simd_size()
        x, v = (heyoka.make_vars(*(f"{letter}{i}" for i in range(d))) for letter in ("x", "v"))
        square = heyoka.sum([coordinate * coordinate for coordinate in x])
        pull = -(problem.system.potential.mu / float(problem.system.mass)) * square**-1.5
        equations = [(x[i], v[i]) for i in range(d)] + [(v[i], pull * x[i]) for i in range(d)]
        starts = np.concatenate([q0, v0], axis=1).reshape(-1, batch, 2 * d).transpose(0, 2, 1)
        prototype = heyoka.taylor_adaptive_batch(
            equations, np.ascontiguousarray(starts[0]), tol=tolerance, compact_mode=False
        )

        def start(integrator: Any, k: int) -> Any:
            integrator.set_time(0.0)
            integrator.state[:] = starts[k]
            return integrator

        copies = [copy.deepcopy(prototype) for _ in range(threads)]

        def states_of_thread(thread: int) -> list[Array]:
            states = []
            for k in range(thread, len(starts), threads):
                start(copies[thread], k).propagate_until(duration)
                states.append(copies[thread].state.copy())
            return states

        def call() -> Array:
            states = np.empty(starts.shape)
            if self.by_ensemble:
                integrators = heyoka.ensemble_propagate_until_batch(
                    prototype, duration, len(starts), start
                )
                states[:] = [integrator[0].state for integrator in integrators]
            else:
                with ThreadPoolExecutor(threads) as pool:
                    for thread, rows in enumerate(pool.map(states_of_thread, range(threads))):
                        states[thread::threads] = rows
            return states.transpose(0, 2, 1).reshape(-1, 2 * d)[:, :d]

        return call


HEYOKA_BATCHES = HeyokaBatches("heyoka, batches in threads", by_ensemble=False)
HEYOKA_ENSEMBLE = HeyokaBatches("heyoka, its ensembles of batches", by_ensemble=True)


BEST: Mapping[str, Any] = {"tolerance": 1e-18, "high_accuracy": True, "compact_mode": False}


@dataclass(frozen=True)
class HeyokaTaylor:
    """heyoka's adaptive Taylor integrator, in double or quadruple precision.

    Attributes
    ----------
    precision
        "double", or "real128": masses, G, times and states are quadruple throughout

    Notes
    -----
    Setting: samples; tolerance, high_accuracy (compensated sums), compact_mode (quick to compile,
    slower to run) as in heyoka, where the default is heyoka's own (DOUBLE) in double and QUADRUPLE
    in real128. Add BEST for what its authors advise at machine precision: a tolerance below it.
    An integrator is compiled for its system and setting, in seconds, and cached: run once before
    timing. Samples are ends of steps.
    """

    fixed_step: ClassVar[bool] = False
    engine: ClassVar[str] = "heyoka"

    name: str = "heyoka"
    precision: str = "double"
    exact: bool = False

    @property
    def missing(self) -> str:
        """Why heyoka cannot be used here; empty when it can."""
        return heyoka_engine.missing(self.precision)

    def supports(self, problem: Problem) -> bool:
        """N bodies, with forces that are not functions, or a scalar mass about a fixed centre in 2
        or 3 dimensions."""
        return bool(_constants(problem))

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        times = times_of_run(self, problem, duration, setting, *DOUBLE)
        options = heyoka_engine.options(setting, self.precision)
        states, steps, failure = self.states(problem, times - problem.t0, options)
        states = states.astype(np.float64).reshape(len(times), -1, 2, 3)
        q, v = (states[:, :, k, : problem.q0.shape[-1]] for k in (0, 1))
        return as_trajectory(
            problem,
            described(self.name, {**setting, **options}, heyoka_engine.engine_name(self.precision)),
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
        number = heyoka_engine.number_type(self.precision)
        forces = getattr(problem.system, "forces", ())
        engine = _compiled(
            _constants(problem), forces, self.precision, *heyoka_engine.checked_options(options)
        )
        pad = ((0, 0), (0, 3 - problem.q0.shape[-1]))
        start = [np.pad(np.atleast_2d(x), pad) for x in (problem.q0, problem.v0)]
        state = np.concatenate(start, axis=1).ravel().astype(number)
        return heyoka_engine.propagate(engine, state, times, problem.t0, "bodies met.")


def _constants(problem: Problem) -> tuple[Any, ...]:
    """The constants of the equations of motion, hashable; empty for an unsupported problem."""
    system = problem.system
    if isinstance(system, NBody):
        if any(isinstance(force, Force) for force in system.forces):
            return ()
        return ("bodies", system.G, 1.0, *system.masses.tolist())
    if not isinstance(system, Canonical) or not isinstance(system.potential, CentralForce):
        return ()
    if is_forced(problem):
        return ()
    plain = not (replaces_force(problem) or system.explicit_time or system.mass.ndim)
    if not plain or problem.q0.size not in (2, 3):
        return ()
    return ("centre", system.potential.mu, float(system.mass), 1.0)


@lru_cache(maxsize=8)
def _compiled(
    constants: tuple[Any, ...],
    forces: tuple[Any, ...],
    precision: str,
    tolerance: float,
    accurate: bool,
    compact: bool,
) -> Any:
    """heyoka's integrator for any start; G times mass is computed in its precision."""
    import heyoka

    kind = heyoka_engine.number_type(precision)
    system, strength, divisor, *masses = constants
    options = {"Gconst": kind(strength) / kind(divisor), "masses": [kind(m) for m in masses]}
    if system == "bodies":
        equations = heyoka.model.nbody(len(masses), **options)
        if forces:
            names = np.array([name for name, _ in equations]).reshape(-1, 2, 3)
            rates = np.array([right for _, right in equations]).reshape(-1, 2, 3)
            pushed = NBody(masses, strength / divisor, forces)
            rates[:, 1] += celestial.accelerations(pushed, names[:, 0], names[:, 1], 0.0)
            equations = list(zip(names.ravel(), rates.ravel(), strict=True))
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
