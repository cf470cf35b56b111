"""Pendulums, chains and oscillators, in coordinates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import galvi
from benchmarks.work_precision.entries import (
    MIDDLE_VALUES,
    Entry,
    compared,
    galvi_entries,
    truth_to_rounding,
)
from benchmarks.work_precision.problem import ANGLE, COORDINATES, Truth, WorkPrecisionProblem
from galvi import Problem
from references import Contender
from references.heyoka.lagrangian import HEYOKA_CHAIN, HEYOKA_LAGRANGIAN
from references.mujoco.steps import DEFAULT_STEP, MUJOCO_EULER, MUJOCO_IMPLICIT, MUJOCO_RK4
from references.scipy.ivp import DOP853
from references.scipy.lagrangian_ivp import CHAIN_DOP853, LAGRANGIAN_DOP853
from references.stored.chain import STORED_CHAIN
from references.stored.lagrangian import STORED_LAGRANGIAN

Counts = Mapping[int, Sequence[int]]  # degree: numbers of galvi's steps, from coarse to fine
DURATION = 5.0  # some ten Lyapunov times of the double pendulum: tests/references
RK4_STEPS = (500, 2000, round(DURATION / DEFAULT_STEP), 8000, 16_000)
FIRST_ORDER_STEPS = (2000, 8000)


def chain(
    problem: Problem, quick: bool, counts: Counts, tolerances: Sequence[float]
) -> WorkPrecisionProblem:
    """All contenders on one chain; a few settings of each when quick.

    Parameters
    ----------
    tolerances
        of heyoka, not in compact mode, which compiles for seconds and runs faster

    Notes
    -----
    MuJoCo's discrete and implicitfast equal its Euler without damping, so they are omitted.
    """
    entries = [
        *galvi_entries(counts, stops_early_too=True),
        Entry(MUJOCO_RK4, RK4_STEPS),
        *(Entry(contender, FIRST_ORDER_STEPS) for contender in (MUJOCO_EULER, MUJOCO_IMPLICIT)),
        Entry(CHAIN_DOP853, (1e-6, 1e-9, 1e-11)),
        Entry(HEYOKA_CHAIN, tolerances),
    ]
    truth = truth_to_rounding(STORED_CHAIN, problem, DURATION, "angles")
    return compared(problem, DURATION, quick, entries, truth, quantity=ANGLE, net_time=True)


TOLERANCES = (1e-5, 1e-7, 1e-9, 1e-11, 1e-13)  # of heyoka; at the last it is at round-off


def on_coordinates(
    problem: Problem,
    duration: float,
    quick: bool,
    counts: Counts,
    peer: Contender,
    truth: Callable[[], Truth] | None = None,
    **timing: Any,
) -> WorkPrecisionProblem:
    """galvi, heyoka and a DOP853; two settings of each when quick.

    Parameters
    ----------
    peer
        the DOP853
    truth
        None for the stored one
    timed
        `repeated_run` or `net_time`
    """
    entries = [
        *galvi_entries(counts, stops_early_too=True, quick_values=MIDDLE_VALUES),
        Entry(HEYOKA_LAGRANGIAN, TOLERANCES, quick_values=MIDDLE_VALUES),
        Entry(peer, (1e-6, 1e-9, 1e-12), quick_values=MIDDLE_VALUES),
    ]
    truth = truth or truth_to_rounding(STORED_LAGRANGIAN, problem, duration, "coordinates")
    return compared(problem, duration, quick, entries, truth, quantity=COORDINATES, **timing)


DOUBLE_STEPS = {4: (200, 280, 400), 6: (140, 200), 8: (80, 100, 140, 200, 280), 12: (80, 100, 140)}
DOUBLE_TOLERANCES = (1e-6, 1e-7, 1e-9, 1e-11, 1e-13, 2.0**-52)


def double_pendulum(quick: bool) -> WorkPrecisionProblem:
    """Two point masses on massless rods, from a chaotic start."""
    return chain(galvi.problems.double_pendulum(), quick, DOUBLE_STEPS, DOUBLE_TOLERANCES)


RODS_STEPS = {4: (100, 140, 200), 6: (50, 70, 100, 140, 200), 8: (50, 70, 100, 140)}
RODS_TOLERANCES = (1e-4, 1e-5, 1e-7, 1e-9, 1e-10, 1e-11)  # compiled in 10 s together


def planar_chain(quick: bool) -> WorkPrecisionProblem:
    """Five rods, released straight from an angle of one radian."""
    return chain(galvi.problems.planar_chain(), quick, RODS_STEPS, RODS_TOLERANCES)


def elastic_pendulum(quick: bool) -> WorkPrecisionProblem:
    """A mass on a spring in polar coordinates, some seven oscillations of the spring."""
    counts = {4: (35, 50, 100), 6: (25, 35, 50, 70), 8: (20, 25, 35, 50), 12: (20, 25)}
    problem = galvi.problems.elastic_pendulum()
    return on_coordinates(problem, 5.0, quick, counts, LAGRANGIAN_DOP853, repeated_run=True)


def henon_heiles(quick: bool) -> WorkPrecisionProblem:
    """A star in an axisymmetric galaxy, some three revolutions."""
    counts = {4: (14, 20, 40), 6: (7, 10, 14, 20), 8: (7, 10, 14, 20), 12: (5, 7, 10)}
    problem = galvi.problems.henon_heiles()
    return on_coordinates(problem, 20.0, quick, counts, DOP853, repeated_run=True)


def fermi_pasta_ulam_tsingou(quick: bool) -> WorkPrecisionProblem:
    """15 masses on nonlinear springs, some six periods of the fastest mode."""
    counts = {4: (7, 10, 14), 6: (5, 7, 10), 8: (5, 7), 12: (4, 5)}
    problem = galvi.problems.fermi_pasta_ulam_tsingou()
    return on_coordinates(problem, 20.0, quick, counts, DOP853, repeated_run=True)
