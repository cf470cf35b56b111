"""V31: oscillators whose mass or potential depends on time (M section 2, theorems 1 and 2)."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import galvi
from benchmarks.claims.kit import (
    ORACLES,
    Array,
    DataFrame,
    Fault,
    MakeMethod,
    Measurement,
    Report,
    always,
    failure,
    readings,
    rows,
    scaled,
    table_of,
)
from benchmarks.measures.independent_space import (
    all_of_degree,
    friedrichs,
    gauss_points,
    grams,
    inf_sup,
    kernels,
    lobatto_points,
    slopes,
    values,
    z0,
)
from benchmarks.test_problems.oscillators import FREQUENCY, TIMED, TimedOscillator
from references.scipy.ivp import TIGHT

DURATION = 4.0
COUNTS = tuple(round(8.0 * 2.0 ** (j / 2)) for j in range(13))
FLOOR = 5e-13  # of p up to 7; 4e-16 was measured
RULES: dict[str, Any] = {  # name -> (rule, the same in numpy, number of points minus N)
    "Gauss N": (galvi.gauss, gauss_points, 0),
    "Gauss N + 1": (galvi.gauss, gauss_points, 1),
    "Lobatto N + 1": (galvi.lobatto, lobatto_points, 1),
    "Lobatto N": (galvi.lobatto, lobatto_points, 0),
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Errors of q and p at T = 4, with oscillator, rule and degree in `study`; and, without a
    study, extremes of M's constants and distances of u and p at T from DOP853."""
    lines = []
    for timed, name, N in product(TIMED, list(RULES)[:3], (1, 2, 3)):
        report(f"{timed.name}, {name}, N = {N}")
        rule, _, offset = RULES[name]
        method = make_method(galvi.Polynomials(N), rule(N + offset))
        for count in COUNTS[:11] if quick else COUNTS:
            run = galvi.integrate(timed.problem(), method, DURATION / count, count)
            q, p = exact(timed)[:, 1]
            errors = {"error of q": abs(run.q[-1, 0] - q), "error of p": abs(run.p[-1, 0] - p)}
            where = {"n": N + 1, "step": DURATION / count, "steps": count, "status": failure(run)}
            lines += rows(errors, study=f"{timed.name}, {name}, N = {N}", **where)
    constants = [
        of_mass(N, points(N + offset), g, h)
        for (_, points, offset), N in product(RULES.values(), (1, 2, 3, 4, 6, 8))
        if N + offset > 1 or points is gauss_points
        for g, h in product((0.5, 3.0, -3.0, 10.0), (0.05, 0.3, 1.0))
    ]
    contraction, below = np.max(constants, axis=0)[0], np.min(constants, axis=0)[1]
    extremes = {
        "largest contraction of a pass over eta C_N^2": contraction,
        "least inf-sup constant over m": below,
        "least inf-sup constant over m, against 1 / sqrt(2)": below,
    }
    return table_of(
        lines
        + rows(extremes | {f"{ORACLES}, {of.name}": distance_of_references(of) for of in TIMED})
    )


def exact(timed: TimedOscillator) -> Array:
    """u and p at times 0 and T, (2, 2): a row for each quantity."""
    t = np.array([0.0, DURATION])
    u, v = timed.motion(t)
    return np.array([u, timed.mass(t) * v])


def distance_of_references(timed: TimedOscillator) -> float:
    """The largest distance of u and p at T from those of DOP853."""

    def rates(t: Any, y: Any) -> Any:
        return [y[1] / timed.mass(t), -timed.slope(t, y[0])]

    start, end = exact(timed).T
    solution = solve_ivp(rates, (0.0, DURATION), start, method="DOP853", **TIGHT)
    return float(np.max(abs(solution.y[:, -1] - end)))


def of_mass(N: int, points: Any, growth: float, h: float) -> tuple[float, float]:
    """Constants on [0, h] for mu = e^(g t) and V'' = w^2 mu: the contraction of M's pass (5) in
    |.|_(X,N) over its bound, and the inf-sup constant over m; m = min mu, K = max V''."""
    functions, (t, b) = all_of_degree(N), points
    gram, u, du = grams(functions, t, b), values(functions, t), slopes(functions, t)
    mass, ends = np.exp(growth * h * t), np.exp(growth * h * np.array([0.0, 1.0]))
    starts, tests = kernels(functions)
    form, pull = (du * b * mass) @ du.T, h**2 * FREQUENCY**2 * (u * b * mass) @ u.T
    once = np.linalg.solve(tests.T @ form @ starts, tests.T @ pull @ starts)
    root = np.linalg.cholesky(starts.T @ gram.energy @ starts).T
    shrunk = np.linalg.norm(root @ once @ np.linalg.inv(root), 2)
    bound = 3.0 * FREQUENCY**2 * max(ends) * (h * friedrichs(gram) / z0()) ** 2 / min(ends)
    return float(shrunk / bound), inf_sup(functions, gram, form) / min(ends)


def read(table: DataFrame) -> dict[str, Measurement]:
    """Orders, and the numbers without a series."""
    without_series = table[table["study"] == ""]
    numbers: dict[str, Measurement] = dict(
        zip(without_series["quantity"], without_series["value"], strict=True)
    )
    for (quantity, name), series in table.drop(without_series.index).groupby(["quantity", "study"]):
        numbers[f"order of the {quantity}, {name}"] = readings.order(series, FLOOR)
    return numbers


def late(oscillators: Any) -> Any:
    """The oscillators with motions whose time runs faster by 1e-9, for a planted fault."""
    return tuple(
        replace(timed, motion=lambda t, of=timed.motion: of((1.0 + 1e-9) * t))
        for timed in oscillators
    )


FAULTS = {
    "wrong closed forms": Fault(wrong={f"{__name__}.TIMED": late}),
    "wrong constants of a mass in time": Fault(
        wrong={
            f"{__name__}.friedrichs": always(lambda gram: 0.25),
            f"{__name__}.inf_sup": scaled(0.4),
        },
    ),
}
