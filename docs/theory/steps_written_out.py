"""Steps as the theory pages write them, in NumPy; a test compares them with galvi.

c, b (s,) nodes and weights of a rule on [0, 1]; psi (s, m) the functions of a space beyond the
constant, which vanish at 0, at the nodes, slope (s, m) their derivatives there, end (m,) at 1.
"""

import numpy as np
from numpy.polynomial import legendre
from scipy.optimize import root

TINY, PASSES = 1e-100, 60


def vector_step(b, basis, a, q, v, h):
    """q and v after a step of q'' = a(q), (s, d) at the stages, and the coefficients x (m, d)."""
    psi, slope, end = basis
    K = slope.T @ (b[:, None] * slope)
    C = np.linalg.solve(K, (end[:, None] - psi.T) * b)
    line = np.outer(np.linalg.solve(K, end), h * v)
    x = line
    for _ in range(PASSES):
        x = line + h * h * C @ a(q + psi @ x)
    return q + end @ x, v + h * b @ a(q + psi @ x), x


def weak_step(b, functions, mass, force, u_0, p_0, h):
    """Coefficients (n, d) of u_N, and p_h, by M's iteration of M (8); F = force(u, u'), (s, d).

    functions  of X_N: values and slopes (s, n) at the nodes, values (n,) at 0 and at 1
    """
    values, slopes, start, end = functions
    a_N = mass / h * slopes.T @ (b[:, None] * slopes)
    saddle = np.block([[a_N, -end[:, None]], [start, 0.0]])
    u, rate = np.tile(u_0, (b.size, 1)), np.zeros((b.size, u_0.size))
    for _ in range(PASSES):
        impulse = h * values.T @ (b[:, None] * force(u, rate)) - np.outer(start, p_0)
        x = np.linalg.solve(saddle, np.vstack([impulse, u_0]))
        u, rate = values @ x[:-1], slopes @ x[:-1] / h
    return x[:-1], x[-1]


def tangent(x):
    """T of Phi(x) = (I - X)(I + X)^-1."""
    return -2.0 * (np.eye(3) + hat(x)) / (1.0 + x @ x)


def group_step(b, basis, J, torque, R, mu, h):
    """R and mu after a step of a body with L = w.J w / 2 - V(R), and the coefficients x (m, 3)."""
    psi, slope, end = basis

    def carried(x):
        """R_k^T R_(k+1) and the residual of the stage equations, (m, 3)."""
        shape = x.reshape(-1, 3)
        kick, residual = np.zeros(3), np.zeros(shape.shape)
        for j, weight in enumerate(b):
            xi, rate = psi[j] @ shape, slope[j] @ shape / h
            T, turned = tangent(xi), cayley(xi)
            w, tau = T @ rate, torque(R @ turned)
            pi = T.T @ J @ w
            f = -2.0 * (np.cross(rate, J @ w) + (w @ J @ w) * xi) / (1.0 + xi @ xi) + T.T @ tau
            kick += h * weight * turned @ tau
            residual += weight * (h * np.outer(psi[j], f) + np.outer(slope[j], pi))
        ahead = cayley(end @ shape)
        after = ahead.T @ (mu + kick)
        return ahead, after, residual - np.outer(end, tangent(end @ shape).T @ after)

    w = np.linalg.solve(J, mu)
    line = np.linalg.solve(slope.T @ (b[:, None] * slope), end)
    solution = root(lambda x: carried(x)[2].ravel(), np.outer(line, -0.5 * h * w), tol=1e-15)
    ahead, after, _ = carried(solution.x)
    return R @ ahead, after, solution.x.reshape(-1, 3)


def hat(x):
    """hat(x) y = x cross y."""
    return np.cross(np.eye(3), x)


def cayley(x):
    """Phi(x)."""
    return (np.eye(3) - hat(x)) @ np.linalg.inv(np.eye(3) + hat(x))


def frame_step(rule, flow, perturbation, w, h):
    """A step in the frame of a flow, from w = (x, x'), (2, n), at its start to its end.

    flow(w, t) is analytic; perturbation(x) are the accelerations that it leaves.
    """
    c, b = rule
    A = collocation(c)
    w, k = flow(w, 0.5 * h), np.zeros((c.size, *w.shape))
    for _ in range(PASSES):
        stages = zip(w + np.tensordot(A, k, 1), (c - 0.5) * h, strict=True)
        k = np.stack([h * pulled_back(flow, perturbation, W, t) for W, t in stages])
    return flow(w + np.tensordot(b, k, 1), 0.5 * h)


def pulled_back(flow, perturbation, W, t):
    """D phi_-t(Z) (0, perturbation), Z = phi_t(W), by a complex step."""
    x, rate = flow(W, t)
    return np.imag(flow(np.stack([x, rate + 1j * TINY * perturbation(x)]), -t)) / TINY


def collocation(c):
    """A_jl, the integral from 0 to c_j of the polynomial that is 1 at c_l, 0 at other nodes."""
    of_nodes = np.linalg.inv(legendre.legvander(2.0 * c - 1.0, c.size - 1))
    up = [legendre.legint(column, scl=0.5, lbnd=-1.0) for column in of_nodes.T]
    return np.stack([legendre.legval(2.0 * c - 1.0, primitive) for primitive in up], axis=1)


def orbit(mu, w, t):
    """Kepler's motion of w = (Q, V), (2, D), by the change of the eccentric anomaly."""
    Q, V = w
    r = np.sqrt(Q @ Q)
    axis = 1.0 / (2.0 / r - V @ V / mu)
    n, e_cos, e_sin = np.sqrt(mu / axis**3), 1.0 - r / axis, Q @ V / np.sqrt(mu * axis)
    E = n * t
    for _ in range(PASSES):
        gap = E - e_cos * np.sin(E) + e_sin * (1.0 - np.cos(E)) - n * t
        E = E - gap / (1.0 - e_cos * np.cos(E) + e_sin * np.sin(E))
    r1 = axis * (1.0 - e_cos * np.cos(E) + e_sin * np.sin(E))
    f, g = 1.0 - axis / r * (1.0 - np.cos(E)), t - (E - np.sin(E)) / n
    fall, grow = -np.sqrt(mu * axis) / (r * r1) * np.sin(E), 1.0 - axis / r1 * (1.0 - np.cos(E))
    return np.stack([f * Q + g * V, fall * Q + grow * V])


def kepler_frame(m):
    """Flow and perturbation of planets 1, 2, .. about a star 0, and their Jacobi coordinates.

    Rows of (Q_1, .., Q_n, barycentre), each (D,), are the matrix returned times those of bodies.
    """
    total = np.cumsum(m)
    centres = np.tril(np.tile(m, (m.size, 1))) / total[:, None]  # of bodies 0 to i
    into = np.vstack([np.eye(m.size)[1:] - centres[:-1], centres[-1]])

    def flow(w, t):
        moved = [orbit(mu, w[:, i], t) for i, mu in enumerate(total[1:])]
        return np.stack([*moved, np.stack([w[0, -1] + t * w[1, -1], w[1, -1]])], axis=1)

    def perturbation(Q):
        x = np.linalg.solve(into, Q)
        gap = x[None] - x[:, None]
        cube = np.sum(gap * gap, axis=2) + np.eye(m.size)
        pull = into @ np.einsum("j,kjd->kd", m, gap / cube[..., None] ** 1.5)
        held = total[1:, None] * Q[:-1] / np.sum(Q[:-1] ** 2, axis=1)[:, None] ** 1.5
        return pull + np.vstack([held, np.zeros(Q.shape[1])])

    return flow, perturbation, into
