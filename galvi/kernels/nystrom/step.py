"""The parts of one step that never call a user's function.

d components, s stages, m curve coefficients; notation of galvi.tableau. Rows are components.

state    (4, d)  q, its low part, v, its low part (the rounding errors of q and v)
tableau  a ``NystromTableau``
a        (d, s)  accelerations at the stages
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import types

from galvi.kernels.compile.jit import jit, jit_inline
from galvi.kernels.constants import EPSILON
from galvi.kernels.lie.arithmetic import two_sum

NUMBERS, INDICES = types.CPointer(types.float64), types.CPointer(types.int64)
INTEGER = types.intp
SIGNATURE = types.intc(
    types.char,
    INTEGER,
    INTEGER,
    NUMBERS,
    INTEGER,
    INDICES,
    NUMBERS,
    INTEGER,
)
DGESV: Any = types.ExternalFunction("numba_xgesv", SIGNATURE)  # numba's name of LAPACK's function
DOUBLE = ord("d")


@jit
def solve_equations(columns, pivots, solution):
    """Solve linear equations by LAPACK, in place; returns False for a singular matrix.

    ``np.linalg.solve`` calls the same function, but the messages of its checks would take a third
    of the time to compile the kernel.

    Parameters
    ----------
    columns : array, shape (n, n)
        columns of the matrix, as rows; overwritten
    pivots : array, shape (n,)
        scratch of int64, of which LAPACK's integers may use half
    solution : array, shape (n,)
        right side; replaced by the solution, which is not finite if the right side is not
    """
    n = solution.size
    return DGESV(DOUBLE, n, 1, columns.ctypes, n, pivots.ctypes, solution.ctypes, n) == 0


SPLIT_FACTOR = 134217729.0  # 2^27 + 1, Dekker's splitting of a double


class NystromTableau(NamedTuple):
    """A `galvi.tableau.Tableau` for kernels: matrices are transposed, C in both forms.

    c, b, beta, b_low, beta_low (s,), A (s, s), psi (m, s), velocity_coefficients (m,), C (m, s),
    C_transposed (s, m), analysis (s, s), extrapolation (l, s), growth (l,), psi_low (m, s),
    C_low (m, s), velocity_coefficients_low (m,), c_low (s,)

    b + b_low is exact, and beta + beta_low is (b + b_low) (1 - c) with the rounded c of the stages,
    as rotations require. Without low parts the angular momentum of H's orbit (V8) grows by 3.8e-17
    a step, of which the rounding of b causes 2.2e-17, of beta 0.7e-17, of c 0.5e-17 and of A less
    than 0.1e-17.
    """

    c: Any
    b: Any
    beta: Any
    b_low: Any
    beta_low: Any
    A: Any
    psi: Any
    velocity_coefficients: Any
    C: Any
    C_transposed: Any
    analysis: Any
    extrapolation: Any
    growth: Any
    psi_low: Any
    C_low: Any
    velocity_coefficients_low: Any
    c_low: Any


FIXED_VECTOR, FIXED_MATRIX = (types.Array(types.float64, n, "C", readonly=True) for n in (1, 2))
TABLEAU = types.Tuple(
    (FIXED_VECTOR,) * 5
    + (FIXED_MATRIX,) * 2
    + (FIXED_VECTOR,)
    + (FIXED_MATRIX,) * 4
    + (FIXED_VECTOR,)
    + (FIXED_MATRIX,) * 2
    + (FIXED_VECTOR,) * 2
)


@jit_inline
def terms_to_extrapolate(sizes, growth):
    """Number of terms of a Legendre series to extrapolate by a step, where they grow by ``growth``.

    Parameters
    ----------
    sizes : array, shape (s,)
        magnitudes of the coefficients
    growth : array, shape (l,)
        l at most s

    Notes
    -----
    Truncation costs the next two terms, keeping terms costs their round-off; a term that outgrows
    the whole series marks the limit of extrapolation.
    """
    s = growth.size
    largest = 0.0
    for l in range(sizes.size):
        largest = max(largest, sizes[l])
    best, terms = np.inf, 1
    for count in range(1, s + 1):
        if count > 1 and sizes[count - 1] * growth[count - 1] > 4.0 * largest:
            break
        cost = EPSILON * largest * growth[count - 1]
        for l in range(min(count, s - 2), min(count + 2, s)):
            cost = max(cost, sizes[l] * growth[l])
        if cost <= best:
            best, terms = cost, count
    return terms


@jit
def predict(tableau, a, guess):
    """Extrapolate the last step's accelerations to this step's stages.

    Each row's Legendre series is truncated where the estimated error is least.
    """
    analysis, extrapolation, growth = tableau.analysis, tableau.extrapolation, tableau.growth
    d, s = a.shape
    sizes = np.empty(s)
    for i in range(d):
        series = np.zeros(s)
        for j in range(s):
            for l in range(s):
                series[l] += analysis[j, l] * a[i, j]
        for l in range(s):
            sizes[l] = abs(series[l])
        terms = terms_to_extrapolate(sizes, growth)
        for k in range(s):
            guess[i, k] = 0.0
        for l in range(terms):
            for k in range(s):
                guess[i, k] += extrapolation[l, k] * series[l]


@jit_inline
def place_stages(tableau, h, state, a, Q):
    """Q_k = q + c_k h v + h^2 sum_j A_kj a_j."""
    c, A = tableau.c, tableau.A
    d, s = Q.shape
    for i in range(d):
        for k in range(s):
            Q[i, k] = 0.0
        for j in range(s):
            for k in range(s):
                Q[i, k] += A[j, k] * a[i, j]
        drift = h * state[2, i] + h * state[3, i]
        for k in range(s):
            Q[i, k] = state[0, i] + (state[1, i] + (c[k] * drift + h * h * Q[i, k]))


@jit_inline
def largest_change(Q, moved, scale):
    """max |moved - Q| / scale, or NaN if ``moved`` is not finite; Q is set to ``moved``.

    If the scale is 0, as at rest at the origin, changes are relative to the position itself.
    """
    change, absolute_sum = 0.0, 0.0
    for i in range(Q.shape[0]):
        for k in range(Q.shape[1]):
            size = scale[i] if scale[i] > 0.0 else abs(moved[i, k])
            if size > 0.0:
                change = max(change, abs(moved[i, k] - Q[i, k]) / size)
            absolute_sum += abs(moved[i, k])
            Q[i, k] = moved[i, k]
    return change if absolute_sum < np.inf else np.nan


@jit_inline
def measure_scale(h, width, state, scale):
    """scale_i <- the largest |q| or |q + h v| in the Newton block of component i."""
    for first in range(0, scale.size, width):
        size = 0.0
        for i in range(first, first + width):
            size = max(size, abs(state[0, i]), abs(state[0, i] + h * state[2, i]))
        for i in range(first, first + width):
            scale[i] = size


@jit_inline
def exact_coefficients(tableau, h, state, a, x):
    """`curve_coefficients` with an error of about half an ulp."""
    line, line_low = tableau.velocity_coefficients, tableau.velocity_coefficients_low
    C, C_low = tableau.C, tableau.C_low
    for i in range(a.shape[0]):
        for l in range(x.shape[1]):
            total, low = 0.0, 0.0
            for j in range(a.shape[1]):
                total, error = two_sum(total, C[l, j] * a[i, j])
                low += error + C_low[l, j] * a[i, j]
            coefficient, error = two_sum(h * h * total, h * state[2, i] * line[l])
            low = h * h * low + h * (state[3, i] * line[l] + state[2, i] * line_low[l])
            x[i, l] = coefficient + (error + low)


@jit_inline
def curve_coefficients(tableau, h, state, a, x):
    """x (d, m) <- h v velocity_coefficients + h^2 C a."""
    velocity_coefficients, C = tableau.velocity_coefficients, tableau.C_transposed
    for i in range(a.shape[0]):
        for l in range(x.shape[1]):
            x[i, l] = 0.0
        for j in range(a.shape[1]):
            for l in range(x.shape[1]):
                x[i, l] += C[j, l] * a[i, j]
        for l in range(x.shape[1]):
            x[i, l] = h * state[2, i] * velocity_coefficients[l] + h * h * x[i, l]


@jit
def newton_update(tableau, h, width, state, a, jacobian, x, Q):
    """One Newton correction of the coefficients x (d, m) block by block, and the new stages Q.

    Returns False if the equations are singular or not finite. The residual is
    r = x - h v velocity_coefficients - h^2 C a(q + psi x), its derivative
    I - h^2 C diag_j(da_j) psi. Stages are those of the rounded c. Sums include the low parts of psi
    and C and err by half an ulp; without low parts the angular momentum of H's orbit (V8) falls by
    7.3e-17 of itself a step.
    """
    psi, psi_low, C = tableau.psi, tableau.psi_low, tableau.C
    d, m = x.shape
    stages = Q.shape[1]
    size = width * m
    residual = np.empty((d, m))
    exact_coefficients(tableau, h, state, a, residual)
    columns, pivots, step = np.empty((size, size)), np.empty(size, np.int64), np.empty(size)
    for first in range(0, d, width):
        for i in range(width):
            for l in range(m):
                row = i * m + l
                step[row] = residual[first + i, l] - x[first + i, l]
                for j in range(width):
                    for n in range(m):
                        total = 0.0
                        for k in range(stages):
                            total += C[l, k] * jacobian[first + i, j, k] * psi[n, k]
                        columns[j * m + n, row] = -h * h * total
                columns[row, row] += 1.0
        if not (all_finite(columns) and solve_equations(columns, pivots, step)):
            return False
        for i in range(width):
            for l in range(m):
                x[first + i, l] += step[i * m + l]
    for i in range(d):
        for k in range(stages):
            total, low = state[0, i], state[1, i] - tableau.c_low[k] * (h * state[2, i])
            for l in range(m):
                total, error = two_sum(total, psi[l, k] * x[i, l])
                low += error + psi_low[l, k] * x[i, l]
            Q[i, k] = total + low
    return True


@jit_inline
def copy_into(target, source):
    """target <- source, (d, s)."""
    for i in range(source.shape[0]):
        for k in range(source.shape[1]):
            target[i, k] = source[i, k]


@jit_inline
def all_finite(values):
    """Whether every entry of (d, s) is finite."""
    absolute_sum = 0.0
    for i in range(values.shape[0]):
        for k in range(values.shape[1]):
            absolute_sum += abs(values[i, k])
    return absolute_sum < np.inf


@jit_inline
def two_product(x, y):
    """The rounded product of x and y and its error, x y = product + error (Dekker)."""
    product = x * y
    x_high = SPLIT_FACTOR * x - (SPLIT_FACTOR * x - x)
    y_high = SPLIT_FACTOR * y - (SPLIT_FACTOR * y - y)
    x_low, y_low = x - x_high, y - y_high
    error = ((x_high * y_high - product) + x_high * y_low + x_low * y_high) + x_low * y_low
    return product, error


@jit_inline
def complete_step(tableau, h, a, state):
    """q += h v + h^2 sum_j beta_j a_j,  v += h sum_j b_j a_j, with compensated summation."""
    b, beta, b_low, beta_low = tableau.b, tableau.beta, tableau.b_low, tableau.beta_low
    for i in range(a.shape[0]):
        kick_sum, bend_sum, kick_low, bend_low = 0.0, 0.0, 0.0, 0.0
        for j in range(a.shape[1]):
            kick_sum += b[j] * a[i, j]
            bend_sum += beta[j] * a[i, j]
            kick_low += b_low[j] * a[i, j]
            bend_low += beta_low[j] * a[i, j]
        q, q_low, v, v_low = state[0, i], state[1, i], state[2, i], state[3, i]
        drift, drift_low = two_product(h, v)
        moved, moved_low = two_sum(q, drift)
        low = moved_low + (q_low + (drift_low + (h * v_low + h * h * bend_low)))
        moved, moved_low = two_sum(moved, h * h * bend_sum)
        state[0, i], state[1, i] = two_sum(moved, moved_low + low)
        kicked, kicked_low = two_sum(v, h * kick_sum)
        state[2, i], state[3, i] = two_sum(kicked, kicked_low + (v_low + h * kick_low))
