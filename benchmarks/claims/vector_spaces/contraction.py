"""The passes of a fixed-point iteration for the stages of a nonlinear oscillator's step."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import Array, Fault, always
from benchmarks.test_problems.oscillators import HARDENING, PENDULUM, NonlinearOscillator

MAX_PASSES = 400
CONVERGED_RATIO = 1e-9  # difference of passes over the first one, below which it is mostly rounding
DIVERGED_RATIO = 1e9  # difference of passes over the first one, above which the iteration diverges


def extremes(numbers: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """For each name that begins with "least" the smallest of its numbers, for others the largest;
    NaN if one of them is NaN."""
    by_name = {name: [of[name] for of in numbers if name in of] for of in numbers for name in of}
    return {
        name: (np.min if name.startswith("least") else np.max)(sequence)
        for name, sequence in by_name.items()
    }


@dataclass(frozen=True, eq=False)
class Iteration:
    """Passes x -> h^2 pull V'(q0 + places x) - h v0 drift, from x = 0; stages are q0 + places x.

    Attributes
    ----------
    pull : array, shape (unknowns, stages)
    places : array, shape (stages, unknowns)
    drift : array, shape (unknowns,)
    end : array, shape (unknowns,)
        the step ends at q0 + end x
    norm
        norm of x: 2 or inf
    """

    pull: Array
    places: Array
    drift: Array
    end: Array
    norm: float

    def limit(self, oscillator: NonlinearOscillator) -> float:
        """The step at which the norm of a pass's derivative reaches 1, at random positions and
        where |V''| is K; infinity for a derivative that is 0."""
        curvatures = oscillator.curvature(oscillator.sample_positions(len(self.places)))
        norms = [np.linalg.norm(self.pull * bend @ self.places, self.norm) for bend in curvatures]
        return float(max(norms)) ** -0.5 if any(norms) else math.inf

    def run(
        self, oscillator: NonlinearOscillator, method: Any, h: float, factor: float
    ) -> dict[str, float]:
        """Iterate down to round-off; returns numbers by name, NaN if passes do not converge.

        ratio   the largest ratio of successive differences, over the `factor` that bounds it
        reach   the bound on |q| of the stages by Banach's theorem and the first difference, over
                rho
        spread  the largest |q| of the stages of all iterates, over rho
        apart   the distance of galvi's step from that of the fixed point
        """
        problem: Any = oscillator.problem()
        (q0,), (v0,) = problem.q0, problem.v0
        iterates, sizes = [np.zeros_like(self.drift)], list[Any]()
        while len(sizes) < MAX_PASSES:
            pulled = self.pull @ oscillator.slope(q0 + self.places @ iterates[-1])
            iterates.append(h**2 * pulled - h * v0 * self.drift)
            sizes.append(np.linalg.norm(iterates[-1] - iterates[-2], self.norm))
            if not 1e-16 < sizes[-1] < DIVERGED_RATIO * sizes[0]:
                break
        changes = np.array(sizes)
        if not changes[-1] <= CONVERGED_RATIO * changes[0]:
            return dict.fromkeys(("ratio", "reach", "spread", "apart"), math.nan)
        ratios = (changes[1:] / changes[:-1])[changes[:-1] > CONVERGED_RATIO * changes[0]]
        dual = 1 if self.norm == np.inf else 2
        farthest = np.max(np.linalg.norm(self.places, dual, axis=1)) * changes[0] / (1.0 - factor)
        step = galvi.integrate(problem, method, h, 1, solver="fixed_point")
        return {
            "ratio": np.max(ratios) / factor,
            "reach": (abs(q0) + farthest) / oscillator.radius,
            "spread": np.max(abs(q0 + iterates @ self.places.T)) / oscillator.radius,
            "apart": abs(step.q[-1, 0] - q0 - self.end @ iterates[-1]),
        }


def wrong_theory(original: Callable[..., Any]) -> Callable[..., Any]:
    """`galvi.theory` with constants that are larger by a millionth."""

    def wrong(*method: Any, **of: Any) -> Any:
        theory = original(*method, **of)
        step = theory.stage_step and theory.stage_step * (1.0 + 1e-6)
        return replace(theory, friedrichs=theory.friedrichs * (1.0 + 1e-6), stage_step=step)

    return wrong


WEAK = tuple(replace(case, lipschitz=case.lipschitz / 20.0) for case in (PENDULUM, HARDENING))
NARROW = replace(HARDENING, radius=1.0, lipschitz=4.0)
PLACE = "benchmarks.test_problems.oscillators.NONLINEAR"
FAULTS = {
    "constants of theory, a millionth off": Fault(wrong={"galvi.Galerkin.theory": wrong_theory}),
    "a Lipschitz constant of K / 20": Fault(wrong={PLACE: always(WEAK)}),
    "an interval that iterates leave": Fault(wrong={PLACE: always((PENDULUM, NARROW))}),
}
