"""Point masses against JPL's ephemeris, and displacements by relativity."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.integrate import solve_ivp

import galvi
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.participants import FEWEST_STEPS, finest
from benchmarks.work_precision.problem import frame_label
from galvi import Problem, Trajectory
from galvi.arrays import Array
from references.contender import EngineMissing, missing_engine
from references.jpl.ephemeris import JPL_EPHEMERIS
from references.stored.planets import STORED_TRUTH

LIGHT_SPEED = 299_792.458 * 86_400.0 / 149_597_870.7  # au / day
TIGHT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}


def path(gm: float, q0: Array, v0: Array, times: Array, light: float = LIGHT_SPEED) -> Array:
    """Positions of a light body about a mass gm at times from 0, (times, 3); light=inf: Newton.

    q'' = -gm q / r^3 + gm / (c^2 r^3) ((4 gm / r - v^2) q + 4 (q v) v), harmonic coordinates: the
    pericentre advances by 6 pi gm / (c^2 a (1 - e^2)) per revolution.
    """

    per_light = 1.0 / light**2

    def slope(t: float, state: Array) -> Any:
        x, y, z, u, v, w = state.tolist()
        r = math.sqrt(x * x + y * y + z * z)
        pull = gm / r**3
        along = pull * per_light * (4.0 * gm / r - (u * u + v * v + w * w)) - pull
        drag = pull * per_light * 4.0 * (x * u + y * v + z * w)
        return [u, v, w, along * x + drag * u, along * y + drag * v, along * z + drag * w]

    start = np.concatenate([q0, v0])
    solution = solve_ivp(slope, (0.0, times[-1]), start, t_eval=times, **TIGHT)
    return solution.y[:3].T


def displacement(gm: float, q0: Array, v0: Array, times: Array) -> Array:
    """Distance between the relativistic and the Newtonian path from the same start, (times,)."""
    gap = path(gm, q0, v0, times) - path(gm, q0, v0, times, np.inf)
    return np.linalg.norm(gap, axis=-1)


COLUMNS = (
    "contender",
    "body",
    "days",
    "difference_au",
    "difference_arcsec",
    "relativity_au",
    "integration_error_au",
    "status",
)
DAYS = (1000, 5000, 10_000)
DEGREE, STEP = 12, 10.0  # days; within 1e-12 au of the quadruple truth
GALVI_LABEL = f"galvi degree {DEGREE}, Gauss {DEGREE}"
STAGES, LONG_STEP = 16, 20.0  # in the Kepler frame
FRAME_LABEL = frame_label(STAGES, None)
ARC_SECOND = np.pi / 648_000.0
EXPLANATION = (
    f"galvi, degree {DEGREE}, steps of {STEP:g} days, from DE421's own states of 2000-01-01: the "
    "distance of each body from its position in DE421, and the angle between both as seen from "
    "the Sun, which includes the Sun's own displacement. The run's own error, against the same "
    "point masses in quadruple precision, is far smaller: the difference is that of the models, "
    f"not of the integrator, and the same in the Kepler frame, with {STAGES} stages and steps of "
    f"{LONG_STEP:g} days, of which only the run's own error is shown. Newtonian point masses omit "
    "relativity, whose largest term alone displaces a planet about the Sun as given beside the "
    "difference. They also omit the Moon (Earth is the barycentre of both), asteroids, and the "
    "oblateness of the Sun. They suffice for the dynamics of planets, not for pointing a "
    "telescope."
)


def ephemeris_table(
    quick: bool = False,
    report: Callable[[str], None] = lambda sentence: None,
    externals: Sequence[ExternalIntegrator] = (),
) -> pd.DataFrame:
    """One row for each body and time, of galvi's run and of those of external integrators, at their
    finest setting.

    contender             galvi, galvi in the Kepler frame, then external integrators
    difference_au         distance to DE421, barycentric
    difference_arcsec     angle at the Sun between the two directions; NaN for the Sun
    relativity_au         displacement by the Schwarzschild term, for the body about the Sun alone
    integration_error_au  distance to the same point masses in quadruple precision
    status                empty, or, in the only row of a failed run, the reason

    Raises ModuleNotFoundError without jplephem and de421.
    """
    if JPL_EPHEMERIS.missing:
        raise EngineMissing(JPL_EPHEMERIS.missing, name=missing_engine(JPL_EPHEMERIS))
    report("10,000 days of the planets")
    problem, duration = galvi.problems.solar_system(), float(DAYS[-1])
    samples = DAYS[-1] // DAYS[0]
    ephemeris = JPL_EPHEMERIS.run(problem, duration, {"samples": samples}).q
    truth = STORED_TRUTH.run(problem, duration, {"samples": samples}).q
    relativity = [_relativity(problem, k) for k in range(len(problem.q0))]
    setting = {"step": STEP, "save_every": round(DAYS[0] / STEP)}
    runs = [(GALVI_LABEL, gauss_collocation(DEGREE).run(problem, duration, setting))]
    longer = {"step": LONG_STEP, "save_every": round(DAYS[0] / LONG_STEP)}
    framed = gauss_collocation(STAGES, galvi.KeplerFrame()).run(problem, duration, longer)
    runs.append((FRAME_LABEL, framed))
    for external in externals:
        offered = finest(external, problem, duration, samples, FEWEST_STEPS)
        if offered is not None:
            report(f"10,000 days of the planets, {external.name}")
            runs.append((external.name, external.run(problem, duration, offered)))
    rows = []
    for contender, run in runs:
        rows += _rows(contender, run, ephemeris, truth, relativity)
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _rows(
    label: str, run: Trajectory, ephemeris: Array, truth: Array, relativity: list[Array]
) -> list[tuple[Any, ...]]:
    """The rows of one run, in the order of COLUMNS; states (samples + 1, bodies, 3)."""
    if not run.success:
        return [(label, "", *[np.nan] * 5, run.status)]
    difference, integration_error = _length(run.q - ephemeris), _length(run.q - truth)
    sky_angle = _angle(run.q - run.q[:, :1], ephemeris - ephemeris[:, :1]) / ARC_SECOND
    sky_angle[:, 0] = np.nan
    rows_of_days = [days // DAYS[0] for days in DAYS]
    return [
        (label, body, *values, "")
        for k, body in enumerate(run.problem.parameters["bodies"])
        for values in zip(
            DAYS,
            difference[rows_of_days, k],
            sky_angle[rows_of_days, k],
            relativity[k],
            integration_error[rows_of_days, k],
            strict=True,
        )
    ]


def _relativity(problem: Problem, k: int) -> Array:
    """Displacement of body k at DAYS; NaN for the Sun, which is body 0."""
    if k == 0:
        return np.full(len(DAYS), np.nan)
    system: Any = problem.system
    gm = float(system.G * (system.masses[0] + system.masses[k]))
    start = problem.q0[k] - problem.q0[0], problem.v0[k] - problem.v0[0]
    return displacement(gm, *start, np.array(DAYS, dtype=np.float64))


def _length(x: Array) -> Array:
    return np.linalg.norm(x, axis=-1)


def _angle(a: Array, b: Array) -> Array:
    """The angle between directions in radians, accurate for small angles."""
    return np.arctan2(_length(np.cross(a, b)), np.sum(a * b, axis=-1))
