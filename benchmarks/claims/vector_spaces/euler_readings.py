"""The three Euler methods of H figure 1.1: motions, and energies over readings of its step.

H prints h = 0.005 without a unit, and neither the duration nor how a step of implicit Euler is
solved: all three are scanned here.

What the modified equations say of the energy, to first order in h: for q'' = a(q) the solution of a
method of order 1 is, up to h^2, that of q' = f + h g. With E = K + V, m the masses and <x> the sum
of m x over the bodies:

explicit    dE/dt = h/2 (<|a|^2> - <v . a'(q) v>), so E(T) - E(0) = h (int <|a|^2> - [<v . a>] / 2)
implicit    the same with -h
symplectic  v' = v + h a(q), q' = q + h v': conserves E + h/2 <v . a> up to h^2

(integrating by parts: d/dt <v . a> = <|a|^2> + <v . a'(q) v>).
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import simpson

from benchmarks.claims.kit import (
    ORACLES,
    Any,
    Array,
    Problem,
    Trajectory,
    failure,
    history,
    rows,
)
from benchmarks.claims.vector_spaces.implicit_euler_orbit import (
    DAYS,
    INNER,
    PRINTED,
    UNIT,
    YEARS,
    least_solvable,
)
from benchmarks.measures.errors import energy_errors
from benchmarks.measures.independent_invariants import energy
from references.newton import acceleration
from references.rebound.ias15 import IAS15
from references.scipy.ivp import DOP853, TIGHT

HALVED = tuple(2.0 * PRINTED / 2.0**k for k in range(5))  # years: 0.01 to 0.000625
REFINED = 0.02  # years
EXPLICIT, IMPLICIT, SYMPLECTIC = "explicit Euler", "implicit Euler", "symplectic Euler"
ENERGY, LARGEST = "energy error", "largest energy error"
RISES = "share of steps in which the energy rises"
BEYOND = "energy error beyond the modified energy"
SOLVED = "|q + h v| of Mercury over the least with a solution, solved steps"
STOPPED = "|q + h v| of Mercury over the least with a solution, where it stops"
ORDER = "position error after 0.02 years"
SECOND = "energy change beyond first order in h"


def work(run: Any) -> tuple[Array, Array]:
    """<|a|^2> and <v . a> at each saved state, (k,), over the energy at the start."""
    accelerated, rest = acceleration(run.problem), np.zeros(run.problem.v0.shape)
    a = np.array([accelerated(place, rest, run.problem.t0) for place in run.q])
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


def refined(contenders: dict[str, Any], system: Problem) -> list[dict[str, Any]]:
    """After 0.02 years, the step halved: errors of the place and, of explicit and implicit Euler,
    of the energy beyond that of the modified equation, by IAS15's motion; how far DOP853 is from it
    over the smallest error of a place."""
    lines, duration = [], REFINED * DAYS
    truth = IAS15.run(system, duration, {"samples": 400})
    slope = explicit_slope(truth)
    for label, contender in contenders.items():
        sign = {EXPLICIT: 1.0, IMPLICIT: -1.0}.get(label)
        for k in range(7):
            steps = round(REFINED / PRINTED) * 2**k
            run = contender.run(system, duration, {"step": duration / steps})
            errors = {ORDER: farthest(run, truth)}
            if sign:
                errors[SECOND] = abs(energy_errors(run)[-1] - sign * duration / steps * slope)
            where = {"step": REFINED / steps, "steps": steps, "status": failure(run)}
            lines += rows(errors, study=label, **where)
    apart = farthest(DOP853.run(system, duration, {"samples": 1, **TIGHT}), truth)
    smallest = min(line["value"] for line in lines if line["quantity"] == ORDER)
    name = f"{ORACLES} after 0.02 years, over the smallest position error"
    return lines + rows({name: apart / smallest})


def farthest(run: Trajectory, truth: Trajectory) -> float:
    """The largest distance of a body at the end."""
    return float(np.max(np.linalg.norm(run.q[-1] - truth.q[-1], axis=-1)))


def energies(label: str, contender: Any, system: Problem) -> list[dict[str, Any]]:
    """Over readings of h: how the energy changes in 20 years, 1 for 0.005 days; of implicit Euler
    in half a year, in which it stops at all steps, and how near Mercury's come to having no
    solution. The motion by 0.005 years."""
    lines, implicit = [], label == IMPLICIT
    years = dict.fromkeys(HALVED, 0.5 if implicit else YEARS)
    years |= {PRINTED * UNIT: 0.5} if implicit else {PRINTED / DAYS: 1.0}
    for h, duration in years.items():
        count, step = round(duration / h), h * DAYS
        every = max(1, count // 4000)
        count -= count % every
        run = contender.run(system, count * step, {"step": step, "save_every": every})
        errors = energy_errors(run)
        values: dict[str, Any] = {RISES: np.mean(np.diff(errors[np.isfinite(errors)]) > 0.0)}
        if implicit:
            near = nearness(run, step)
            values |= {SOLVED: np.min(near[:-1]), STOPPED: np.nan if run.success else near[-1]}
        else:
            beyond = errors - symplectic_change(run, step)
            values |= {LARGEST: np.max(abs(errors)), BEYOND: np.max(abs(beyond))}
        where = {"study": label if h in HALVED else "another unit", "step": h, "steps": count}
        lines += rows(values, label=label, status=failure(run), **where)
        if h == PRINTED:
            lines += motion(label, run)
    return lines


def motion(label: str, run: Trajectory) -> list[dict[str, Any]]:
    """Energy errors of all completed steps, and the inner planets from the Sun at every second."""
    done = np.isfinite(run.q).all(axis=(1, 2))
    lines = history(ENERGY, run.t[done], energy_errors(run)[done], study=label)
    lines[-1]["status"] = failure(run)
    t, place = run.t[done][::2], (run.q - run.q[:, :1])[done][::2]
    for k, body in enumerate(INNER, start=1):
        lines += history("position", t, place[:, k], study=label, label=body)
    return lines


def nearness(run: Any, h: float) -> Array:
    """|q + h v| of Mercury from the Sun over the least with a solution, of all steps done."""
    drifted = run.q + h * run.v
    sizes = np.linalg.norm(drifted[:, 1] - drifted[:, 0], axis=-1)
    masses = run.problem.system.masses
    return sizes[np.isfinite(sizes)] / least_solvable(masses[0] + masses[1], h)
