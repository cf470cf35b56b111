"""REBOUND's IAS15: adaptive Gauss-Radau of order 15 (Rein and Spiegel, MNRAS 446 (2015) 1424)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

import galvi
from galvi import Problem, Trajectory, checks
from references import rebound_simulation
from references.contender import require
from references.outcome import Failure, outcome
from references.setting import check_keys, described, sample_times

DEFAULT: Mapping[str, Any] = {"adaptive_mode": "PRS23", "epsilon": 1e-9}
GLOBAL: Mapping[str, Any] = {"adaptive_mode": "GLOBAL", "epsilon": 1e-9}
LOST = 1e-3  # change of energy, relative to kinetic plus potential, that no close pass explains


@dataclass(frozen=True)
class Ias15:
    """IAS15 with either step criterion: PRS23 (REBOUND's default) or GLOBAL (until January 2024).

    Setting: samples; adaptive_mode, epsilon, min_dt as in REBOUND; tolerance is another name for
    epsilon; first_step (default 1e-3). REBOUND shortens the step before each sample to end on it,
    which is harmless to an adaptive method of this order but not free: ask for few samples where
    time is measured. It passes through collisions without a word, so a run whose energy moves by
    more than 1e-3 of its size is a failure. REBOUND does not count force evaluations.
    """

    name: str = "REBOUND IAS15"
    exact: bool = True

    @property
    def missing(self) -> str:
        """Why REBOUND cannot be used here; empty when it can."""
        return rebound_simulation.missing()

    def supports(self, problem: Problem) -> bool:
        """N bodies, or a scalar mass about a fixed centre."""
        return rebound_simulation.supports(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        require(self, problem)
        known = ("samples", "tolerance", "epsilon", "adaptive_mode", "min_dt", "first_step")
        check_keys(setting, known)
        times = sample_times(problem.t0, duration, setting)
        options = {**DEFAULT, **{k: setting[k] for k in known[2:5] if k in setting}}
        if "tolerance" in setting:
            options["epsilon"] = checks.positive("tolerance", setting["tolerance"])
        checks.positive("epsilon", options["epsilon"])
        sim = rebound_simulation.simulation(problem, "ias15", options)
        sim.engine.dt = checks.positive("first_step", setting.get("first_step", 1e-3))
        q, v = (np.full((len(times), *problem.q0.shape), np.nan) for _ in "qv")
        q[0], v[0] = problem.q0, problem.v0
        failure = None
        with rebound_simulation.messages() as status:
            for row, t in enumerate(times[1:] - problem.t0, start=1):
                try:
                    sim.engine.integrate(t, exact_finish_time=1)
                except RuntimeError as error:
                    failure = Failure(row=row, step=row, why=f"REBOUND stopped: {error}")
                    break
                where, speed = sim.states()
                q[row], v[row] = where.reshape(q[row].shape), speed.reshape(q[row].shape)

        def ended(failure: Failure | None) -> Trajectory:
            return outcome(
                problem,
                described(self.name, {**setting, **options}, rebound_simulation.version()),
                times,
                q,
                v,
                counts={"steps": int(sim.engine.steps_done)},
                failure=failure,
                status=status(),
            )

        run = ended(failure)
        lost = _lost(run)
        return ended(lost) if lost is not None else run


def _lost(run: Trajectory) -> Failure | None:
    """The failure that a jump of the energy betrays, if any."""
    with np.errstate(all="ignore"):
        energy = galvi.energy(run)
        potential = run.problem.system.potential_energy(run.problem.q0, np.array(run.problem.t0))
        size = abs(energy[0] - potential) + abs(potential)
        jumped = np.abs(energy - energy[0]) > LOST * size
    if not np.any(jumped):
        return None
    row = int(np.argmax(jumped))
    return Failure(
        row=row,
        step=row,
        why=f"The energy changed by {abs(energy[row] - energy[0]) / size:.1e} of its size by t = "
        f"{run.t[row]:.6g}: bodies met, or epsilon is too large. End the run earlier or lower it.",
    )


IAS15 = Ias15()
