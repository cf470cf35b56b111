"""Agreement of galvi with the references, and of the claims' truths with second ones.

An agreement is not a claim of a paper: two codes solve one problem, and the bound on their
difference, in agreements.md, is the rounding error or the reference's own error at its setting.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, Protocol

import numpy as np

import galvi
from benchmarks.checks.claim import MakeMethod, Report
from benchmarks.checks.faults import of_motion
from benchmarks.claims.documents import Number
from benchmarks.claims.lie_groups.pendulum_motion import TRUTH as PENDULUM_TRUTH
from benchmarks.store.foreign_texts import visible
from benchmarks.test_problems.planets import PAIR
from benchmarks.work_precision.galvi_methods import Variational
from benchmarks.work_precision.with_settings import WithSettings
from galvi import Problem, Trajectory
from galvi.arrays import Array
from references import missing_engine
from references.closed_forms.kepler import KEPLER
from references.closed_forms.oscillator import OSCILLATOR
from references.closed_forms.pendulum import PENDULUM
from references.closed_forms.top_motion import FREE_TOP, THROWN_BODY
from references.contender import Contender
from references.heyoka import taylor as heyoka_taylor
from references.heyoka.lagrangian import (
    HEYOKA_CHAIN,
    HEYOKA_CHAIN_QUADRUPLE,
    HEYOKA_LAGRANGIAN,
    HEYOKA_LAGRANGIAN_QUADRUPLE,
)
from references.heyoka.rigid import HEYOKA_RIGID, HEYOKA_RIGID_QUADRUPLE
from references.heyoka.taylor import HEYOKA, HEYOKA_QUADRUPLE
from references.jpl.ephemeris import JPL_EPHEMERIS
from references.mujoco.accelerations_ivp import MUJOCO_ACCELERATIONS
from references.mujoco.steps import (
    MUJOCO_DISCRETE,
    MUJOCO_EULER,
    MUJOCO_IMPLICIT,
    MUJOCO_IMPLICITFAST,
    MUJOCO_RK4,
)
from references.pinocchio.tree import PINOCCHIO_ACCELERATIONS
from references.rebound import bulirsch_stoer, leapfrog, saba, whfast, whfast512
from references.rebound.bulirsch_stoer import BULIRSCH_STOER
from references.rebound.ias15 import IAS15
from references.rebound.leapfrog import LEAPFROG
from references.rebound.mercurius import MERCURIUS
from references.rebound.saba import SABA
from references.rebound.trace import TRACE
from references.rebound.whfast import WHFAST
from references.rebound.whfast512 import WHFAST512
from references.scipy.ivp import DOP853, ODE45, RADAU, TIGHT
from references.scipy.lagrangian_ivp import CHAIN_DOP853, LAGRANGIAN_DOP853
from references.scipy.rigid_ivp import RIGID_DOP853, RIGID_ODE45
from references.stored.attitude import STORED_ATTITUDE
from references.stored.chain import STORED_CHAIN
from references.stored.lagrangian import STORED_LAGRANGIAN
from references.stored.planets import STORED_TRUTH
from references.textbook.euler import (
    EXPLICIT_EULER,
    MATRIX_EULER,
    SEMI_IMPLICIT_EULER,
    STORMER_VERLET,
    SYMPLECTIC_EULER,
)
from references.textbook.fourth_order import FOREST_RUTH, RK4
from references.textbook.implicit_euler import IMPLICIT_EULER
from references.textbook.quaternions import QUATERNION_DOP853, QUATERNION_RK4

DEGREE = 12


class Pair(Protocol):
    """Two codes that solve one problem."""

    @property
    def quantity(self) -> str:
        """The name of the row of their difference."""

    @property
    def references(self) -> Sequence[Any]:
        """The references whose engines are needed; the last one is the row's reference."""

    def difference(self, make_method: MakeMethod) -> Number:
        """The largest difference of the configurations."""


@dataclass(frozen=True, eq=False)
class WithGalvi:
    """galvi and a reference.

    Attributes
    ----------
    problem_or_maker
        a problem, or a function that makes it
    duration
        in the problem's unit of time
    steps
        number of galvi's steps, by polynomials of degree DEGREE with as many Gauss points
    setting
        setting of the reference
    """

    contender: Contender
    problem_or_maker: Problem | Callable[[], Problem]
    duration: float
    steps: int = 20
    setting: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def problem(self) -> Problem:
        """The problem."""
        return (
            self.problem_or_maker
            if isinstance(self.problem_or_maker, Problem)
            else self.problem_or_maker()
        )

    @property
    def quantity(self) -> str:
        return f"difference from {self.contender.name}, {self.problem.name}"

    @property
    def references(self) -> Sequence[Any]:
        return (self.contender,)

    def difference(self, make_method: MakeMethod) -> Number:
        """The largest component of the difference at the end."""
        method = Variational(make_method(galvi.Polynomials(DEGREE), galvi.gauss(DEGREE)))
        steps = {"step": self.duration / self.steps, "save_every": self.steps}
        run = method.run(self.problem, self.duration, steps)
        reference = self.contender.run(self.problem, self.duration, self.setting)
        return largest_difference(run, reference, run.q[-1] - reference.q[-1])


@dataclass(frozen=True, eq=False)
class TwoTruths:
    """A truth of the claims and a second one; neither depends on `galvi`.

    Attributes
    ----------
    other_problem
        problem -> the form of it that the second truth solves
    compared
        configurations of the second truth -> the form of the first one's
    """

    truth: Contender | WithSettings
    second: Contender | WithSettings
    problem: Problem
    duration: float
    samples: int = 20
    setting: Mapping[str, Any] = field(default_factory=dict)
    other_problem: Callable[[Problem], Problem] = lambda problem: problem
    as_first: Callable[[Array], Array] = lambda q: q

    @property
    def quantity(self) -> str:
        names = f"{self.truth.name}, and {self.second.name}"
        return f"largest distance of {names}: {self.problem.name}, T = {self.duration:g}"

    @property
    def references(self) -> Sequence[Any]:
        return self.truth, self.second

    def difference(self, make_method: MakeMethod) -> Number:
        """The largest component of the difference at the samples."""
        samples = {"samples": self.samples}
        first = self.truth.run(self.problem, self.duration, samples)
        problem = self.other_problem(self.problem)
        second = self.second.run(problem, self.duration, {**samples, **self.setting})
        return largest_difference(first, second, first.q - self.as_first(second.q))


def largest_difference(run: Trajectory, reference: Trajectory, difference: Array) -> Number:
    """The largest component of a difference; for a failed run, why there is none."""
    statuses = " ".join(
        trajectory.status for trajectory in (run, reference) if not trajectory.success
    )
    if statuses:
        return Number(why=statuses)
    return Number(float(np.max(np.abs(difference))), reference=str(reference.method))


def slower(problem: Problem) -> Problem:
    """The problem with the velocity 0.9 v0 + 0.05: a fault that exceeds every reference's error."""
    return replace(problem, v0=0.9 * problem.v0 + 0.05)


class Agreements:
    """The pairs of a section of agreements.md."""

    FAULTS: ClassVar = {"a slower start": of_motion(slower)}

    def __init__(self, *pairs: Pair) -> None:
        self.pairs = pairs

    def measure(self, make_method: MakeMethod, quick: bool, report: Report) -> dict[str, Number]:
        """The difference of each pair; exceptions and missing engines affect only their own row."""
        return dict(self._measured(make_method, report))

    def _measured(self, make_method: MakeMethod, report: Report) -> Iterator[tuple[str, Number]]:
        for pair in self.pairs:
            report(pair.quantity)
            missing_references = [reference for reference in pair.references if reference.missing]
            if missing_references:
                name = pair.references[-1].name
                yield (
                    pair.quantity,
                    Number(
                        math.nan,
                        name,
                        missing_engine(missing_references[0]),
                        missing_references[0].missing,
                    ),
                )
                continue
            try:
                yield pair.quantity, pair.difference(make_method)
            except Exception as error:
                yield pair.quantity, Number(why=visible(f"{type(error).__name__}: {error}"))


def as_two_bodies(orbit: Problem) -> Problem:
    """Two equal bodies whose relative motion is that of a point about a centre with GM = 1."""
    q, v = (np.array([-0.5 * x, 0.5 * x]) for x in (orbit.q0, orbit.v0))
    return Problem(galvi.NBody([0.5, 0.5]), q, v, name="two equal bodies")


def relative(motion: Array) -> Array:
    """The second body as seen from the first, (k, 2), from (k, 2, 2)."""
    return motion[:, 1] - motion[:, 0]


SPRING, ORBIT = galvi.problems.harmonic_oscillator(), galvi.problems.kepler(0.3)
SWING, TURN = galvi.problems.planar_pendulum(), galvi.problems.free_rigid_body()
HANGING, PLANETS = galvi.problems.pendulum_3d(), galvi.problems.solar_system()
CHAIN = galvi.problems.double_pendulum()
SPRUNG = galvi.problems.elastic_pendulum  # a function, since SymPy takes its time to make it
THROWN, ARM = galvi.problems.free_body_se3(), galvi.problems.skew_arm()

CLOSED = Agreements(
    WithGalvi(OSCILLATOR, SPRING, 1.0),
    WithGalvi(KEPLER, ORBIT, 1.0),
    WithGalvi(PENDULUM, SWING, 1.0),
    WithGalvi(FREE_TOP, TURN, 1.0),
    WithGalvi(THROWN_BODY, THROWN, 1.0),
)
STORED = Agreements(
    WithGalvi(STORED_TRUTH, PLANETS, 1000.0, 500),
    WithGalvi(STORED_CHAIN, CHAIN, 1.0),
    WithGalvi(STORED_LAGRANGIAN, SPRUNG, 1.0),
    WithGalvi(STORED_ATTITUDE, HANGING, 1.0),
)
REBOUND = Agreements(
    WithGalvi(IAS15, PAIR, 1.0),
    WithGalvi(BULIRSCH_STOER, PAIR, 1.0, setting=bulirsch_stoer.BEST),
    WithGalvi(WHFAST, PAIR, 1.0, setting={"step": 0.1, **whfast.BEST}),
    WithGalvi(WHFAST512, PAIR, 1.0, setting={"step": 0.1, **whfast512.BEST}),
    WithGalvi(SABA, PAIR, 1.0, setting={"step": 0.1, **saba.BEST}),
    WithGalvi(MERCURIUS, PAIR, 1.0, setting={"step": 1e-4}),
    WithGalvi(TRACE, PAIR, 1.0, setting={"step": 1e-4}),
    WithGalvi(LEAPFROG, PAIR, 1.0, setting={"step": 0.005, **leapfrog.BEST}),
)
MUJOCO = Agreements(
    WithGalvi(MUJOCO_RK4, TURN, 1.0, setting={"step": 1e-3}),
    WithGalvi(MUJOCO_EULER, TURN, 1.0, setting={"step": 1e-3}),
    WithGalvi(MUJOCO_IMPLICIT, TURN, 1.0, setting={"step": 1e-3}),
    WithGalvi(MUJOCO_IMPLICITFAST, TURN, 1.0, setting={"step": 1e-3}),
    WithGalvi(MUJOCO_DISCRETE, TURN, 1.0, setting={"step": 1e-3}),
    WithGalvi(MUJOCO_ACCELERATIONS, ARM, 0.5),
)
HEYOKAS = Agreements(
    WithGalvi(HEYOKA, PAIR, 1.0, setting={**heyoka_taylor.BEST, "compact_mode": True}),
    WithGalvi(HEYOKA_QUADRUPLE, ORBIT, 1.0),
    WithGalvi(HEYOKA_CHAIN, CHAIN, 1.0),
    WithGalvi(HEYOKA_CHAIN_QUADRUPLE, CHAIN, 1.0),
    WithGalvi(HEYOKA_LAGRANGIAN, SPRUNG, 1.0),
    WithGalvi(HEYOKA_LAGRANGIAN_QUADRUPLE, SPRUNG, 1.0),
    WithGalvi(HEYOKA_RIGID, TURN, 1.0),
    WithGalvi(HEYOKA_RIGID_QUADRUPLE, HANGING, 1.0),
)
SCIPY = Agreements(
    WithGalvi(DOP853, ORBIT, 1.0, setting=TIGHT),
    WithGalvi(ODE45, ORBIT, 1.0, setting={"tolerance": 1e-9}),
    WithGalvi(RADAU, ORBIT, 1.0, setting={"tolerance": 1e-9}),
    WithGalvi(CHAIN_DOP853, CHAIN, 1.0, setting={"tolerance": 1e-13}),
    WithGalvi(LAGRANGIAN_DOP853, SPRUNG, 1.0, setting={"tolerance": 1e-13}),
    WithGalvi(RIGID_DOP853, TURN, 1.0, setting=TIGHT),
    WithGalvi(RIGID_ODE45, TURN, 1.0, setting={"tolerance": 1e-9}),
)
TEXTBOOK = Agreements(
    WithGalvi(STORMER_VERLET, ORBIT, 1.0, setting={"step": 1e-3}),
    WithGalvi(FOREST_RUTH, ORBIT, 1.0, setting={"step": 1e-3}),
    WithGalvi(RK4, ORBIT, 1.0, setting={"step": 1e-3}),
    WithGalvi(EXPLICIT_EULER, ORBIT, 1.0, setting={"step": 1e-3}),
    WithGalvi(IMPLICIT_EULER, ORBIT, 1.0, setting={"step": 1e-3}),
    WithGalvi(SYMPLECTIC_EULER, ORBIT, 1.0, setting={"step": 1e-3}),
    WithGalvi(SEMI_IMPLICIT_EULER, ORBIT, 1.0, setting={"step": 1e-3}),
    WithGalvi(MATRIX_EULER, TURN, 1.0, setting={"step": 1e-3}),
    WithGalvi(QUATERNION_RK4, TURN, 1.0, setting={"step": 1e-3}),
    WithGalvi(QUATERNION_DOP853, TURN, 1.0, setting={"tolerance": 1e-14}),
)
TREES = Agreements(WithGalvi(PINOCCHIO_ACCELERATIONS, ARM, 0.5))
SKY = Agreements(WithGalvi(JPL_EPHEMERIS, PLANETS, 100.0, 50))

WIDE = galvi.problems.kepler(0.6)
BY_IAS15: Mapping[str, Any] = {"other_problem": as_two_bodies, "as_first": relative}
TRUTHS = Agreements(
    TwoTruths(OSCILLATOR, DOP853, SPRING, 8.0, setting=TIGHT),
    TwoTruths(OSCILLATOR, DOP853, SPRING, 2000.0, setting=TIGHT),
    TwoTruths(KEPLER, IAS15, WIDE, 2.0, **BY_IAS15),
    TwoTruths(KEPLER, IAS15, WIDE, 200.0, **BY_IAS15),
    TwoTruths(KEPLER, IAS15, WIDE, 2.0 * np.pi, samples=64, **BY_IAS15),
    TwoTruths(FREE_TOP, RIGID_DOP853, TURN, 200.0, samples=64, setting=TIGHT),
    TwoTruths(FREE_TOP, RIGID_DOP853, TURN, 5.0, setting=TIGHT),
    TwoTruths(PENDULUM_TRUTH, STORED_ATTITUDE, HANGING, 5.0, samples=1),
    TwoTruths(IAS15, STORED_TRUTH, PLANETS, 1e4, samples=1),
)
# The optional engines, for `verify --require`, by the name of their package.
ENGINES: Mapping[str, Contender] = {
    "rebound": IAS15,
    "mujoco": MUJOCO_RK4,
    "heyoka": HEYOKA,
    "jplephem": JPL_EPHEMERIS,
    "pinocchio": PINOCCHIO_ACCELERATIONS,
}


def engines() -> dict[str, str]:
    """Name of an optional engine -> why it cannot be used here, or ""."""
    return {name: contender.missing for name, contender in ENGINES.items()}
