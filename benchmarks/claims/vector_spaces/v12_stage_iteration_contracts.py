"""V12: H's iteration for the stages contracts (H theorem 2.3.1, lemmas 2.3.1 and 2.3.2)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.checks import bounds
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.measures.independent_space import (
    gauss_points,
    lagrange_at_chebyshev,
    slopes,
    values,
)
from benchmarks.store.frames import frame, pick, row
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

    With m = k = 1 the pass w -> A^-1 f(w) is linear; what multiplies w is h^2 D, the same at any h.
    Row 0 of A is the start, rows 1 to n - 1 test with all basis functions but the last.
    """
    rows = []
    for n in NS:
        report(f"n = {n}")
        method = make_method(galvi.Polynomials(n - 1), galvi.gauss(2 * n))
        rows += [row(study=STUDY, quantity=quantity, n=n, value=value)
                 for quantity, value in _numbers(method, n).items()]  # fmt: skip
    return frame(rows)


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
    """What multiplies nodal values in the method's own pass, of its table, over -h^2 k / m.

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
    """The lemmas, the theorem's bound, and what the iteration does."""
    singular, grown = _of(table, SINGULAR), _of(table, GROWN)
    ratio = _of(table, LIMIT) / _of(table, BOUND)
    shown = [(n, _number(table, LIMIT, n) / _number(table, BOUND, n)) for n in SHOWN]
    spectral = [(n, _number(table, SPECTRAL, n) / _number(table, BOUND, n)) for n in SHOWN]
    agree, said = _of(table, PASS), abs(_of(table, SAID) - 1.0)
    return [
        _row("least singular value of A_1 over all n", "lemma 2.3.1", "A is invertible",
             "above 1e-6", _least(singular), bounds.HOLDS,
             "Testing with all but the last function leaves no polynomial but 0.",
             bounds.within(_least(singular), 1e-6, np.inf)),
        _row("largest |A^-1| at h < 1 over |A_1^-1|, all n", "lemma 2.3.2",
             "|A^-1| at h < 1 is below |A_1^-1|", "below 1", _most(grown), bounds.HOLDS,
             "All columns of A^-1 but the first have a factor h.",
             bounds.within(_most(grown), 0.0, 1.0)),
        _row("least of measured limit / bound, all n", "thm. 2.3.1", "contracts below the bound",
             "at least 1", _least(ratio), bounds.HOLDS, "Each of the estimates is a safe one.",
             bounds.within(_least(ratio), 1.0, np.inf)),
        *(
            _row(f"measured limit / bound, n = {n}", "thm. 2.3.1", "contracts below the bound",
                 "at least 1", value, bounds.HOLDS,
                 "Sums of |phi_i| and of the rows of A^-1 are bounded apart, and one of the two "
                 "factors h is given away.", bounds.within(value, 1.0, np.inf))
            for n, value in shown
        ),
        *(
            _row(f"measured limit in any norm / bound, n = {n}", "thm. 2.3.1",
                 "contracts below the bound", "at least 1", value, bounds.HOLDS,
                 "Passes converge as long as the spectral radius is below 1, farther than one "
                 "norm tells.", bounds.within(value, 1.0, np.inf))
            for n, value in spectral
        ),
        _row("galvi's pass against H's, largest relative difference, all n", "(2.5)",
             "q = A^-1 f(q), with the force in f's last row that H's print lacks",
             f"at most {ROUND_OFF:g}", _most(agree), bounds.HOLDS,
             "The tableau is the same iteration, its coefficients eliminated.",
             bounds.bound(_most(agree), ROUND_OFF)),
        _row("galvi.theory's bound over H's formula, largest departure from 1, all n",
             "thm. 2.3.1", "the bound as printed, h at most 1", f"at most {ROUND_OFF:g}",
             _most(said), bounds.HOLDS, "The same formula, from another basis.",
             bounds.bound(_most(said), ROUND_OFF)),
    ]  # fmt: skip


def _of(table: pd.DataFrame, quantity: str) -> Array:
    return pick(table, study=STUDY, quantity=quantity).sort_values("n")["value"].to_numpy(float)


def _number(table: pd.DataFrame, quantity: str, n: int) -> float:
    found = pick(table, study=STUDY, quantity=quantity, n=n)["value"]
    return float(found.iloc[0]) if len(found) else float("nan")


def _least(values: Array) -> float:
    return float(values.min()) if values.size else float("nan")


def _most(values: Array) -> float:
    return float(values.max()) if values.size else float("nan")


def _row(
    quantity: str, source: str, claimed: str, bound: str, measured: float, expected: str,
    reason: str, verdict: str,
) -> Row:  # fmt: skip
    return Row(
        id="V12",
        quantity=quantity,
        source=f"H {source}",
        setup=f"oscillator, m = k = 1; Lagrange basis on {NS[0]} to {NS[-1]} Chebyshev points, "
        "test rows 1 .. n - 1, as H's proofs have them, where (2.8) prints 2 .. n; Gauss 2 n; "
        "norms of the largest row sum",
        claimed=claimed,
        bound=bound,
        measured=measured,
        uncertainty=None,
        expected=expected,
        reason=reason,
        reference="H's matrices, by numpy",
        verdict=verdict,
    )


V12 = Claim("V12", "The stage equations have one solution below a step", study, judge)
