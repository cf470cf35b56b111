"""REBOUND's WHFast: Wisdom-Holman with correctors and kernels (Rein, Tamayo and Brown 2019)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import Problem, Trajectory
from references import rebound_simulation
from references.contender import require
from references.outcome import Failure, outcome
from references.setting import check_keys, described, fixed_steps

OPTIONS = ("corrector", "corrector2", "kernel", "coordinates", "safe_mode", "keep_unsynchronized")
DEFAULT: Mapping[str, Any] = {"corrector": 0, "kernel": "DEFAULT", "safe_mode": 1}
BEST: Mapping[str, Any] = {"corrector": 17, "kernel": "LAZY", "safe_mode": 0}
CHUNK = 100_000  # steps between two looks at Ctrl-C


@dataclass(frozen=True)
class Whfast:
    """WHFast, whole steps only: the engine never shortens the last one.

    Setting: step, save_every; corrector (0, 3, 5, 7, 11 or 17), corrector2, kernel, coordinates,
    safe_mode, keep_unsynchronized as in REBOUND. Add DEFAULT or BEST to a step: with safe_mode 0
    states are synchronised when they are saved and not otherwise. REBOUND does not count force
    evaluations. Its warnings, as of a step above one orbit, are added to the status.
    """

    name: str = "REBOUND WHFast"
    order: int = 2
    exact: bool = False

    @property
    def missing(self) -> str:
        """Why REBOUND cannot be used here; empty when it can."""
        return rebound_simulation.missing()

    def supports(self, problem: Problem) -> bool:
        """N bodies, meant for one dominant mass, or a scalar mass about a fixed centre."""
        return rebound_simulation.supports(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Equal steps; see `Contender`. Raises ValueError for options that do not go together."""
        require(self, problem)
        check_keys(setting, ("step", "save_every", *OPTIONS))
        steps = fixed_steps(duration, setting)
        options = {key: setting[key] for key in OPTIONS if key in setting}
        times = steps.times(problem.t0)
        sim = rebound_simulation.simulation(problem, "whfast", options)
        sim.engine.dt = steps.step
        sim.engine.exact_finish_time = 0
        q, v = (np.full((len(times), *problem.q0.shape), np.nan) for _ in "qv")
        q[0], v[0] = problem.q0, problem.v0
        done, failure = 0, None
        with rebound_simulation.messages() as status:
            for row, target in enumerate(steps.saved[1:].tolist(), start=1):
                while done < target and failure is None:
                    more = min(target - done, CHUNK) if done else 1
                    try:
                        sim.engine.steps(more)
                    except RuntimeError as error:
                        if not done:
                            raise ValueError(f"REBOUND refuses {options}: {error}") from None
                        failure = Failure(row=row, step=done + 1, why=f"REBOUND stopped: {error}")
                    else:
                        done += more
                if failure is not None:
                    break
                sim.engine.synchronize()
                where, speed = sim.states()
                q[row], v[row] = where.reshape(q[row].shape), speed.reshape(q[row].shape)
        return outcome(
            problem,
            described(self.name, setting, rebound_simulation.version()),
            times,
            q,
            v,
            counts={"steps": done},
            step=steps.step,
            failure=failure,
            status=status(),
        )


WHFAST = Whfast()
