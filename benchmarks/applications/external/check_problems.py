"""The problems for checking external integrators: one of each kind, with independent truths."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import galvi
from benchmarks.measures import independent_invariants
from benchmarks.test_problems.planets import PAIR
from galvi import Problem, Trajectory
from galvi.arrays import Array
from references import Contender
from references.closed_forms.kepler import KEPLER
from references.closed_forms.oscillator import OSCILLATOR
from references.closed_forms.pendulum import PENDULUM
from references.closed_forms.top_motion import FREE_TOP
from references.scipy.ivp import DOP853, TIGHT
from references.scipy.lagrangian_ivp import CHAIN_DOP853
from references.stored.attitude import STORED_ATTITUDE


@dataclass(frozen=True, eq=False)
class CheckProblem:
    """A problem for checking external integrators.

    Attributes
    ----------
    problem
        the problem
    duration
        in the problem's unit of time; states are compared half way and at the end
    truth
        the contender that computes the true states, at `setting`
    size
        size of the configurations: errors are divided by it to measure an order
    floor
        relative error below which rounding or the truth's own error dominates
    ordered
        lowest order of convergence that is measured on this problem: 0 for a nonlinear motion on
        one time scale, infinite where no order can be measured
    conserved
        the quantities of `benchmarks.applications.external.loading.CONSERVED` that the motion
        conserves
    long
        duration of the conservation run: about twenty periods, not a whole number of them
    watched
        the problem of the conservation run; None where it is `problem`
    energy
        function (problem, q, p) -> energies (k,)
    """

    problem: Problem
    duration: float
    truth: Contender
    setting: Mapping[str, Any] = field(default_factory=dict)
    size: float = 1.0
    floor: float = 1e-11
    ordered: float = 0.0
    conserved: tuple[str, ...] = ("energy",)
    long: float = 123.0
    watched: Problem | None = None
    energy: Callable[[Problem, Array, Array], Array] = independent_invariants.hamiltonian

    def states(self) -> Trajectory:
        """Return the truth at the start, half way and at the end."""
        return self.truth.run(self.problem, self.duration, {"samples": 2, **self.setting})


ENERGY_AND_MOMENTUM = ("energy", "angular momentum")
CHECK_PROBLEMS = (
    CheckProblem(galvi.problems.kepler(0.3), 5.0, KEPLER, conserved=ENERGY_AND_MOMENTUM),
    CheckProblem(galvi.problems.harmonic_oscillator(0.5), 5.0, OSCILLATOR, ordered=np.inf),
    # Tight is within 1e-12 of itself with a tenth of the tolerance.
    CheckProblem(galvi.problems.driven_oscillator(), 5.0, DOP853, TIGHT, conserved=()),
    CheckProblem(galvi.problems.planar_pendulum(rate=0.5), 5.0, PENDULUM),
    CheckProblem(
        galvi.problems.henon_heiles(), 5.0, DOP853, TIGHT,
        energy=independent_invariants.henon_heiles,
    ),
    CheckProblem(PAIR, 5.0, KEPLER, conserved=ENERGY_AND_MOMENTUM),
    # After eight turns of Jupiter low orders need short steps, and rounding is up to 1e-10 in 1e5
    # steps; the truth is within 4e-12 of `references.stored.planets`, which has no state half way.
    CheckProblem(
        galvi.problems.outer_solar_system(), 36_525.0, DOP853, TIGHT, floor=1e-9, ordered=6.0,
        conserved=ENERGY_AND_MOMENTUM, long=20.3 * 4332.6,
    ),
    CheckProblem(galvi.problems.free_rigid_body(), 5.0, FREE_TOP, conserved=ENERGY_AND_MOMENTUM),
    CheckProblem(galvi.problems.pendulum_3d(), 5.0, STORED_ATTITUDE),
    CheckProblem(
        galvi.problems.double_pendulum(rates=(0.5, -0.7)), 1.0, CHAIN_DOP853, TIGHT, long=40.3,
        watched=galvi.problems.double_pendulum(angles=(0.5, 0.7)),
        energy=independent_invariants.double_pendulum,
    ),
)  # fmt: skip
