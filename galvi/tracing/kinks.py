"""Detects where a Lagrangian is not C^2.

Abs, sign, Max, Min, Heaviside and Piecewise switch branches where an expression changes its sign,
on a surface. Since |x|^3 is C^2 there and |x| is not, L and its derivatives are compared across it.
"""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from galvi.arrays import Array

JUMP_NAMES = ("values jump", "first derivatives jump", "second derivatives jump")
# Growth from FAR_FROM_SURFACE to NEAR_SURFACE above which second derivatives count as unbounded.
UNBOUNDED_GROWTH = 4.0
# Distances from the surface, relative to the state.
FAR_FROM_SURFACE, NEAR_SURFACE = 2.0**-10, 2.0**-17
# Ratio of a difference at NEAR_SURFACE to that at FAR_FROM_SURFACE above which it is a jump.
PERSISTENT_FRACTION = 0.3
DIFFERENCE_NOISE = 2.0**-30  # relative noise of differences over NEAR_SURFACE: round-off is 2^-35
STATE_SIZES, TRIALS, BRACKET_HALVINGS = (1.0, 0.1, 10.0), 20, 60


def surfaces(L: Any, moving: set[Any]) -> tuple[Any, ...]:
    """The expressions in the moving symbols whose signs select branches of L, sorted.

    Parameters
    ----------
    moving
        the symbols of q, v and t, not the parameters
    """
    import sympy

    switching = {a.args[0] for a in L.atoms(sympy.Abs, sympy.sign, sympy.Heaviside)}
    for extreme in L.atoms(sympy.Max, sympy.Min):
        switching |= {a - b for a, b in combinations(extreme.args, 2)}
    for pieces in L.atoms(sympy.Piecewise):
        for _, condition in pieces.args:
            switching |= {r.lhs - r.rhs for r in condition.atoms(sympy.core.relational.Relational)}
    switching = {expression for expression in switching if expression.free_symbols & moving}
    return tuple(sorted(switching, key=sympy.default_sort_key))


def derivative_off_kinks(L: Any, x: Any) -> Any:
    """dL/dx away from kinks.

    Raises
    ------
    ValueError
        For a function whose derivative SymPy does not know; the message names it.
    """
    import sympy

    derivative = L.diff(x).replace(sympy.DiracDelta, lambda *_: sympy.Integer(0))
    unevaluated = derivative.atoms(sympy.Derivative, sympy.Subs)
    if unevaluated:
        heads = sorted({str(f.func) for term in unevaluated for f in term.atoms(sympy.Function)})
        raise ValueError(
            f"the Lagrangian must be differentiable; received {', '.join(heads)}, whose derivative "
            f"SymPy does not know. Write it in other functions."
        )
    return (
        derivative.rewrite(sympy.Heaviside, sympy.Piecewise)
        if derivative.has(sympy.Heaviside)
        else derivative
    )


def find_kink(L: Any, k: int) -> str:
    """A discontinuity of L at random points of surface k, in words; '' if none is found."""
    d = L.dimension
    draw = np.random.default_rng(0)
    for trial in range(TRIALS):
        size = STATE_SIZES[trial % len(STATE_SIZES)]
        ends = size * draw.standard_normal((2, 2 * d + 1))
        start, end = ends
        signs = [_sign(L, k, x) for x in ends]
        if signs[0] * signs[1] >= 0.0:
            continue
        for _ in range(BRACKET_HALVINGS):
            middle = 0.5 * (start + end)
            if _sign(L, k, middle) == signs[0]:
                start = middle
            else:
                end = middle
        along = ends[1] - ends[0]
        jump = _jump(L, 0.5 * (start + end), along / np.linalg.norm(along), size)
        if jump:
            return jump
    return ""


def check_start(L: Any, q: Array, v: Array, t: float) -> None:
    """Raise ValueError if the motion starts on a kink, where L has no second derivatives."""
    for k, surface in enumerate(L.switching):
        if is_kink(L, k, q, v, t):
            raise ValueError(
                f"the Lagrangian is not twice differentiable at the start, where {surface} "
                f"changes its sign. Start elsewhere, or smooth it."
            )


def is_kink(L: Any, k: int, q: Array, v: Array, t: float) -> bool:
    """Whether the state lies on surface k and L has no second derivatives there."""
    x = np.concatenate([q, v, [t]])
    sizes = np.concatenate([_sizes(q), _sizes(v), _sizes(np.array([t]))])
    steps = np.diag(sizes)
    ahead, behind = (
        [_sign(L, k, x + s * NEAR_SURFACE * step) for step in steps] for s in (1.0, -1.0)
    )
    across = [i for i, (a, b) in enumerate(zip(ahead, behind, strict=True)) if a != b]
    level = L.switches(q, v, t)[k]
    largest_change = max(abs(L.switches(*_split(x + step))[k] - level) for step in steps)
    is_on_surface = abs(level) <= 1e-12 * largest_change
    return is_on_surface and any(_jump(L, x, steps[i] / sizes[i], sizes[i]) for i in across)


def _sizes(x: Array) -> Array:
    """|x| of each component; for a component 0 the largest of all, or 1 if all are 0."""
    size = np.abs(x)
    return np.where(size > 0.0, size, np.max(size) or 1.0)


def _jump(L: Any, x: Array, along: Array, size: float) -> str:
    """The discontinuity of L across x along a direction, in words; '' for none."""
    gaps, scales = [], []
    for distance in (FAR_FROM_SURFACE * size, NEAR_SURFACE * size):
        sides = [_one_sided(L, x, sign * distance * along, distance) for sign in (1.0, -1.0)]
        gaps.append([np.abs(a - b) for a, b in zip(*sides, strict=True)])
        scales.append([np.abs(a) + np.abs(b) for a, b in zip(*sides, strict=True)])
    for name, distant_gap, close_gap, scale in zip(JUMP_NAMES, *gaps, scales[1], strict=True):
        if np.any(
            (close_gap > PERSISTENT_FRACTION * distant_gap)
            & (close_gap > DIFFERENCE_NOISE * np.max(scale, initial=1e-300))
        ):
            return name
    distant_size, close_size = (float(np.max(scale[2])) for scale in scales)
    return (
        "second derivatives have no bound"
        if close_size > UNBOUNDED_GROWTH * distant_size + DIFFERENCE_NOISE
        else ""
    )


def _one_sided(L: Any, x: Array, offset: Array, distance: float) -> list[Array]:
    """L, its first derivatives and their change along the direction, at a distance from x."""
    close, distant = _split(x + offset), _split(x + 2.0 * offset)
    slopes = L.slopes(*close)
    direction_sign = 1.0 if np.sum(offset) >= 0.0 else -1.0
    return [
        np.array([L(*close)]),
        slopes,
        direction_sign * (L.slopes(*distant) - slopes) / distance,
    ]


def _sign(L: Any, k: int, x: Array) -> float:
    """1 if the expression of surface k is positive at x, 0 if it is NaN, else -1."""
    value = L.switches(*_split(x))[k]
    return 0.0 if np.isnan(value) else (1.0 if value > 0.0 else -1.0)


def _split(x: Array) -> tuple[Array, Array, float]:
    d = x.size // 2
    return x[:d], x[d : 2 * d], float(x[-1])
