"""H's formulas of 3.4 for the free body in coordinates, as printed, and the same from matrices.

xi, rate  coordinates of Phi(xi) = (I - X)(I + X)^-1, X = hat(xi), and their time derivatives, (3,)
          or (..., 3), where a, b, c are axes 1, 2, 3; complex ones, too, for derivatives
moments   I_1, I_2, I_3 of J = tr(J_d) I - J_d, (3,)
"""

from __future__ import annotations

from benchmarks.claims.kit import *
from references.textbook.galerkin import cayley, hat, vector

AS_PRINTED, IN_ORDER = (2, 1, 0), (0, 1, 2)  # the phi that I_1, I_2, I_3 multiply
TINY = 1e-200  # of a complex step


def phi(xi: Array, rate: Array) -> Array:
    """phi(xi_a, xi_b, xi_c), phi(xi_b, xi_c, xi_a), phi(xi_c, xi_a, xi_b), (..., 3)."""
    (a, b, c), (a1, b1, c1) = np.moveaxis(xi, -1, 0), np.moveaxis(rate, -1, 0)
    return np.stack([a1 + b * c1 - c * b1, b1 + c * a1 - a * c1, c1 + a * b1 - b * a1], axis=-1)


def lagrangian(moments: Array, xi: Array, rate: Array, pairs: tuple[int, ...] = IN_ORDER) -> Array:
    """(3.50) in coordinates, I_i with the phi of `pairs`."""
    size = 1.0 + np.sum(xi * xi, axis=-1)
    squares = phi(xi, rate)[..., pairs] ** 2
    return 2.0 / size**2 * np.sum(moments * squares, axis=-1)


def trace_lagrangian(J_d: Array, xi: Array, rate: Array) -> float:
    """(3.32): tr(R'^T R J_d R^T R')."""
    R, turning = cayley(xi), matrix_rate(xi, rate)
    return float(np.trace(turning.T @ R @ J_d @ R.T @ turning))


def kinetic_energy(moments: Array, xi: Array, rate: Array) -> float:
    """w . J w / 2, hat(w) = R^T R'."""
    w = vector(cayley(xi).T @ matrix_rate(xi, rate))
    return float(0.5 * np.sum(moments * w * w))


def matrix_rate(xi: Array, rate: Array) -> Array:
    """R' of R (I + X) = I - X: -(I + R) X' (I + X)^-1."""
    unit = np.eye(3)
    return -(unit + cayley(xi)) @ hat(rate) @ np.linalg.inv(unit + hat(xi))


def stage_terms(moments: Array, xi: Array, rate: Array, value: Array, slope: Array) -> Array:
    """(3.51) without the sum over j, (..., 3): its terms for phi_i = value, phi_i' = slope, each a
    number or with more leading axes than xi.

    The text at hand has lost the dots, and lines of (3.51b, c): with the dots of (3.51a), and the
    others by the exchange a -> b -> c -> a.
    """
    I, p = moments, phi(xi, rate)
    size = 1.0 + np.sum(xi * xi, axis=-1)
    found = []
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        shared = -2.0 / size * xi[..., a] * value
        third = I[c] * p[..., c] * (shared * p[..., c] + rate[..., b] * value - xi[..., b] * slope)
        second = I[b] * p[..., b] * (shared * p[..., b] + xi[..., c] * slope - rate[..., c] * value)
        first = I[a] * p[..., a] * (shared * p[..., a] + slope)
        found.append(4.0 / size**2 * (third + second + first))
    return np.stack(found, axis=-1)


def composed(first: Array, xi: Array) -> Array:
    """lambda of 3.4.3, Phi(lambda) = Phi(xi^0) Phi(xi), (3,)."""
    (a0, b0, c0), (a, b, c) = first, xi
    above = [-a - a0 + c * b0 - b * c0, -b - b0 + a * c0 - c * a0, -c - c0 + b * a0 - a * b0]
    return np.array(above) / (-1.0 + a0 * a + b0 * b + c0 * c)


def relative(first: Array, point: Array) -> Array:
    """xi_k of 3.4.3, Phi(xi_k) = Phi(xi^0)^-1 Phi(lambda), (3,)."""
    (a0, b0, c0), (a, b, c) = first, point
    above = [a - a0 + c * b0 - b * c0, b - b0 + a * c0 - c * a0, c - c0 + b * a0 - a * b0]
    return np.array(above) / (1.0 + a * a0 + b * b0 + c * c0)


def change_of_chart(first: Array, point: Array) -> Array:
    """d xi_k / d lambda of `relative`, (3, 3), by complex steps."""
    return gradient(lambda e: relative(first, point + e)).T


def gradient(function: Callable[[Array], Any]) -> Array:
    """The derivatives at 0 by x (3,), (3, ...), by complex steps."""
    return np.array([np.imag(function(1j * TINY * e)) / TINY for e in np.eye(3)])


def changed_slope(slope: Array, change: Array, printed: bool) -> Array:
    """dL_d / dlambda, (3,), of dL_d / dxi_k and d xi_k / d lambda (3, 3); in the last component as
    printed dL_d / dxi_c stands for dL_d / dxi_b."""
    result: Array = slope @ change
    if printed:
        result[2] += (slope[2] - slope[1]) * change[1, 2]
    return result


def inverse_cayley(R: Array) -> Array:
    """xi of R = Phi(xi), (3,): Cayley's transform once more."""
    return vector((np.eye(3) - R) @ np.linalg.inv(np.eye(3) + R))


def lagrangian_of(problem: Problem) -> Callable[[Array, Array], Any]:
    """w . J w / 2 - V, analytic in both, of a rigid body, V its weight's."""
    weight = problem.system.potential

    def value(R: Array, w: Array) -> Any:
        twice = w @ problem.system.inertia @ w
        fall = weight.mass * (weight.g @ R @ weight.centre) if weight is not None else 0.0
        return 0.5 * twice + fall

    return value
