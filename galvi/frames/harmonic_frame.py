"""The frame that moves with the normal modes of a quadratic part."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.extended_precision import circle, decimals, extended_precision, rounded
from galvi.frames.frame import Motion
from galvi.kernels.compile.function_pointers import addresses
from galvi.lanes.frames import harmonic
from galvi.lanes.frames.collocation import DRIFT, LEAVE, RATES
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.traces import Traces, traces
from galvi.tracing import code
from galvi.tracing.lane_law import WIDEST_FORCE
from galvi.tracing.laws_of_systems import slopes_of

PASS_SOURCE = """from galvi.lanes.frames.harmonic import harmonic_rates
{slopes}

whole_pass = harmonic_rates(slopes, {d})


def rates_DIGEST(numbers, nodes, W, work, guess, k, number):
    whole_pass(numbers, nodes, W, work, k)
"""
ZERO_FREQUENCY = 1e-13  # share of the largest square of a frequency, up to which one is 0


@dataclass(frozen=True)
class HarmonicFrame:
    """Normal modes of the quadratic part of a `Canonical` system, solved exactly by rotations.

    Parameters
    ----------
    stiffness : array, shape (d, d)
        symmetric, the part of d2V/dq2 in the frame; None: d2V/dq2 at q = 0, where negative squares
        of frequencies become 0. Any choice is consistent, since collocation solves the remainder
    passes
        number of passes of a step; None: as many as the tolerance needs at the start

    Notes
    -----
    Steps may be much longer than the fast periods where the remainder is small or slow.

    Examples
    --------
    >>> chain = galvi.problems.fermi_pasta_ulam_tsingou(masses=8)
    >>> method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6), chart=galvi.HarmonicFrame())
    >>> galvi.integrate(chain, method, step=2.0, steps=50).status
    'Completed.'
    """

    stiffness: Any = None
    passes: int | None = None
    name: ClassVar[str] = "harmonic frame"
    reversible: ClassVar[bool] = True
    conserved: ClassVar[str] = (
        "it conserves quadratic functions of (q, p) that its modes and the remainder both conserve"
    )

    def __post_init__(self) -> None:
        if self.passes is not None:
            object.__setattr__(self, "passes", input_checks.whole("passes", self.passes))
        if self.stiffness is None:
            return
        K = input_checks.array("stiffness", self.stiffness)
        if K.ndim != 2 or K.shape[0] != K.shape[1] or not np.allclose(K, K.T, rtol=1e-14, atol=0.0):
            raise ValueError(
                f"stiffness must be a symmetric matrix (d, d); received {K.tolist()}. Give the "
                f"second derivatives of the potential's quadratic part."
            )
        object.__setattr__(self, "stiffness", tuple(map(tuple, K.tolist())))  # hashable

    def refusal(self, problem: Problem) -> str:
        system, d = problem.system, problem.q0.size
        if not isinstance(system, Canonical) or system.force is not None:
            return (
                f"a HarmonicFrame needs a Canonical system without an external force; received "
                f"{type(system).__name__}{' with one' if isinstance(system, Canonical) else ''}. "
                f"Use another chart."
            )
        if self.stiffness is not None and len(self.stiffness) != d:
            return (
                f"the stiffness of a HarmonicFrame must be ({d}, {d}) for q0 of shape ({d},); "
                f"received ({len(self.stiffness)}, {len(self.stiffness)})."
            )
        if slopes_of(system) is None or d > WIDEST_FORCE:
            why = f": {system.untraced}" if system.untraced else ""
            return (
                f"a HarmonicFrame needs a gradient that is built in or could be traced, of at most "
                f"{WIDEST_FORCE} coordinates; received {d} coordinates{why}. Use another chart."
            )
        if not np.all(np.isfinite(_stiffness(self, problem))):
            return (
                "a HarmonicFrame needs a finite d2V/dq2 at q = 0; received one that is not. Give "
                "it the stiffness of the quadratic part."
            )
        return ""

    def leaves(self, problem: Problem, step: float) -> str:
        return ""

    def rows(self, problem: Problem) -> int:
        return problem.q0.size

    def enter(self, problem: Problem, q: Array, v: Array) -> Array:
        F, _squares = _modes(self, problem)
        state = np.zeros((8, problem.q0.size))
        state[0], state[2] = q, v
        state[4], state[6] = (problem.system.momentum(x) @ F for x in (q, v))
        return state

    def motion(self, problem: Problem, step: float, c: Array) -> Motion:
        F, squares = _modes(self, problem)
        d, offsets = problem.q0.size, (c - 0.5) * step
        omega = np.sqrt(squares)[:, None]
        rates, constants = _compiled_rates(problem.system, d, traces(problem.system))
        numbers = np.concatenate(
            [
                F.ravel(),
                squares,
                _rotation(squares, step),
                _rotation(squares, 0.5 * step),
                np.cos(omega * offsets).ravel(),
                _sine(omega, offsets).ravel(),
                constants,
            ]
        )
        pointers = addresses((rates, RATES), (harmonic.drift, DRIFT), (harmonic.leave, LEAVE))
        return Motion(pointers, rates, numbers, 2 * d, 0, _sizes(self, problem, step))

    def flow(self, problem: Problem, w: Array, t: Array) -> Array:
        F, squares = _modes(self, problem)
        omega, t = np.sqrt(squares), t[:, None]
        return (np.cos(omega * t) * w[:, 0] + _sine(omega, t) * w[:, 1]) @ F.T

    def derivatives(self, problem: Problem, w: Array, t: float) -> tuple[Array, Array]:
        F, squares = _modes(self, problem)
        system: Any = problem.system
        omega = np.sqrt(squares)
        c, s = np.cos(omega * t), _sine(omega, np.array(t))
        q = F @ (c * w[0] + s * w[1])
        remaining_stiffness = np.diag(squares) - F.T @ system.potential_hessian(q, problem.t0) @ F
        ahead = np.concatenate([np.diag(c), np.diag(s)], axis=1)
        rates = np.concatenate([np.diag(-squares * s), np.diag(c)], axis=1)
        slope = remaining_stiffness @ ahead
        return np.concatenate([ahead, rates]), np.concatenate(
            [-s[:, None] * slope, c[:, None] * slope]
        )


def _sine(omega: Array, t: Array) -> Array:
    """sin(omega t) / omega; t where omega is 0."""
    return np.where(omega > 0.0, np.sin(omega * t) / np.where(omega > 0.0, omega, 1.0), t)


def _stiffness(frame: HarmonicFrame, problem: Problem) -> Array:
    if frame.stiffness is not None:
        return np.array(frame.stiffness)
    system: Any = problem.system
    with np.errstate(all="ignore"):
        K = np.asarray(system.potential_hessian(np.zeros(problem.q0.size), problem.t0))
    return 0.5 * (K + K.T)


@lru_cache(maxsize=32)
def _modes(frame: HarmonicFrame, problem: Problem) -> tuple[Array, Array]:
    """F (d, d) with F^T M F = 1, and the squares of the frequencies (d,)."""
    system: Any = problem.system
    d = problem.q0.size
    mass = system.mass if system.mass.ndim == 2 else np.diag(np.broadcast_to(system.mass, (d,)))
    inverse = np.linalg.inv(np.linalg.cholesky(mass))
    squares, U = np.linalg.eigh(inverse @ _stiffness(frame, problem) @ inverse.T)
    squares = np.where(squares > ZERO_FREQUENCY * np.max(np.abs(squares)), squares, 0.0)
    return inverse.T @ U, squares


def _sizes(frame: HarmonicFrame, problem: Problem, step: float) -> Array:
    """Sizes (2 d,): the largest velocity amplitude for all velocities, and for positions that over
    omega, or the reach of a step where this is smaller."""
    state, (_, squares) = frame.enter(problem, problem.q0, problem.v0), _modes(frame, problem)
    largest_rate = float(np.sqrt(np.max(state[6] ** 2 + squares * state[4] ** 2)))
    largest_mode = max(float(np.max(np.abs(state[4]))), abs(step) * largest_rate)
    omega = np.sqrt(squares)
    position_sizes = np.where(
        omega * largest_mode > largest_rate,
        largest_rate / np.where(omega > 0.0, omega, 1.0),
        largest_mode,
    )
    sizes = np.concatenate([position_sizes, np.full(squares.size, largest_rate)])
    return np.where(sizes > 0.0, sizes, 1.0)


def _rotation(squares: Array, t: float) -> Array:
    """The six rows of a rotation, flat, see galvi.lanes.frames.harmonic."""
    with extended_precision():
        rows = np.empty((3, squares.size), dtype=object)
        for i, square in enumerate(map(Decimal, squares.tolist())):
            omega, time = square.sqrt(), Decimal(t)
            cosine, sine = circle(omega * time)
            rows[:, i] = cosine - 1, sine / omega if omega else time, -omega * sine
        nearest = rounded(rows)
        return np.concatenate([nearest, rounded(rows - decimals(nearest))]).ravel()


@lru_cache(maxsize=32)
def _compiled_rates(system: Canonical, d: int, system_traces: Traces) -> tuple[Any, Array]:
    """The compiled rates and the potential's constants."""
    slopes = slopes_of(system)
    assert slopes is not None
    lines, constants = slopes
    source = code.with_digest(PASS_SOURCE.format(slopes=lines, d=d))
    return code.functions(source)["rates"], np.asarray(constants, dtype=np.float64)
