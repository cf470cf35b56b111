"""The three Euler methods of H figure 1.1: motions, and energies over readings of its step.

H prints h = 0.005 without a unit, and neither the duration nor how a step of implicit Euler is
solved: all three are scanned here.

The modified equations give the change of the energy to first order in h: for q'' = a(q) the
solution of a method of order 1 is, up to h^2, that of q' = f + h g. With E = K + V, the masses m,
and <x> for the sum of m x over the bodies:

explicit    dE/dt = h/2 (<|a|^2> - <v . a'(q) v>), so E(T) - E(0) = h (int <|a|^2> - [<v . a>] / 2)
implicit    the same with -h
symplectic  v' = v + h a(q), q' = q + h v': conserves E + h/2 <v . a> up to h^2

(integrating by parts: d/dt <v . a> = <|a|^2> + <v . a'(q) v>).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.integrate import simpson

from benchmarks.claims.kit import ORACLES, Array, Problem, Trajectory, failure, history, rows
from benchmarks.claims.vector_spaces.implicit_euler_orbit import (
    DAYS_PER_YEAR,
    DURATION_YEARS,
    INNER,
    PRINTED_STEP,
    YEARS_PER_UNIT,
    least_solvable,
)
from benchmarks.measures.errors import energy_errors
from benchmarks.measures.independent_invariants import energy
from references.newton import acceleration
from references.rebound.ias15 import IAS15
from references.scipy.ivp import DOP853, TIGHT

HALVED_STEPS = tuple(2.0 * PRINTED_STEP / 2.0**k for k in range(5))  # years: 0.01 to 0.000625
REFINEMENT_YEARS = 0.02  # years
EXPLICIT, IMPLICIT, SYMPLECTIC = "explicit Euler", "implicit Euler", "symplectic Euler"
ENERGY, ORDER = "energy error", "position error after 0.02 years"
NEAR = "|q + h v| of Mercury over the least with a solution"
STOPPED = f"{NEAR}, where it stops, largest over h, implicit Euler"
SOLVED = f"{NEAR}, solved steps, least over h, implicit Euler"


def work(run: Any) -> tuple[Array, Array]:
    """<|a|^2> and <v . a> at each saved state over the energy at the start, (k,) each."""
    accelerated, zero_velocity = acceleration(run.problem), np.zeros(run.problem.v0.shape)
    a = np.array([accelerated(q, zero_velocity, run.problem.t0) for q in run.q])
    size = abs(energy(run.problem, run.problem.q0[None], run.problem.v0[None])[0])
    weights = run.problem.system.masses[:, None] / size
    return np.sum(weights * a * a, axis=(1, 2)), np.sum(weights * run.v * a, axis=(1, 2))


def explicit_slope(truth: Trajectory) -> float:
    """(E(T) / E(0) - 1) / h of explicit Euler for small h, from an evenly sampled exact motion."""
    square, power = work(truth)
    return float(simpson(square, x=truth.t) - 0.5 * (power[-1] - power[0]))


def symplectic_change(run: Trajectory, h: float) -> Array:
    """E / E(0) - 1 of a run of symplectic Euler up to h^2, from its own states: (k,)."""
    power = work(run)[1]
    return -0.5 * h * (power - power[0])


def refinement_rows(contenders: dict[str, Any], system: Problem) -> list[dict[str, Any]]:
    """Rows for halved steps over REFINEMENT_YEARS years: errors of the position and, for explicit
    and implicit Euler, the change of energy beyond that of the modified equation on IAS15's motion;
    and the distance of DOP853 from IAS15 over the smallest error."""
    lines, duration = [], REFINEMENT_YEARS * DAYS_PER_YEAR
    truth = IAS15.run(system, duration, {"samples": 400})
    slope = explicit_slope(truth)
    for label, contender in contenders.items():
        sign = {EXPLICIT: 1.0, IMPLICIT: -1.0}.get(label)
        for k in range(7):
            steps = round(REFINEMENT_YEARS / PRINTED_STEP) * 2**k
            run = contender.run(system, duration, {"step": duration / steps})
            errors = {ORDER: largest_distance(run, truth)}
            if sign:
                change = energy_errors(run)[-1] - sign * duration / steps * slope
                errors["energy change beyond first order in h"] = abs(change)
            where = {"step": REFINEMENT_YEARS / steps, "steps": steps, "status": failure(run)}
            lines += rows(errors, study=label, **where)
    distance = largest_distance(DOP853.run(system, duration, {"samples": 1, **TIGHT}), truth)
    smallest = np.min([line["value"] for line in lines if line["quantity"] == ORDER])
    name = f"{ORACLES} after 0.02 years, over the smallest position error"
    return lines + rows({name: distance / smallest})


def largest_distance(run: Trajectory, truth: Trajectory) -> float:
    """The largest distance of a body from its true position at the end."""
    return float(np.max(np.linalg.norm(run.q[-1] - truth.q[-1], axis=-1)))


def energy_rows(contenders: dict[str, Any], system: Problem) -> list[dict[str, Any]]:
    """Rows on the change of energy by explicit and symplectic Euler over readings of h, in YEARS
    years, for h = 0.005 days in one year; and the motions for h = 0.005 years."""
    lines, rises, ratios = [], [], []
    for h, years in (
        *((h, DURATION_YEARS) for h in HALVED_STEPS),
        (PRINTED_STEP / DAYS_PER_YEAR, 1.0),
    ):
        count, step = round(years / h), h * DAYS_PER_YEAR
        save_every = max(1, count // 4000)
        count -= count % save_every
        setting = {"step": step, "save_every": save_every}
        runs = [contenders[x].run(system, count * step, setting) for x in (EXPLICIT, SYMPLECTIC)]
        explicit, symplectic = (energy_errors(run) for run in runs)
        rises.append(np.mean(np.diff(explicit) > 0.0))
        ratios.append(np.max(abs(symplectic)) / np.max(abs(explicit)))
        if years == DURATION_YEARS:
            beyond = symplectic - symplectic_change(runs[1], step)
            values = {
                "largest energy error": np.max(abs(symplectic)),
                "energy error beyond the modified energy": np.max(abs(beyond)),
            }
            where = {"step": h, "steps": count, "status": failure(runs[1])}
            lines += rows(values, study=SYMPLECTIC, **where)
        if h == PRINTED_STEP:
            lines += motion_rows(EXPLICIT, runs[0]) + motion_rows(SYMPLECTIC, runs[1])
    return lines + rows(
        {
            "share of steps in which the energy rises, least over h, explicit Euler": np.min(rises),
            "largest energy error of symplectic Euler over that of explicit Euler, "
            "largest over h": np.max(ratios),
        }
    )


def implicit_rows(contender: Any, system: Any) -> list[dict[str, Any]]:
    """Rows on implicit Euler over readings of h, in half a year, within which it stops for each h:
    the change of energy, and the margin of Mercury's steps from having no solution. Also the motion
    for h = 0.005 years."""
    lines, rises, solved, stopped = [], [], [], []
    mu = system.system.masses[0] + system.system.masses[1]
    for h in (*HALVED_STEPS, PRINTED_STEP * YEARS_PER_UNIT):
        run = contender.run(system, round(0.5 / h) * h * DAYS_PER_YEAR, {"step": h * DAYS_PER_YEAR})
        finite = np.isfinite(run.q).all(axis=(1, 2))
        drifted = (run.q + h * DAYS_PER_YEAR * run.v)[finite]
        sizes = np.linalg.norm(drifted[:, 1] - drifted[:, 0], axis=-1)
        margins = sizes / least_solvable(mu, h * DAYS_PER_YEAR)
        rises.append(np.mean(np.diff(energy_errors(run)[finite]) > 0.0))
        solved.append(np.min(margins[:-1]))
        stopped.append(np.nan if run.success else margins[-1])
        if h == PRINTED_STEP:
            lines += motion_rows(IMPLICIT, run)
    return lines + rows(
        {
            "share of steps in which the energy rises, largest over h, implicit Euler": np.max(
                rises
            ),
            STOPPED: np.max(stopped),
            SOLVED: np.min(solved),
        }
    )


def motion_rows(label: str, run: Trajectory) -> list[dict[str, Any]]:
    """Rows of the energy errors of all completed steps, and of the inner planets' positions
    relative to the Sun at every second one."""
    finite = np.isfinite(run.q).all(axis=(1, 2))
    lines = history(ENERGY, run.t[finite], energy_errors(run)[finite], study=label)
    lines[-1]["status"] = failure(run)
    t, heliocentric = run.t[finite][::2], (run.q - run.q[:, :1])[finite][::2]
    for k, body in enumerate(INNER, start=1):
        lines += history("position", t, heliocentric[:, k], study=label, label=body)
    return lines
