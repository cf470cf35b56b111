"""Flybys of a massless body at planets and the Moon, and how near each comes, by heyoka in
quadruple precision: `python -m references.stored.flybys flybys`."""

from __future__ import annotations

import itertools
import sys
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from galvi import NBody, Problem, problems
from galvi.arrays import Array, read_only
from references.contender import require
from references.heyoka.engine import QUADRUPLE, engine_name
from references.heyoka.passages import passages
from references.heyoka.taylor import HEYOKA, HEYOKA_QUADRUPLE
from references.stored.planets import FOLDER

KM = 1.0 / 149_597_870.7  # au
KM_S = 86400.0 * KM  # au a day
DURATION = 365.0  # days
WHEN = (60.0, 305.0)  # between which the nearest place is passed
BODIES = ("Sun", "Mercury", "Earth", "Moon", "Jupiter", "meteoroid")
TARGETS = ("Moon", "Mercury", "Earth", "Jupiter")
SPEEDS = np.linspace(5.0, 70.0, 13)  # km/s, relative to the target, far from it
IMPACTS = 3.5 * np.arange(1, 24) / 24  # Hill radii of the target
MOON = (384_400.0, 0.0549, 81.300_569)  # semi-major axis [km], eccentricity, Earth's mass over its
FILE = FOLDER / "flybys.csv"
METEOROID = BODIES.index("meteoroid")
COMPACT = {"tolerance": 1e-18, "high_accuracy": True, "compact_mode": True}  # of starts
TOLERANCE, LOOSER = 1e-22, 1e-19


class Flybys(NamedTuple):
    """All flybys: bodies' numbers of targets (n,), v_inf [km/s], impact parameters [Hill radii],
    starts of the meteoroid (n, 3) [au, au/day], times since the start of the least distance to the
    target [days], and that [au]."""

    targets: Any
    speeds: Array
    impacts: Array
    q: Array
    v: Array
    t: Array
    distance: Array

    def problem(self, k: int) -> Problem:
        """The k-th: Sun, planets, Moon and meteoroid."""
        base = surroundings()
        q, v = (np.concatenate([x[:-1], y[k : k + 1]]) for x, y in
                ((base.q0, self.q), (base.v0, self.v)))  # fmt: skip
        return base.with_initial_state(q, v)


@lru_cache(maxsize=1)
def surroundings() -> Problem:
    """The Sun, planets as in `galvi.problems.solar_system`, and a Moon of Keplerian elements at
    its perigee, in the plane of the Earth's motion; the meteoroid far away, at rest."""
    known = problems.solar_system(pluto=False)
    system: Any = known.system
    names = known.body_names()
    rows = [names.index(name) for name in ("Sun", "Mercury", "Earth", "Earth", "Jupiter")]
    masses, q, v = system.masses[rows], known.q0[rows], known.v0[rows]
    a, e, ratio = MOON[0] * KM, *MOON[1:]
    from_sun, moving = q[2] - q[0], v[2] - v[0]
    ahead = np.cross(np.cross(from_sun, moving), from_sun)
    out, along = from_sun / np.linalg.norm(from_sun), ahead / np.linalg.norm(ahead)
    gap, speed = a * (1.0 - e) * out, np.sqrt(masses[2] / a * (1.0 + e) / (1.0 - e)) * along
    share = 1.0 / (1.0 + ratio)  # of the Moon
    q[2], q[3], v[2], v[3] = (x + by * y for x, y, by in (
        (q[2], gap, -share), (q[3], gap, 1.0 - share), (v[2], speed, -share),
        (v[3], speed, 1.0 - share)))  # fmt: skip
    masses[2], masses[3] = masses[2] * (1.0 - share), masses[3] * share
    return Problem(
        NBody(np.append(masses, 0.0)), np.append(q, [[0.0, 0.0, 50.0]], axis=0),
        np.append(v, np.zeros((1, 3)), axis=0), name="flybys", units=known.units,
        parameters={"bodies": BODIES},
    )  # fmt: skip


def hill_radius(target: int) -> float:
    """Of a body about the Sun, or of the Moon about the Earth, at the start [au]."""
    base, about = surroundings(), 2 if BODIES[target] == "Moon" else 0
    masses = base.system.masses  # type: ignore[attr-defined]
    far = np.linalg.norm(base.q0[target] - base.q0[about])
    return float(far * (masses[target] / (3.0 * masses[about])) ** (1.0 / 3.0))


def table() -> str:
    """The text of the file; raises ModuleNotFoundError without heyoka's real128."""
    base = surroundings()
    require(HEYOKA_QUADRUPLE, base)
    rows, apart = [], []
    cases = itertools.product(TARGETS, SPEEDS, IMPACTS)
    for k, (name, speed, impact) in enumerate(cases):
        target = BODIES.index(name)
        start = base.with_initial_state(*_start(k, target, speed, impact))
        t, near = _nearest(start, target, TOLERANCE)
        if k % 100 == 0:  # of a few, with a looser tolerance
            apart.append(abs(near - _nearest(start, target, LOOSER)[1]))
        numbers = (*start.q0[-1].tolist(), *start.v0[-1].tolist(), t, near)
        rows.append(",".join([name, f"{speed:.6g}", f"{impact:.6g}", *map(repr, numbers)]))
    lines = [
        f"# flybys over {DURATION:g} days; au, days, v_inf in km/s, impact parameter in Hill radii",
        f"# source: {engine_name('real128')}, tolerance {TOLERANCE}, high_accuracy, its events",
        f"# accuracy: with {LOOSER:g} some distances differ by {max(apart):.1e}",
        f"# made by: python -m references.stored.flybys {FILE.stem}",
        "target,speed,impact,x,y,z,vx,vy,vz,t,distance",
    ]
    return "\n".join([*lines, *rows]) + "\n"


def _start(k: int, target: int, speed: float, impact: float) -> tuple[Array, Array]:
    """A state from which the meteoroid passes the target so, at a random time and direction: from
    the pericentre of its hyperbola backwards."""
    base, draw = surroundings(), np.random.Generator(np.random.Philox(k))
    when = draw.uniform(*WHEN)
    there = _state(base.q0, base.v0, when)
    towards = np.linalg.qr(draw.normal(size=(3, 2)))[0].T
    mu = base.system.masses[target]  # type: ignore[attr-defined]
    b, v = impact * hill_radius(target), speed * KM_S
    near = np.sqrt((mu / v**2) ** 2 + b**2) - mu / v**2
    there[0, -1] = there[0, target] + near * towards[0]
    there[1, -1] = there[1, target] + np.sqrt(v**2 + 2.0 * mu / near) * towards[1]
    back = _state(*there, -when)[:, -1]
    q, v = base.q0.copy(), base.v0.copy()
    q[-1], v[-1] = back
    return q, v


def _state(q: Array, v: Array, duration: float) -> Array:
    """q and v of all bodies, (2, bodies, 3), after a time."""
    start = surroundings().with_initial_state(q, v)
    run = HEYOKA.run(start, duration, {"samples": 1, **COMPACT})
    return np.array([run.q[-1], run.v[-1]])


def _nearest(start: Problem, target: int, tolerance: float) -> tuple[float, float]:
    """Time and distance where the meteoroid is nearest to the target, of all its passages."""
    _, t, gap = passages(
        start, [(METEOROID, target)], DURATION, {**QUADRUPLE, "tolerance": tolerance},
        precision="real128",
    )  # fmt: skip
    far = np.linalg.norm(gap, axis=1)
    row = int(np.argmin(far))
    return float(t[row]), float(far[row])


@lru_cache(maxsize=1)
def flybys() -> Flybys:
    """The file."""
    lines = [line for line in FILE.read_text("ascii").splitlines() if line[0] not in "#t"]
    targets: Any = np.array([BODIES.index(line.split(",")[0]) for line in lines])
    rows = np.array([line.split(",")[1:] for line in lines], float)
    columns = rows[:, 0], rows[:, 1], rows[:, 2:5], rows[:, 5:8], rows[:, 8], rows[:, 9]
    return Flybys(targets, *(read_only(x.copy()) for x in columns))


if __name__ == "__main__":
    FILE.write_text(table(), encoding="ascii")
    sys.stdout.write(f"wrote references/stored/data/{FILE.name}\n")
