"""Steps of point masses in a clock by `galvi.fast.lanes.clock`."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from galvi.arrays import Array, read_only
from galvi.extended_precision import decimals, extended_precision, rounded
from galvi.fast.lanes.clock import compiled_advance_clock
from galvi.fast.lanes.vectors import lanes_for
from galvi.fast.nystrom_stepper import _with_low_part as with_low_part
from galvi.fast.nystrom_stepper import aligned, stages_in_lanes
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.rules.rule import gauss
from galvi.run.nystrom_steppers import ROUND_OFF
from galvi.spaces.polynomials import Polynomials
from galvi.systems.nbody import NBody
from galvi.tableau import Tableau

MOST_STAGES = 32
LIGHT = 1e-3  # share of the largest mass below which a body does not feel H - E0

Whole = npt.NDArray[np.int64]


class Taken(NamedTuple):
    """What n steps in a clock leave.

    q, v          (n, d)     after each step
    t             (n, 2)     time and its low part after each step
    coefficients  (n, d, m)  of the curve of q in tau; (0, d, m) where no curves are wanted
    rates         (n, s)     g at the stages
    iterations               passes in all
    """

    q: Array
    v: Array
    t: Array
    coefficients: Array
    rates: Array
    iterations: int


Advance = Callable[..., tuple[Taken, Array, Array, Whole, Array, int]]


def advance_in_lanes(problem: Problem, method: Galerkin, kappa: float) -> Advance | None:
    """A function that does steps of a problem in a clock; None where the kernel does not.

    kappa  1 or 1/2: g = (sum over pairs of (G (m_i + m_j) / r^3)^kappa)^(-1 / (2 kappa))

    The function takes state (4, d): q, its low part, v, its low part; stages (2 d, s), the last
    step's slopes if solver_state says so; clock (4,): t, its low part, G times the energy E0, its
    low part, or NaN to take that of the state; the step h in tau, the number of steps, and whether
    curves are wanted. It returns what they leave, the next four arguments and 0, or the code of a
    step that failed, as galvi.kernels.nystrom.solve.
    """
    system, s = problem.system, method.stages
    if not isinstance(system, NBody) or system.pairs == 0 or s > MOST_STAGES:
        return None
    if method.space != Polynomials(s) or method.rule != gauss(s):
        return None
    dimension, d, lanes = problem.q0.shape[1], problem.q0.size, lanes_for(s)
    masses, halves = masses_in_clock(system, dimension, kappa), round(2 * kappa)
    width, m = stages_in_lanes(s, lanes).size, method.space.dimension - 1
    form = (*((0,) * n for n in (dimension, halves, lanes)), s, width)
    kernel = compiled_advance_clock(dimension, halves, lanes)
    scratch = (8, d, width), (5, max(d, 4)), (6, width), (4, width), (dimension * len(masses[1]),)

    def advance(
        state: Array, stages: Array, solver_state: Whole, clock: Array, h: float, n: int,
        curves: bool,
    ) -> tuple[Taken, Array, Array, Whole, Array, int]:  # fmt: skip
        state, stages, clock = state.copy(), stages.copy(), clock.copy()
        solver_state, done = solver_state.copy(), np.zeros(2, dtype=np.int64)
        if np.isnan(clock[2]):
            clock[2:] = energy_of(masses, state.reshape(4, -1, dimension))
        shapes = (n, d), (n, d), (n, 2), (n if curves else 0, d, m), (n, s)
        kept: list[Any] = [np.empty(shape) for shape in shapes]
        code = int(kernel(
            form, masses, clock_tables(method.table, h, lanes), n, ROUND_OFF, state, stages,
            solver_state, clock, tuple(aligned(*scratch)), done, tuple(kept),
        ))  # fmt: skip
        q, v, t, coefficients, rates = (array[: done[0]] for array in kept)
        taken = Taken(q, v, t, coefficients, rates, int(done[1]))
        return taken, state, stages, solver_state, clock, code

    return advance


def masses_in_clock(system: NBody, dimension: int, kappa: float) -> tuple[Array, Any, Array]:
    """The masses of a system as the kernel takes them."""
    M = system.G * system.masses
    first, second = np.triu_indices(M.size, 1)
    enters = M[first] + M[second] > 0.0
    first, second = first[enters], second[enters]
    with extended_precision():
        product, low = with_low_part(decimals(M[first]) * decimals(M[second]))
    pace = (M[first] + M[second]) ** kappa
    pairs = np.stack([M[second], M[first], product, low, pace], axis=1)
    heavy = LIGHT * M.max() <= M
    turned = np.where(heavy, 1.0 / np.where(heavy, M, 1.0), 0.0)
    members = dimension * np.stack([first, second], axis=1)
    members.setflags(write=False)
    return read_only(pairs.ravel()), members, read_only(np.stack([0.5 * M, turned]))


def energy_of(masses: tuple[Array, Any, Array], state: Array) -> Array:
    """G times the energy and its low part, from the state (4, bodies, dimension)."""
    pairs, members, bodies = masses
    first, second = members.T // state.shape[2]
    with extended_precision():
        q, v = (decimals(state[k]) + decimals(state[k + 1]) for k in (0, 2))
        product, low = pairs.reshape(-1, 5)[:, 2:4].T
        squares = np.sum((q[first] - q[second]) ** 2, axis=1)
        pulls = (decimals(product) + decimals(low)) / [square.sqrt() for square in squares]
        return with_low_part(np.sum(decimals(bodies[0]) @ v**2) - np.sum(pulls))


@lru_cache(maxsize=32)
def clock_tables(table: Tableau, step: float, lanes: int) -> tuple[Array, ...]:
    """mu^T, extrapolation, h b and coefficients from slopes, as the kernel takes them."""
    s = table.c.size
    mu, ahead, parts = (np.zeros((n, stages_in_lanes(s, lanes).size)) for n in (s, s, 1))
    with extended_precision():
        b = decimals(table.b) + decimals(table.low_parts[1])
        exact = rounded((decimals(table.integral) + decimals(table.low_parts[4])) / b)
    larger = np.abs(exact) > np.abs(exact.T)
    mu[:, :s] = np.where(larger, exact, 1.0 - exact.T).T
    mu[np.arange(s), np.arange(s)] = 0.5
    guess = table.extrapolation @ table.analysis[: table.growth.size]
    ahead[:, :s] = (table.b[:, None] * guess / table.b).T
    parts[0, :s] = step * table.b
    parts[0, s // 2] += step - math.fsum(parts[0])
    fit = table.projection / table.b
    return tuple(read_only(array) for array in (mu, ahead, parts, fit))
