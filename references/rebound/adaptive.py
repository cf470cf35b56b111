"""REBOUND's integrators that choose their steps, as values of one class."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

import galvi
from galvi import NBody, Problem, Trajectory, input_checks
from references.as_trajectory import Failure, as_trajectory
from references.contender import times_of_run
from references.engine_clock import engine_time
from references.rebound import simulation as rebound_simulation
from references.setting import described

# Largest change of the energy, relative to the sum of the sizes of kinetic and potential energy,
# that a close approach explains.
MAX_ENERGY_CHANGE = 1e-3


@dataclass(frozen=True, eq=False)
class ReboundAdaptive:
    """Steps that REBOUND chooses; the step before each sample is shortened to end on it.

    Attributes
    ----------
    integrator
        name of the integrator in REBOUND
    defaults
        options that every run sets and records
    options
        further keys of a setting that are set on REBOUND's integrator
    tolerances
        names of the defaults that the key "tolerance" sets
    fits
        problem -> whether it is supported
    build
        (problem, integrator, options) -> simulation; see `references.rebound.users`

    Notes
    -----
    Setting: samples, the options, tolerance, first_step (default: REBOUND's dt, 1e-3). Shortened
    steps do not reduce the accuracy of a method of high order but cost time: ask for few samples
    where time is measured. REBOUND passes through collisions without a warning, so a run whose
    energy changes by more than 1e-3 of its size is a failure, unless forces do work. REBOUND does
    not count force evaluations.
    """

    fixed_step: ClassVar[bool] = False
    engine: ClassVar[str] = "rebound"

    name: str
    integrator: str
    defaults: Mapping[str, Any]
    options: tuple[str, ...]
    tolerances: tuple[str, ...]
    exact: bool = False
    fits: Callable[[Problem], bool] = rebound_simulation.supports
    build: rebound_simulation.Builder = rebound_simulation.simulation

    @property
    def missing(self) -> str:
        """Why REBOUND cannot be used here; empty when it can."""
        return rebound_simulation.missing()

    def supports(self, problem: Problem) -> bool:
        """N bodies, or a scalar mass about a fixed centre; with another `fits`, the problems that
        it accepts."""
        return self.fits(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        keys = (*self.defaults, *self.options)
        times = times_of_run(self, problem, duration, setting, "tolerance", "first_step", *keys)
        options = {**self.defaults, **{k: setting[k] for k in keys if k in setting}}
        for key in self.tolerances:
            options[key] = input_checks.positive(key, setting.get("tolerance", options[key]))
        sim = self.build(problem, self.integrator, options)
        if "first_step" in setting:
            sim.engine.dt = input_checks.positive("first_step", setting["first_step"])
        sim.engine.dt = math.copysign(sim.engine.dt, duration)
        time_offset, steps_before = sim.engine.t - problem.t0, sim.engine.steps_done
        q, v = (np.full((len(times), *problem.q0.shape), np.nan) for _ in "qv")
        q[0], v[0] = problem.q0, problem.v0
        failure = None
        with rebound_simulation.interrupts_kept(), rebound_simulation.messages() as warned:
            for row, t in enumerate((times[1:] + time_offset).tolist(), start=1):
                try:
                    with engine_time:
                        sim.engine.integrate(t, exact_finish_time=1)
                except RuntimeError as error:
                    failure = Failure(row=row, step=row, why=f"REBOUND stopped: {error}")
                    break
                positions, velocities = sim.states()
                q[row], v[row] = positions.reshape(q[row].shape), velocities.reshape(q[row].shape)

        def trajectory(failure: Failure | None) -> Trajectory:
            return as_trajectory(
                problem,
                described(self.name, {**setting, **options}, rebound_simulation.version()),
                times,
                q,
                v,
                counts={"steps": int(sim.engine.steps_done - steps_before)},
                failure=failure,
                notes=[*warned(), self._accuracy_note(setting)],
            )

        run = trajectory(failure)
        system = problem.system
        forces_do_work = isinstance(system, NBody) and not system.acting.conserve
        lost = None if forces_do_work else _energy_failure(run, self.tolerances[0])
        return trajectory(lost) if lost is not None else run

    def _accuracy_note(self, setting: Mapping[str, Any]) -> str:
        """A note that a run with the default tolerance is no truth; "" for an exact contender and a
        setting with a tolerance."""
        if self.exact or {"tolerance", *self.tolerances} & set(setting):
            return ""
        default = self.defaults[self.tolerances[0]]
        return (
            f"With the default tolerance of {default:g} it is no truth: for a truth, set "
            f"tolerance=1e-15."
        )


def _energy_failure(run: Trajectory, tolerance: str) -> Failure | None:
    """The failure that a jump of the energy reveals; None without one."""
    with np.errstate(all="ignore"):
        energy = galvi.energy(run)
        potential = run.problem.system.potential_energy(run.problem.q0, np.array(run.problem.t0))
        size = abs(energy[0] - potential) + abs(potential)
        jumped = np.abs(energy - energy[0]) > MAX_ENERGY_CHANGE * size
    if not np.any(jumped):
        return None
    row = int(np.argmax(jumped))
    return Failure(
        row=row,
        step=row,
        why=f"The energy changed by {abs(energy[row] - energy[0]) / size:.1e} of its size by t = "
        f"{run.t[row]:.6g}: bodies met, or {tolerance} is too large. End the run earlier or lower "
        "it.",
    )
