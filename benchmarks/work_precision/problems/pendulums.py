"""Pendulums, chains and oscillators, in coordinates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

import galvi
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import (
    ANGLE,
    COORDINATES,
    EPS,
    Participant,
    Setting,
    Truth,
    WorkPrecisionProblem,
    adaptive,
    fixed,
    galvi_label,
    largest_difference,
    stopped_early_too,
)
from galvi import Problem
from references import Contender
from references.heyoka.chain import HEYOKA_CHAIN
from references.heyoka.lagrangian import HEYOKA_LAGRANGIAN
from references.mujoco.steps import DEFAULT_STEP, MUJOCO_EULER, MUJOCO_IMPLICIT, MUJOCO_RK4
from references.scipy.chain_ivp import CHAIN_DOP853
from references.scipy.ivp import DOP853
from references.scipy.lagrangian_ivp import LAGRANGIAN_DOP853
from references.stored.chain import STORED_CHAIN
from references.stored.lagrangian import STORED_LAGRANGIAN

DURATION = 5.0  # some ten Lyapunov times of the double pendulum: tests/references
RK4_STEPS = (500, 2000, round(DURATION / DEFAULT_STEP), 8000, 16_000)
FIRST_ORDER_STEPS = (2000, 8000)


def chain(
    problem: Problem, quick: bool, ours: Mapping[int, Sequence[int]], tolerances: Sequence[float]
) -> WorkPrecisionProblem:
    """All contenders on one chain; a few settings of each when quick.

    ours        degree: numbers of galvi's steps
    tolerances  of heyoka, not in compact mode, which compiles for seconds and runs faster

    MuJoCo's discrete and implicitfast equal its Euler without damping, so they are omitted.
    """

    def truth() -> Truth:
        kept = STORED_CHAIN.run(problem, DURATION, {"samples": 1})
        error = 0.5 * EPS * float(np.max(np.abs(kept.q[-1])))
        return Truth(kept.q[-1], error, f"{kept.method}; to the rounding of the angles")

    def steps(*counts: int) -> list[Setting]:
        return [fixed(DURATION, count) for count in (counts[1:2] if quick else counts)]

    def at(*values: float) -> list[Setting]:
        return adaptive("tolerance", values[1:2] if quick else values)

    participants: list[Participant] = [
        Participant(
            f"galvi degree {degree}, Gauss {degree}",
            gauss_collocation(degree),
            steps(*counts) if quick else stopped_early_too(steps(*counts)),
        )
        for degree, counts in ours.items()
    ]
    participants += [
        Participant(MUJOCO_RK4.name, MUJOCO_RK4, steps(*RK4_STEPS)),
        *(
            Participant(one.name, one, steps(*FIRST_ORDER_STEPS))
            for one in (MUJOCO_EULER, MUJOCO_IMPLICIT)
        ),
        Participant(CHAIN_DOP853.name, CHAIN_DOP853, at(1e-6, 1e-9, 1e-11)),
        Participant(HEYOKA_CHAIN.name, HEYOKA_CHAIN, at(*tolerances)),
    ]
    return WorkPrecisionProblem(
        problem,
        DURATION,
        tuple(participants),
        truth,
        quantity=ANGLE,
        distance=largest_difference,
        net_time=True,
    )


TOLERANCES = (1e-5, 1e-7, 1e-9, 1e-11, 1e-13)  # of heyoka; at the last it is at round-off


def on_coordinates(
    problem: Problem,
    duration: float,
    quick: bool,
    ours: Mapping[int, Sequence[int]],
    peer: Contender,
    truth: Callable[[], Truth] | None = None,
    **timed: Any,
) -> WorkPrecisionProblem:
    """galvi, heyoka and a DOP853; two settings of each when quick.

    ours   degree: numbers of steps of galvi's, from coarse to fine
    peer   the DOP853
    truth  None for the stored one
    timed  `repeated_run` or `net_time`
    """

    def stored() -> Truth:
        kept = STORED_LAGRANGIAN.run(problem, duration, {"samples": 1})
        error = 0.5 * EPS * float(np.max(np.abs(kept.q[-1])))
        return Truth(kept.q[-1], error, f"{kept.method}; to the rounding of the coordinates")

    def chosen(values: Sequence[Any]) -> Sequence[Any]:
        return values[1:3] if quick else values

    def steps(counts: Sequence[int]) -> list[Setting]:
        found = [fixed(duration, count) for count in chosen(counts)]
        return found if quick else stopped_early_too(found)

    participants = [
        Participant(galvi_label(degree), gauss_collocation(degree), steps(counts))
        for degree, counts in ours.items()
    ]
    participants += [
        Participant(
            HEYOKA_LAGRANGIAN.name, HEYOKA_LAGRANGIAN, adaptive("tolerance", chosen(TOLERANCES))
        ),
        Participant(peer.name, peer, adaptive("tolerance", chosen((1e-6, 1e-9, 1e-12)))),
    ]
    return WorkPrecisionProblem(
        problem,
        duration,
        tuple(participants),
        truth or stored,
        quantity=COORDINATES,
        distance=largest_difference,
        **timed,
    )


STEPS = {4: (200, 280, 400), 6: (140, 200), 8: (80, 100, 140, 200, 280), 12: (80, 100, 140)}
DOUBLE_TOLERANCES = (1e-6, 1e-7, 1e-9, 1e-11, 1e-13, 2.0**-52)


def double_pendulum(quick: bool) -> WorkPrecisionProblem:
    """Two point masses on massless rods, from a chaotic start."""
    return chain(galvi.problems.double_pendulum(), quick, STEPS, DOUBLE_TOLERANCES)


SPRING_STEPS = {4: (35, 50, 100), 6: (25, 35, 50, 70), 8: (20, 25, 35, 50), 12: (20, 25)}


def elastic_pendulum(quick: bool) -> WorkPrecisionProblem:
    """A mass on a spring in polar coordinates, some seven oscillations of the spring."""
    return on_coordinates(
        galvi.problems.elastic_pendulum(),
        5.0,
        quick,
        SPRING_STEPS,
        LAGRANGIAN_DOP853,
        repeated_run=True,
    )


STAR_STEPS = {4: (14, 20, 40), 6: (7, 10, 14, 20), 8: (7, 10, 14, 20), 12: (5, 7, 10)}


def henon_heiles(quick: bool) -> WorkPrecisionProblem:
    """A star in an axisymmetric galaxy, some three revolutions."""
    return on_coordinates(
        galvi.problems.henon_heiles(), 20.0, quick, STAR_STEPS, DOP853, repeated_run=True
    )


CHAIN_STEPS = {4: (7, 10, 14), 6: (5, 7, 10), 8: (5, 7), 12: (4, 5)}


def fermi_pasta_ulam_tsingou(quick: bool) -> WorkPrecisionProblem:
    """15 masses on nonlinear springs, some six periods of the fastest mode."""
    return on_coordinates(
        galvi.problems.fermi_pasta_ulam_tsingou(),
        20.0,
        quick,
        CHAIN_STEPS,
        DOP853,
        repeated_run=True,
    )


RODS_STEPS = {4: (100, 140, 200), 6: (50, 70, 100, 140, 200), 8: (50, 70, 100, 140)}
RODS_TOLERANCES = (1e-4, 1e-5, 1e-7, 1e-9, 1e-10, 1e-11)  # compiled in 10 s together


def planar_chain(quick: bool) -> WorkPrecisionProblem:
    """Five rods, released straight from an angle of one radian."""
    return chain(galvi.problems.planar_chain(), quick, RODS_STEPS, RODS_TOLERANCES)
