"""The three Euler methods of H figure 1.1 over readings of its step, shared by V11's rows.

H prints h = 0.005 without a unit, and neither the duration nor how a step of implicit Euler is
solved: all three are scanned here.
"""

from __future__ import annotations

from itertools import product

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.euler_energy import symplectic_change
from benchmarks.claims.vector_spaces.implicit_euler_orbit import Orbits, follow, least_solvable
from benchmarks.measures.errors import energy_errors
from benchmarks.measures.independent_invariants import energy
from references.contender import Contender

DAYS = 365.25  # in a year
PRINTED = 0.005
UNITS = {"years": 1.0, "years / 2 pi, in which G = 1": 0.5 / np.pi, "days": 1.0 / DAYS}
HALVED = tuple(2.0 * PRINTED / 2.0**k for k in range(5))  # years: 0.01 to 0.000625
YEARS, DAY_YEARS = 20.0, 1.0  # the shorter for a step of 0.005 days
SAVED = 4000  # states, at most
TO_STOP = 0.5  # years, in which implicit Euler stops at all of these steps
INNER = ("Mercury", "Venus", "Earth", "Mars")
SCANNED = (2e-3, 0.05)  # years, the ends of the scan in closed form

LARGEST, RISES = "largest energy error", "share of steps with rising energy"
BEYOND = "energy error beyond the modified energy"
SOLVED = "|q + h v| of Mercury over the least with a solution, solved steps"
STOPPED = "|q + h v| of Mercury over the least with a solution, where it stops"
ESCAPES = "escapes, every step solved"
READ, READ_IN_DAYS = ", readings of h", ", h in days"  # after a method's name, in `study`
LARGER, SMALLER = "implicit Euler, larger solution", "implicit Euler, smaller solution once"
AFTER = 100  # steps that are followed after it


def explicit_rows(label: str, contender: Contender, system: Problem) -> list[dict[str, Any]]:
    """Energy of an explicit or symplectic method over 20 years, 1 for a step of 0.005 days."""
    found = []
    for h, years in (*((h, YEARS) for h in HALVED), (PRINTED * UNITS["days"], DAY_YEARS)):
        count = round(years / h)
        count -= count % max(1, count // SAVED)
        step = h * DAYS
        setting = {"step": step, "save_every": max(1, count // SAVED)}
        run = contender.run(system, count * step, setting)
        errors = energy_errors(run)
        beyond = errors - symplectic_change(run, step) / abs(energy_of(system))
        values = {
            LARGEST: np.max(np.abs(errors)),
            RISES: np.mean(np.diff(errors) > 0.0),
            BEYOND: np.max(np.abs(beyond)),
        }
        which = READ if years == YEARS else READ_IN_DAYS
        where = {"study": label + which, "step": h, "steps": count, "status": failure(run)}
        found += [row(quantity=name, value=float(x), **where) for name, x in values.items()]
    return found


def implicit_rows(label: str, contender: Contender, system: Problem) -> list[dict[str, Any]]:
    """Energy of implicit Euler, and how near Mercury's steps come to having no solution."""
    found = []
    for h in (*HALVED, PRINTED * UNITS["years / 2 pi, in which G = 1"]):
        count, step = round(TO_STOP / h), h * DAYS
        run = contender.run(system, count * step, {"step": step})
        done = np.isfinite(run.q).all(axis=(1, 2))
        q, v = run.q[done], system.system.velocity(run.p[done])
        k = bodies(system).index("Mercury")
        drifted = q[:, k] - q[:, 0] + step * (v[:, k] - v[:, 0])
        mu = system.system.masses[0] + system.system.masses[k]
        near = np.linalg.norm(drifted, axis=-1) / least_solvable(mu, np.array(step))
        values = {
            RISES: np.mean(np.diff(energy_errors(run)[done]) > 0.0),
            SOLVED: np.min(near[:-1]),
            STOPPED: near[-1] if run.failed_step is not None else np.nan,
        }
        where = {"study": label + READ, "step": h, "status": failure(run)}
        found += [row(quantity=name, value=float(x), **where) for name, x in values.items()]
    return found


def two_body_rows(system: Problem, count: int) -> list[dict[str, Any]]:
    """Inner planets about the Sun alone, every step solved in closed form.

    'implicit Euler, larger solution'  whether the energy ever suffices to escape within 20 years,
                                       of each h: 1 or 0
    'implicit Euler, smaller solution once'  share of the steps of 0.005 years, before the one that
                                       has no solution, at whose smaller one the planet escapes
    """
    units = np.array([1.0, UNITS["years / 2 pi, in which G = 1"]])
    larger = np.unique(np.append(np.geomspace(*SCANNED, count), PRINTED * units))
    away = two_body(system, larger).energy > 0.0
    found = [
        row(study=LARGER, quantity=ESCAPES, label=body, step=step, value=float(escaped))
        for (body, step), escaped in zip(product(INNER, larger), away, strict=True)
    ]
    for k, (body, stop) in enumerate(
        zip(INNER, two_body(system, np.array([PRINTED])).unsolved, strict=True)
    ):
        late = np.arange(1, stop + 1)
        steps = np.full(late.size, PRINTED)
        those = two_body(system, steps, (stop + AFTER) * PRINTED, np.tile(late, len(INNER)))
        share = float(np.mean(those.energy.reshape(len(INNER), -1)[k] > 0.0))
        found.append(row(study=SMALLER, quantity=ESCAPES, label=body, step=PRINTED, value=share))
    return found


def two_body(
    system: Problem, h: Array, years: float = YEARS, smaller_at: Array | None = None
) -> Orbits:
    """The inner planets about the Sun alone, in au and years: (4 k,), of each planet all h (k,)."""
    planets = [bodies(system).index(body) for body in INNER]
    q, v = ((x[planets] - x[0]).repeat(h.size, axis=0) for x in (system.q0, system.v0 * DAYS))
    mu = (system.system.masses[0] + system.system.masses[planets]).repeat(h.size) * DAYS**2
    steps = np.tile(h, len(planets))
    return follow(q, v, mu, steps, years, smaller_at)


def bodies(system: Problem) -> tuple[str, ...]:
    """The names of the bodies."""
    return system.parameters["bodies"]


def energy_of(system: Problem) -> float:
    """The energy at the start, in au^5 / day^4."""
    return float(energy(system, system.q0[None], system.v0[None])[0])
