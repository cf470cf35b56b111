"""Rigid bodies that turn, as arenas: galvi in both charts, MuJoCo, and textbook methods."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

import galvi
from benchmarks.arena import ATTITUDE, EPS, Arena, Entry, Setting, Truth, adaptive, fixed
from benchmarks.contenders import gauss_collocation
from galvi import Problem
from galvi.arrays import Array
from references.free_top import FREE_TOP
from references.heyoka_engine import DEFAULT
from references.heyoka_rigid import HEYOKA_RIGID
from references.mujoco_steps import (
    MUJOCO_DISCRETE,
    MUJOCO_EULER,
    MUJOCO_IMPLICIT,
    MUJOCO_IMPLICITFAST,
    MUJOCO_RK4,
)
from references.quaternion_dop853 import QUATERNION_DOP853
from references.quaternion_rk4 import QUATERNION_RK4
from references.rigid_ivp import RIGID_DOP853
from references.stored_attitude import STORED_ATTITUDE

DURATION = 20.0
CHARTS = {"Cayley": galvi.Cayley(), "exponential": galvi.Exponential()}
MUJOCO = (MUJOCO_EULER, MUJOCO_RK4, MUJOCO_IMPLICIT, MUJOCO_IMPLICITFAST, MUJOCO_DISCRETE)
TEXTBOOK_RK4, TEXTBOOK_DOP853 = QUATERNION_RK4.name, QUATERNION_DOP853.name
RK4_STEPS = (100, 400, 1600, 6400, 25_600)  # MuJoCo's and the textbook's, to compare their steps
FIRST_ORDER_STEPS = (1000, 6000, 36_000)
FREE: Mapping[int, Sequence[int]] = {
    4: (60, 120, 240), 6: (30, 40, 60), 8: (30, 40, 60), 10: (30, 40), 12: (30, 40),
}  # fmt: skip
HANGING: Mapping[int, Sequence[int]] = {
    4: (20, 40, 80, 160), 6: (20, 30, 40), 8: (20, 30, 40), 10: (20, 30), 12: (20, 30),
}  # fmt: skip


def free_body(quick: bool) -> Arena:
    """H's free rigid body: some nine turns."""
    problem = galvi.problems.free_rigid_body()

    def truth() -> Truth:
        end = FREE_TOP.run(problem, DURATION, {"samples": 1}).q[-1]
        return Truth(end, 0.5 * EPS, f"{FREE_TOP.name}; to the rounding of the entries")

    return _body(problem, quick, FREE, truth)


def pendulum(quick: bool) -> Arena:
    """H's 3D pendulum from near its rest."""
    problem = galvi.problems.pendulum_3d()

    def truth() -> Truth:
        kept = STORED_ATTITUDE.run(problem, DURATION, {"samples": 1})
        return Truth(kept.q[-1], 0.5 * EPS, f"{kept.method}; to the rounding of the entries")

    return _body(problem, quick, HANGING, truth)


def largest_entry(q: Array, truth: Array) -> float:
    """Of the difference of two rotation matrices, in magnitude."""
    return float(np.max(np.abs(q - truth)))


def _body(
    problem: Problem, quick: bool, ours: Mapping[int, Sequence[int]], truth: Callable[[], Truth]
) -> Arena:
    """Everyone on one body; a few settings of each when quick."""

    def steps(*counts: int) -> list[Setting]:
        return [fixed(DURATION, count) for count in (counts[1:4:2] if quick else counts)]

    def tolerances(*values: float) -> list[Setting]:
        return adaptive("tolerance", values[1:3] if quick else values)

    entries: list[Entry] = [
        (f"galvi degree {degree}, Gauss {degree}, {name}",
         gauss_collocation(degree, chart),
         steps(*counts))
        for name, chart in CHARTS.items()
        for degree, counts in ours.items()
    ]  # fmt: skip
    for engine in MUJOCO:
        counts = RK4_STEPS if engine is MUJOCO_RK4 else FIRST_ORDER_STEPS
        entries.append((engine.name, engine, steps(*counts)))
    entries += [
        (TEXTBOOK_RK4, QUATERNION_RK4, steps(*RK4_STEPS)),
        (TEXTBOOK_DOP853, QUATERNION_DOP853, tolerances(1e-5, 1e-8, 1e-11, 1e-13, 1e-15)),
        (RIGID_DOP853.name, RIGID_DOP853, tolerances(1e-6, 1e-9, 1e-12)),
        (HEYOKA_RIGID.name, HEYOKA_RIGID, tolerances(1e-6, 1e-11, float(DEFAULT["tolerance"]))),
    ]
    return Arena(
        problem,
        DURATION,
        tuple(entries),
        truth,
        quantity=ATTITUDE,
        distance=largest_entry,
        prolonged=True,
    )
