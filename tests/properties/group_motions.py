"""Problems on groups, methods, and reference states at DURATION, for the tests of runs."""

from dataclasses import replace
from functools import cache

import numba
import numpy as np
import pytest

import galvi
from galvi.charts import CHARTS
from references.closed_forms.top_motion import FREE_TOP
from references.scipy.ivp import TIGHT
from references.scipy.rigid_ivp import RIGID_DOP853
from tests.properties.group_matrices import element, title

CAYLEY, EXPONENTIAL, RODRIGUES = galvi.Cayley(), galvi.Exponential(), galvi.ModifiedRodrigues()


FREE, PENDULUM = galvi.problems.free_rigid_body(), galvi.problems.pendulum_3d()


FLYING = galvi.problems.free_body_se3(g=(0.0, 0.5, -9.81))


def collocation(degree, chart=CAYLEY):
    return galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree), chart)


def hall(n, chart=CAYLEY):
    """H's method with n control points."""
    return galvi.Galerkin(galvi.Polynomials(n - 1), galvi.gauss(n), chart)


MASSES = np.array([[1.0, 0.3, 0, 0], [0.3, 1.2, 0, 0], [0, 0, 1.5, 0], [0, 0, 0, 2.0]])


def coupled_function(q, v):
    """A pendulum on SO(2) and a body on SO(3), coupled in both energies; q has 4 + 9 entries."""
    return 0.5 * np.sum(v * (MASSES @ v)) + 0.5 * q[2] + q[0] * q[8] - 0.5 * q[12] ** 2


def coupled_slopes(q, v):
    out = np.zeros(17)
    for i in range(4):
        for j in range(4):
            out[i] += MASSES[i, j] * v[j]
    out[4], out[4 + 2], out[4 + 8], out[4 + 12] = q[8], 0.5, q[0], -q[12]
    return out


PAIR = galvi.Product((galvi.SO2(), galvi.SO3()))


COUPLED = galvi.Problem(
    galvi.Lagrangian(coupled_function, PAIR, numba.njit(cache=True)(coupled_slopes)),
    element(PAIR, [0.4, 0.1, -0.7, 0.3]),
    [1.0, 0.3, -0.5, 0.2],
    name="pendulum and body",
)


ALL = [FREE, PENDULUM, galvi.problems.heavy_top(), FLYING, COUPLED]


each_chart = pytest.mark.parametrize("chart", CHARTS, ids=title)


def same(left, right):
    return np.array_equal(left.q, right.q) and np.array_equal(left.p, right.p)


DURATION = 4.0


@cache
def pendulum_end():
    """R and p of the pendulum at DURATION, by DOP853."""
    exact = RIGID_DOP853.run(PENDULUM, DURATION, TIGHT)
    return exact.q[-1], exact.p[-1]


@cache
def free_body_end():
    """R and p of the free body at DURATION, by its closed form."""
    closed = FREE_TOP.run(FREE, DURATION, {"samples": 1})
    return closed.q[-1], closed.p[-1]


def end_error(run, truth):
    R, p = truth
    return max(np.abs(run.q[-1] - R).max(), np.abs(run.p[-1] - p).max() / np.abs(p).max())


def measured_order(problem, truth, method, lowest, highest):
    """The order: the least-squares slope of the error at the end over the step."""
    counts = np.unique(np.geomspace(lowest, highest, 6).round().astype(int))
    errors = []
    for steps in counts.tolist():
        run = galvi.integrate(problem, method, DURATION / steps, steps, save_every=steps)
        assert run.success, run.status
        errors.append(end_error(run, truth))
    return np.polyfit(np.log(DURATION / counts), np.log(errors), 1)[0]


# Degree -> smallest and largest number of steps in DURATION: errors there are asymptotic and far
# above rounding.
WINDOWS = {2: (32, 128), 3: (24, 64), 4: (17, 32), 5: (12, 18)}


def same_rows(thin, full, rows):
    return np.array_equal(thin.q, full.q[rows]) and np.array_equal(thin.p, full.p[rows])


def with_scaled_table(method, **changes):
    """The method with arrays of its table multiplied by the factors in ``changes``."""
    # Tables are cached by rule, and a rule of another name gets a table of its own.
    rule = replace(method.rule, name=f"{method.rule.name} {changes}")
    scaled = galvi.Galerkin(method.space, rule, method.chart)
    arrays = {name: getattr(scaled.table, name) * factor for name, factor in changes.items()}
    vars(scaled)["table"] = replace(scaled.table, **arrays)
    return scaled
