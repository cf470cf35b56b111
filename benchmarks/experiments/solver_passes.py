"""Passes of alternative stage iterations: `python -m benchmarks.experiments.solver_passes`.

A pass is one evaluation of all accelerations at all stages. Passes are counted from the usual
first guess until the stages change by at most SETTLED of the distance from the origin, without
those over the fastest planet alone. docs/solver-experiments.md states the cost of a pass.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import galvi
from benchmarks.experiments.solver_ideas import PER_ORBIT, STAGES, STEPS
from benchmarks.measures.orbit_shape import period
from galvi import Problem
from galvi.arrays import Array
from galvi.spaces.polynomials import legendre

SETTLED, MOST = 4e-16, 40
TERMS = 7  # terms of the extrapolated Legendre series
SINGLE = 1e-5  # change above which a pass may be in single precision
Pass = Callable[[Array], Array]


def passes(problem: Problem) -> dict[str, float]:
    """Mean number of passes per step for each iteration."""
    method = galvi.Galerkin(galvi.Polynomials(STAGES), galvi.gauss(STAGES))
    h = period(problem, 1) / PER_ORBIT
    run = galvi.integrate(problem, method, h, STEPS)
    c, A = method.table.c, h**2 * method.table.A
    system: Any = problem.system
    ahead = legendre(2.0 * c + 1.0, TERMS - 1) @ np.linalg.pinv(legendre(2.0 * c - 1.0, TERMS - 1))
    counts: dict[str, list[float]] = {}
    for k in range(1, STEPS):
        q, v = run.q[k], problem.system.velocity(run.p[k])
        size = np.linalg.norm(q, axis=-1)[None, :, None]
        line = q + h * c[:, None, None] * v

        def stages(a: Array, line: Array = line) -> Array:
            return line + np.einsum("ij,jbx->ibx", A, a)

        def pull(Q: Array) -> Array:
            return np.stack([system.acceleration(x, 0.0) for x in Q])

        def full(Q: Array) -> Array:
            return stages(pull(Q))

        last = np.stack([system.acceleration(x, 0.0) for x in run((k - 1 + c) * h)])
        start = stages(np.einsum("ij,jbx->ibx", ahead, last))
        blocks = _blocks(system, start, A)
        for name, found in (
            ("fixed point", _iterate(full, start, size)),
            ("Anderson, depth 1", _anderson(full, start, size, 1)),
            ("Anderson, depth 2", _anderson(full, start, size, 2)),
            ("Newton, a block for each body", _newton(full, start, size, blocks)),
            ("fixed point, first passes in single precision", _iterate(
                full, start, size, lambda Q: stages(pull(Q.astype(np.float32).astype(float))))),
        ):  # fmt: skip
            counts.setdefault(name, []).append(found)
    return {name: float(np.mean(found)) for name, found in counts.items()}


def _iterate(full: Pass, Q: Array, size: Array, rough: Pass | None = None) -> int:
    """Passes of the plain iteration; those while the change is large by ``rough``."""
    change = 1.0
    for count in range(1, MOST):
        new = full(Q) if rough is None or change <= SINGLE else rough(Q)
        change = float(np.max(np.abs(new - Q) / size))
        Q = new
        if change <= SETTLED:
            return count
    return MOST


def _anderson(full: Pass, Q: Array, size: Array, depth: int) -> int:
    """Anderson's acceleration: the mix of the last images whose residuals cancel best."""
    images: list[Array] = []
    residuals: list[Array] = []
    for count in range(1, MOST):
        new = full(Q)
        gap = (new - Q) / size
        if float(np.max(np.abs(gap))) <= SETTLED:
            return count
        images, residuals = [*images, new][-depth - 1 :], [*residuals, gap.ravel()][-depth - 1 :]
        if len(images) == 1:
            Q = new
            continue
        steps = np.stack([residuals[-1] - other for other in residuals[:-1]], axis=1)
        weights = np.linalg.lstsq(steps, residuals[-1], rcond=None)[0]
        Q = new - sum(
            w * (new - image) for w, image in zip(weights, images[:-1], strict=True)
        )  # fmt: skip
    return MOST


def _blocks(system: Any, Q: Array, A: Array) -> Array:
    """(I - A x da_b/dq_b)^-1 of each body, (bodies, 3 s, 3 s), at the first stages."""
    s, bodies, d = Q.shape
    slopes = np.stack([system.acceleration_jacobian(x, 0.0) for x in Q])
    slopes = slopes.reshape(s, bodies, d, bodies, d)
    found = []
    for body in range(bodies):
        coupled = np.einsum("kj,jab->kajb", A, slopes[:, body, :, body]).reshape(s * d, s * d)
        found.append(np.linalg.inv(np.eye(s * d) - coupled))
    return np.stack(found)


def _newton(full: Pass, Q: Array, size: Array, blocks: Array) -> int:
    """Newton's iteration with the blocks kept as they are."""
    s, bodies, d = Q.shape
    for count in range(1, MOST):
        gap = (full(Q) - Q).transpose(1, 0, 2).reshape(bodies, s * d)
        move = np.einsum("bij,bj->bi", blocks, gap).reshape(bodies, s, d).transpose(1, 0, 2)
        Q = Q + move
        if float(np.max(np.abs(move) / size)) <= SETTLED:
            return count
    return MOST


if __name__ == "__main__":
    for problem in (
        galvi.problems.outer_solar_system(),
        galvi.problems.solar_system(pluto=False),
    ):
        print(problem.name, f"- {STAGES} stages, {PER_ORBIT} steps in the first planet's period")
        for name, mean in passes(problem).items():
            print(f"  {name:46s} {mean:.1f} passes a step")
