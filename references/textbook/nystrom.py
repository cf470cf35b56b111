"""Explicit methods of fixed step for q'' = a(q, t), as tableaus that one compiled loop runs.

Q_i = q + c_i h v + h^2 sum_{j<i} A_ij a(Q_j, t + c_i h)
q'  = q + h v + h^2 sum_j position_j a(Q_j)
v'  = v + h sum_j velocity_j a(Q_j)          (Hairer, Norsett and Wanner, Solving ODEs I, II.14)

A method whose only stage is the start of the step evaluates a(q, v, t) and takes external forces.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from galvi import Canonical, NBody, Problem, Trajectory
from galvi.arrays import Array
from references.as_trajectory import Failure, as_trajectory
from references.contender import require
from references.newton import inverse_mass, is_forced, total_force
from references.setting import check_keys, described, fixed_steps
from references.textbook import nystrom_kernel

CHUNK = 100_000  # steps between two looks at Ctrl-C


@dataclass(frozen=True, eq=False)
class Nystrom:
    """An explicit Nystrom method with constant steps; setting: step, save_every.

    name      for titles and tables
    order     order of convergence
    stages    A, (s, s), strictly lower triangular
    nodes     c, (s,)
    position  weights of the accelerations in q', (s,)
    velocity  weights in v', (s,); ValueError unless they sum to 1

    When the last stage is the new configuration, its acceleration starts the next step.
    """

    name: str
    order: int
    stages: tuple[tuple[float, ...], ...]
    nodes: tuple[float, ...]
    position: tuple[float, ...]
    velocity: tuple[float, ...]
    exact: bool = False
    missing: str = ""

    def __post_init__(self) -> None:
        if abs(sum(self.velocity) - 1.0) > 1e-15 or np.any(np.triu(self.stages)):
            raise ValueError(
                f"{self.name} must have velocity weights that sum to 1 and stages below the "
                f"diagonal; received {self.velocity} and {self.stages}."
            )

    @cached_property
    def reuses_last(self) -> bool:
        """Whether the last stage of a step is the first of the next."""
        return (
            len(self.nodes) > 1
            and self.nodes[0] == 0.0
            and self.nodes[-1] == 1.0
            and self.stages[-1] == self.position
        )

    @property
    def takes_forces(self) -> bool:
        """Whether forces may depend on the velocity: the only stage is the start of the step."""
        return self.nodes == (0.0,)

    def supports(self, problem: Problem) -> bool:
        """Any system with L = v.M v / 2 - V; an external force where `takes_forces`."""
        known = isinstance(problem.system, (Canonical, NBody))
        return known and (self.takes_forces or not is_forced(problem))

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Equal steps; compiled when the forces are, else interpreted. See `Contender`."""
        require(self, problem)
        check_keys(setting, ("step", "save_every"))
        steps = fixed_steps(duration, setting)
        times = steps.times(problem.t0)
        tableau = [np.array(x) for x in (self.stages, self.nodes, self.position, self.velocity)]
        force, inverse = total_force(problem), inverse_mass(problem)
        advance = nystrom_kernel.compiled() if force.compiled else nystrom_kernel.advance
        moving = force.function, force.numbers, inverse if inverse.ndim == 2 else inverse[:, None]
        q, v = problem.q0.flatten(), problem.v0.flatten()
        saved = [np.full((len(times), q.size), np.nan) for _ in "qv"]
        saved[0][0], saved[1][0] = q, v
        carried = np.zeros((len(self.nodes), q.size))
        scratch = np.zeros((2, q.size))
        every = int(steps.saved[1])
        failed = evaluations = done = 0
        while done < steps.count and not failed:
            last = min(done + CHUNK, steps.count)
            with np.errstate(all="ignore"):  # the loop looks for non-finite states itself
                failed, more = advance(
                    *tableau, self.reuses_last, *moving, q, v, carried, *scratch, problem.t0,
                    steps.step, done, last, steps.count, every, *saved,
                )  # fmt: skip
            evaluations += more
            done = failed - 1 if failed else last
        return as_trajectory(
            problem,
            described(self.name, setting),
            times,
            *saved,
            counts={"steps": done, "force_evaluations": evaluations},
            step=steps.step,
            failure=_failure(failed, steps.saved, times) if failed else None,
        )


def _failure(failed: int, saved: Any, times: Array) -> Failure:
    row = int(np.searchsorted(saved, failed))
    return Failure(
        row=row,
        step=failed,
        why=f"Step {failed}, towards t = {times[row]:.6g}, gave a non-finite state: bodies met or "
        "the step is too large. Choose a smaller step, or end the run earlier.",
    )
