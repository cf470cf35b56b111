"""What the modified equations of the three Euler methods say of the energy, to first order in h.

For q'' = a(q) the solution of a method of order 1 is, up to h^2, that of q' = f + h g. With
E = K + V, m the masses and <x> the sum of m x over the bodies:

explicit    dE/dt = h/2 (<|a|^2> - <v . a'(q) v>), so E(T) - E(0) = h (int <|a|^2> - [<v . a>] / 2)
implicit    the same with -h
symplectic  v' = v + h a(q), q' = q + h v': conserves E + h/2 <v . a> up to h^2

(integrating by parts: d/dt <v . a> = <|a|^2> + <v . a'(q) v>).
"""

from __future__ import annotations

from scipy.integrate import simpson

from benchmarks.claims.kit import *
from references.newton import acceleration


def work(run: Trajectory) -> tuple[Array, Array]:
    """<|a|^2> and <v . a> at each saved state, (k,), of bodies with masses."""
    a, masses = _accelerations(run.problem, run.q), run.problem.system.masses[:, None]
    v = run.problem.system.velocity(run.p)
    return np.sum(masses * a * a, axis=(1, 2)), np.sum(masses * v * a, axis=(1, 2))


def explicit_slope(truth: Trajectory) -> float:
    """(E(T) - E(0)) / h of explicit Euler for small h, from an evenly sampled exact motion."""
    square, power = work(truth)
    return float(simpson(square, x=truth.t) - 0.5 * (power[-1] - power[0]))


def symplectic_change(run: Trajectory, h: float) -> Array:
    """E - E(0) of a run of symplectic Euler up to h^2, from its own states: (k,)."""
    power = work(run)[1]
    return -0.5 * h * (power - power[0])


def _accelerations(problem: Problem, q: Array) -> Array:
    accelerated, rest = acceleration(problem), np.zeros(problem.v0.shape)
    return np.array([accelerated(place, rest, problem.t0) for place in q])
