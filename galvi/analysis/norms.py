"""The constants that compare a rule's norms on a space with the exact ones (M section 4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from galvi.analysis.friedrichs import Z0
from galvi.arrays import Array
from galvi.rules.gauss import gauss
from galvi.rules.rule import Rule
from galvi.spaces.space import Space

FINE = 64  # Gauss points on each part of a step for M's exact integrals: degree 127
PARTS = 4  # parts of each smooth piece
DEPENDENT = 1e11  # condition number of a normalised basis above which constants are not known
BLIND = 1e-12  # eigenvalues below this share of the largest count as 0


@dataclass(frozen=True)
class Norms:
    """Constants of the norm |u|_X^2 = integral of |u'|^2 + |u(h)|^2 / h on a step of length h.

    A subscript N marks the same norm with the integral by the rule.

    unseen    number of independent functions with |u|_{X,N} = 0; 0 iff well posed (M lemma 1)
    C         C_N, the least constant with |u|_{0,N} <= C_N (h / z0) |u|_{X,N} (M 11)
    lowest    lambda_N, least |u|_{X,N} / |u|_X (M 12)
    highest   Lambda_N, largest |u|_{X,N} / |u|_X (M 12)
    seminorm  (least, largest) of |u'|_{0,N} / |u'|_0 (M section 5; claim V21)

    C is infinite for an ill-posed pair. None depends on h.
    """

    unseen: int
    C: float
    lowest: float
    highest: float
    seminorm: tuple[float, float]


@lru_cache(maxsize=128)
def norms(space: Space, rule: Rule) -> Norms | None:
    """The constants of a space and a rule; with one degree per component, the worst of them.

    None when the basis functions are too nearly dependent for float64.
    """
    degrees: Sequence[int] = getattr(space, "degrees", (space.dimension - 1,))
    known = [_norms(space, rule, degree + 1) for degree in sorted(set(degrees))]
    found = [one for one in known if one is not None]
    if len(found) < len(known):
        return None
    return Norms(
        max(one.unseen for one in found),
        max(one.C for one in found),
        min(one.lowest for one in found),
        max(one.highest for one in found),
        (min(one.seminorm[0] for one in found), max(one.seminorm[1] for one in found)),
    )


def _norms(space: Space, rule: Rule, functions: int) -> Norms | None:
    """The constants for the span of the first ``functions`` basis functions."""
    from scipy.linalg import eigh  # with SciPy's other parts, a quarter of galvi's import

    fine = _fine(getattr(space, "pieces", 1))
    phi, end = (space.basis(t)[:, :functions] for t in (rule.nodes, np.ones(1)))
    slope, true = (space.derivative(t)[:, :functions] for t in (rule.nodes, fine[0]))
    last = end.T @ end
    exact_slope = true.T @ (fine[1][:, None] * true)
    exact, size = _scaled(exact_slope + last)
    if not np.linalg.cond(exact) < DEPENDENT:
        return None
    seen_slope = slope.T @ (rule.weights[:, None] * slope) / size
    seen = seen_slope + last / size
    values = phi.T @ (rule.weights[:, None] * phi) / size
    ratios = eigh(seen, exact, eigvals_only=True)
    rates = eigh(seen_slope[1:, 1:], exact_slope[1:, 1:] / size[1:, 1:], eigvals_only=True)
    unseen = int(np.sum(ratios <= BLIND * ratios[-1]))
    C = Z0 * np.sqrt(eigh(values, seen, eigvals_only=True)[-1]) if not unseen else np.inf
    low, high, least, most = np.sqrt(np.clip([ratios[0], ratios[-1], rates[0], rates[-1]], 0, None))
    if unseen:
        low = least = 0.0
    return Norms(unseen, float(C), float(low), float(high), (float(least), float(most)))


def _scaled(gram: Array) -> tuple[Array, Array]:
    """The Gram matrix of functions of norm 1, and the products of their norms."""
    norm = np.sqrt(np.diagonal(gram))
    size = np.outer(norm, norm)
    return gram / size, size


def _fine(pieces: int) -> tuple[Array, Array]:
    """Nodes and weights of Gauss's rule on every part of every piece of [0, 1]."""
    one, parts = gauss(FINE), pieces * PARTS
    nodes = (np.arange(parts)[:, None] + one.nodes) / parts
    return nodes.ravel(), np.tile(one.weights / parts, parts)
