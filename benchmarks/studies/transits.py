"""Mid-transit times of three planets, by events and by bisection, against heyoka's."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.statistics.timing import once
from benchmarks.work_precision.problem import galvi_label
from galvi import NBody, Problem
from galvi.arrays import Array
from references.heyoka import engine as heyoka_engine
from references.heyoka import taylor as heyoka_taylor
from references.heyoka.passages import passages
from references.rebound import passages as rebound_passages
from references.rebound import simulation as rebound_simulation
from references.rebound import whfast

COLUMNS = ("contender", "settings", "transits", "lost", "largest_s", "seconds", "status")
YEAR = 2.0 * math.pi  # with G = 1, au and solar masses
SECOND = YEAR / 365.25 / 86400.0
YEARS, QUICK_YEARS = 1000.0, 20.0
PERIODS = (0.5, 1.04, 2.13)  # years
MASSES = (2e-5, 6e-5, 3e-5)
PLANETS, STAR = (1, 2, 3), 0
EVERY = 0.05 * YEAR  # between outputs
FAR = 3600.0  # seconds
EXPLANATION = (
    "Three planets of some Earth masses in one plane, seen along it, over 1,000 years. REBOUND's "
    "example of transit timing variations looks for a change of sign between two outputs and "
    "halves the time between them, integrating to and fro, until it is known to a second; galvi "
    "finds all transits on the curves of its steps. Errors are from heyoka's events at its best "
    "setting; lost are transits without a counterpart within an hour. A time has the "
    "integration in it."
)


def three_planets() -> Problem:
    """A star of one solar mass and planets on ellipses of small eccentricity in the plane z = 0."""
    masses = np.array([1.0, *MASSES])
    q, v = np.zeros((4, 3)), np.zeros((4, 3))
    for k, (years, mass, turn) in enumerate(zip(PERIODS, MASSES, (0.7, 2.9, 5.0), strict=True), 1):
        a, e = ((1.0 + mass) * years**2) ** (1.0 / 3.0), 0.02 * k
        speed = math.sqrt((1.0 + mass) / a * (1.0 - e) / (1.0 + e))  # at the apocentre
        q[k, :2] = a * (1.0 + e) * np.array([math.cos(turn), math.sin(turn)])
        v[k, :2] = speed * np.array([-math.sin(turn), math.cos(turn)])
    q, v = (x - masses @ x / masses.sum() for x in (q, v))
    return Problem(
        NBody(masses), q, v, name="three planets", units="au, solar mass, year / 2 pi",
        parameters={"bodies": ("star", "b", "c", "d")},
    )  # fmt: skip


def _by_galvi(stages: int, part: float) -> Callable[[float], list[Array]]:
    method = galvi.Galerkin(galvi.Polynomials(stages), galvi.gauss(stages))
    events = [galvi.events.transit(planet, STAR, (1.0, 0.0, 0.0)) for planet in PLANETS]

    def times(duration: float) -> list[Array]:
        steps = math.ceil(duration / (PERIODS[0] * YEAR / part))
        run = galvi.integrate(three_planets(), method, duration / steps, steps)
        found = galvi.find_events(run, events)
        return [found.t[found.index == k] for k in range(len(PLANETS))]

    return times


def _by_heyoka(**setting: Any) -> Callable[[float], list[Array]]:
    def times(duration: float) -> list[Array]:
        pairs = [(planet, STAR) for planet in PLANETS]
        which, t, _ = passages(three_planets(), pairs, duration, setting, sky=True)
        return [t[which == k] for k in range(len(PLANETS))]

    return times


def _by_rebound(**how: Any) -> Callable[[float], list[Array]]:
    return lambda duration: rebound_passages.transits(
        three_planets(), PLANETS, STAR, duration, EVERY, SECOND, **how
    )


def _whfast(part: float) -> Callable[[float], list[Array]]:
    return _by_rebound(integrator="whfast", options=dict(whfast.BEST) | {"safe_mode": 1},
                       step=PERIODS[0] * YEAR / part)  # fmt: skip


best = _by_heyoka(**{**heyoka_taylor.BEST, "compact_mode": True})
PARTICIPANTS: tuple[tuple[str, str, Callable[[float], list[Array]], Callable[[], str]], ...] = (
    *((galvi_label(8), f"events, {part:g} steps a revolution", _by_galvi(8, part), str)
      for part in (6.0, 10.0)),
    ("heyoka", "events", _by_heyoka(compact_mode=True), lambda: heyoka_engine.missing("double")),
    ("REBOUND IAS15", "bisection", _by_rebound(), rebound_simulation.missing),
    *(("REBOUND WHFast, best", f"bisection, {part:g} steps a revolution", _whfast(part),
       rebound_simulation.missing) for part in (40.0, 200.0)),
)  # fmt: skip


def transits_table(
    quick: bool = False, report: Callable[[str], None] = lambda sentence: None
) -> pd.DataFrame:
    """One row for each contender and setting; errors NaN without heyoka."""
    duration = (QUICK_YEARS if quick else YEARS) * YEAR
    true = None if heyoka_engine.missing("double") else best(duration)
    rows = []
    for contender, settings, times, missing in PARTICIPANTS:
        report(f"{contender}, {settings}")
        why = missing()
        own = {"transits": 0, "status": why} if why else _measured(times, duration, true)
        rows.append({"contender": contender, "settings": settings, **own})
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _measured(
    times: Callable[[float], list[Array]], duration: float, true: Sequence[Array] | None
) -> dict[str, Any]:
    times(2.0 * YEAR)  # compiles
    found, seconds = once(lambda: times(duration))
    row = {"transits": sum(map(len, found)), "seconds": seconds, "status": ""}
    if true is None:
        return {**row, "status": heyoka_engine.missing("double")}
    off = np.concatenate([_nearest(*both) for both in zip(true, found, strict=True)]) / SECOND
    lost = off > FAR
    return {**row, "lost": int(lost.sum()), "largest_s": float(off[~lost].max(initial=0.0))}


def _nearest(true: Array, found: Array) -> Array:
    """How far the nearest of the found is from each true one; inf without any."""
    both = np.concatenate([[-np.inf], found, [np.inf]])
    right = np.searchsorted(both, true)
    apart: Array = np.minimum(both[right] - true, true - both[right - 1])
    return apart
