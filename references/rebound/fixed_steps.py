"""REBOUND's integrators of fixed step, as values of one class."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from galvi import Problem, Trajectory
from references.as_trajectory import Failure, as_trajectory
from references.contender import steps_of_run
from references.engine_clock import engine_time
from references.rebound import simulation as rebound_simulation
from references.setting import described

CHUNK = 100_000  # number of steps between two checks for Ctrl-C


def _one_by_one(engine: Any, steps: int) -> None:
    engine.steps(steps)


def _no_objection(problem: Problem, options: Mapping[str, Any]) -> str:
    return ""


@dataclass(frozen=True, eq=False)
class ReboundSteps:
    """Whole steps only: the engine never shortens the last one (``exact_finish_time = 0``).

    Attributes
    ----------
    integrator
        name of the integrator in REBOUND
    options
        keys of a setting that are set on REBOUND's integrator
    order
        order of convergence, at vanishing step, with the default options
    advance
        (engine, steps) takes ``steps`` steps
    objection
        (problem, options) -> why they do not fit together; "" where they do
    engine_missing, fits
        functions whose values `missing` and `supports` return
    build
        (problem, integrator, options) -> simulation; see `references.rebound.users`

    Notes
    -----
    Setting: step, save_every and the options, each with REBOUND's default, values and meaning.
    If safe_mode is 0, states are synchronised only when they are saved. REBOUND does not count
    force evaluations. Its warnings, such as of a step above one orbit, go to the status.
    """

    fixed_step: ClassVar[bool] = True
    engine: ClassVar[str] = "rebound"

    name: str
    integrator: str
    options: tuple[str, ...]
    order: int
    exact: bool = False
    advance: Callable[[Any, int], None] = _one_by_one
    objection: Callable[[Problem, Mapping[str, Any]], str] = _no_objection
    engine_missing: Callable[[], str] = rebound_simulation.missing
    fits: Callable[[Problem], bool] = rebound_simulation.supports
    build: rebound_simulation.Builder = rebound_simulation.simulation

    @property
    def missing(self) -> str:
        """Why the engine cannot be used here; empty when it can."""
        return self.engine_missing()

    def supports(self, problem: Problem) -> bool:
        """N bodies, or a scalar mass about a fixed centre; with another `fits`, the problems that
        it accepts."""
        return self.fits(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Equal steps; see `Contender`.

        Raises
        ------
        ValueError
            For options that do not fit the problem, and options that REBOUND refuses.
        """
        steps = steps_of_run(self, problem, duration, setting, *self.options)
        options = {key: setting[key] for key in self.options if key in setting}
        if self.objection(problem, options):
            raise ValueError(f"{self.name}: {self.objection(problem, options)}")
        times = steps.times(problem.t0)
        sim = self.build(problem, self.integrator, options)
        sim.engine.dt = steps.step
        sim.engine.exact_finish_time = 0
        q, v = (np.full((len(times), *problem.q0.shape), np.nan) for _ in "qv")
        q[0], v[0] = problem.q0, problem.v0
        steps_done, failure = 0, None
        with rebound_simulation.arithmetic_kept(), rebound_simulation.messages() as warned:
            for row, target in enumerate(steps.saved[1:].tolist(), start=1):
                while steps_done < target and failure is None:
                    batch = min(target - steps_done, CHUNK)
                    try:
                        with engine_time:
                            self.advance(sim.engine, batch)
                    except RuntimeError as error:
                        if not steps_done and self._refuses(problem, options, steps.step):
                            raise ValueError(f"REBOUND refuses {options}: {error}") from None
                        failure = Failure(
                            row=row, step=steps_done + 1, why=f"REBOUND stopped: {error}"
                        )
                    else:
                        steps_done += batch
                if failure is not None:
                    break
                with engine_time:
                    sim.engine.synchronize()
                positions, velocities = sim.states()
                q[row], v[row] = positions.reshape(q[row].shape), velocities.reshape(q[row].shape)
        return as_trajectory(
            problem,
            described(self.name, setting, rebound_simulation.version()),
            times,
            q,
            v,
            counts={"steps": steps_done},
            step=steps.step,
            failure=failure,
            notes=warned(),
        )

    def _refuses(self, problem: Problem, options: Mapping[str, Any], step: float) -> bool:
        """Whether REBOUND fails to take a first step with these options."""
        sim = self.build(problem, self.integrator, options)
        sim.engine.dt = step
        try:
            self.advance(sim.engine, 1)
        except RuntimeError:
            return True
        return False
