"""V12: H's iteration for the stages contracts (H theorem 2.3.1, lemmas 2.3.1 and 2.3.2)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.checks.bounds import Above, AtLeast, AtMost, Below
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.measures.independent_space import (
    gauss_points,
    lagrange_at_chebyshev,
    slopes,
    values,
)
from benchmarks.statistics import readings
from benchmarks.store.frames import frame, number, rows
from galvi.arrays import Array

NS = (3, 4, 6, 8, 12, 16, 20)
SHOWN = (4, 8, 16)
SIZES = tuple(np.round(np.arange(0.05, 1.0, 0.05), 10).tolist())
SINGULAR, GROWN = "least singular value of A_1", "|A^-1| at h < 1, over that at 1"
LIMIT, BOUND = "step where the iteration stops to contract", "H's bound on the step"
SPECTRAL = "step where the iteration stops to converge"
PASS, SAID = "galvi's pass against H's, relative", "galvi.theory's bound over H's formula"
ROUND_OFF = 1e-10  # 8e-14 was measured
STUDY = "oscillator"


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """For each n: A_1 of H (2.6)-(2.8), and the contraction of one pass in nodal values.

    With m = k = 1 the pass w -> A^-1 f(w) is linear with the matrix h^2 D, D the same for any h.
    Row 0 of A is the initial value, rows 1 to n - 1 test with all basis functions but the last.
    """
    found = []
    for n in NS:
        report(f"n = {n}")
        method = make_method(galvi.Polynomials(n - 1), galvi.gauss(2 * n))
        found += rows(_numbers(method, n), study=STUDY, n=n)
    return frame(found)


def _numbers(method: Any, n: int) -> dict[str, float]:
    basis, (t, b) = lagrange_at_chebyshev(n - 1), gauss_points(2 * n)
    phi, dphi = values(basis, t), slopes(basis, t)
    stiff, mass = (dphi * b) @ dphi.T, (phi * b) @ phi.T
    A = _matrix(stiff, 1.0)
    inverse = np.linalg.inv(A)
    most = float(np.max(np.sum(abs(phi), axis=0) * np.max(abs(phi[:-1]), axis=0)))
    D = inverse @ np.vstack([np.zeros(n), mass[:-1]])
    limit = 1.0 / np.sqrt(np.linalg.norm(D, np.inf))
    bound = min(1.0, 1.0 / (_size(inverse) * most))
    grown = max(_size(np.linalg.inv(_matrix(stiff, h))) for h in SIZES) / _size(inverse)
    said = method.theory(galvi.problems.harmonic_oscillator(), lipschitz=1.0).stage_step
    return {
        SINGULAR: float(np.linalg.svd(A, compute_uv=False)[-1]),
        GROWN: float(grown),
        LIMIT: float(limit),
        SPECTRAL: float(np.max(abs(np.linalg.eigvals(D))) ** -0.5),
        BOUND: bound,
        PASS: float(np.max(abs(_pass_of(method) - D)) / np.max(abs(D))),
        SAID: float(said / bound),
    }


def _matrix(stiff: Array, h: float) -> Array:
    """A of H (2.6)-(2.8) on [0, h], from the Gram matrix of slopes on [0, 1]."""
    return np.vstack([np.eye(1, len(stiff)), stiff[:-1] / h])


def _pass_of(method: Any) -> Array:
    """The matrix of the method's own pass in nodal values, from its tableau, over -h^2 k / m.

    Q = psi x + q0 at the stages, a = -k Q / m, x = h^2 C a, and values at the nodes from x.
    """
    space, table = method.space, method.table
    nodes = space.basis(space.nodes)
    coefficients = np.linalg.inv(nodes)
    at_stages = coefficients[:1] + table.psi @ coefficients[1:]
    return -np.asarray((nodes[:, 1:] - nodes[:1, 1:]) @ table.C @ at_stages)


def _size(matrix: Array) -> float:
    return float(np.linalg.norm(matrix, np.inf))


def judge(table: pd.DataFrame) -> list[Row]:
    """Rows for the lemmas, the theorem's bound, and the iteration itself."""
    over_bound = _by_n(table, LIMIT) / _by_n(table, BOUND)
    return [
        V12.row(
            "least singular value of A_1 over all n",
            Above(1e-6),
            readings.least(_by_n(table, SINGULAR)),
            source="H lemma 2.3.1",
            claimed="A is invertible",
            reason="Testing with all but the last function leaves no polynomial but 0.",
        ),
        V12.row(
            "largest |A^-1| at h < 1 over |A_1^-1|, all n",
            Below(1.0),
            readings.largest(_by_n(table, GROWN)),
            source="H lemma 2.3.2",
            claimed="|A^-1| at h < 1 is below |A_1^-1|",
            reason="All columns of A^-1 but the first have a factor h.",
        ),
        V12.row(
            "least of measured limit / bound, all n",
            AtLeast(1.0),
            readings.least(over_bound),
            reason="Each of the estimates is a safe one.",
        ),
        *(
            V12.row(
                f"measured limit / bound, n = {n}",
                AtLeast(1.0),
                _over_bound(table, LIMIT, n),
                reason="Sums of |phi_i| and of the rows of A^-1 are bounded apart, and one of the "
                "two factors h is given away.",
            )
            for n in SHOWN
        ),
        *(
            V12.row(
                f"measured limit in any norm / bound, n = {n}",
                AtLeast(1.0),
                _over_bound(table, SPECTRAL, n),
                reason="Passes converge as long as the spectral radius is below 1, farther than "
                "one norm tells.",
            )
            for n in SHOWN
        ),
        V12.row(
            "galvi's pass against H's, largest relative difference, all n",
            AtMost(ROUND_OFF),
            readings.largest(_by_n(table, PASS)),
            source="H (2.5)",
            claimed="q = A^-1 f(q), with the force in f's last row that H's print lacks",
            reason="The tableau is the same iteration, its coefficients eliminated.",
        ),
        V12.row(
            "galvi.theory's bound over H's formula, largest departure from 1, all n",
            AtMost(ROUND_OFF),
            readings.largest(abs(_by_n(table, SAID) - 1.0)),
            claimed="the bound as printed, h at most 1",
            reason="The same formula, from another basis.",
        ),
    ]


def _by_n(table: pd.DataFrame, quantity: str) -> Array:
    return readings.values(table, "n", study=STUDY, quantity=quantity)


def _over_bound(table: pd.DataFrame, quantity: str, n: int) -> float:
    limit, bound = (number(table, study=STUDY, quantity=name, n=n) for name in (quantity, BOUND))
    return limit / bound


V12 = Claim(
    "V12",
    "The stage equations have one solution below a step",
    study,
    judge,
    source="H thm. 2.3.1",
    setup=f"oscillator, m = k = 1; Lagrange basis on {NS[0]} to {NS[-1]} Chebyshev points, test "
    "rows 1 .. n - 1, as H's proofs have them, where (2.8) prints 2 .. n; Gauss 2 n; norms of the "
    "largest row sum",
    claimed="contracts below the bound",
    reference="H's matrices, by numpy",
)
