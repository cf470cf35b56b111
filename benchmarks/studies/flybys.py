"""Close passages that are found, missed and misjudged, where each code looks for them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.statistics.timing import once
from benchmarks.work_precision.problem import galvi_label
from benchmarks.work_precision.problems.encounters import clock_label
from galvi import Problem
from references.heyoka import engine as heyoka_engine
from references.heyoka.passages import passages
from references.rebound import passages as rebound_passages
from references.rebound import simulation as rebound_simulation
from references.stored.flybys import BODIES, DURATION, KM, METEOROID, flybys, hill_radius

COLUMNS = (
    "contender", "looks", "target", "flybys", "missed", "median_km", "largest_km",
    "largest_relative", "seconds", "status",
)  # fmt: skip
SOME, QUICK = 299, 40  # flybys, evenly from all; when quick
HOURS, DAYS = 2.9 / 24.0, 73.0  # between outputs
WITHIN = 4.0  # Hill radii: what comes no nearer is no encounter
EXPLANATION = (
    "A massless body passes the Moon, Mercury, the Earth or Jupiter once in 365 days, at 5 to 70 "
    "km/s and at impact parameters to 3.5 Hill radii; 299 of 1,196 such flybys are here, and all "
    "by `python -m benchmarks.studies.flybys`. The least distance is known from heyoka in "
    "quadruple precision. Missed is an encounter of which nothing within 4 Hill "
    "radii is seen; errors are those of the least distance, of the others. REBOUND has no events: "
    "its users look at outputs, at ends of steps, or at cubics between those. The author of a tool "
    "that did so reported 25 of 104 encounters with Mercury missed, and distances wrong by up to "
    "215 % (wmpg/WesternMeteorPyLib#99). heyoka's integrator is the one that compiles in a second "
    "(compact_mode). A time is that of one run, with its search."
)
Nearest = Callable[[Problem, int], float]  # the distance that is found, inf without any


def _by_galvi(method: galvi.Galerkin, step: float) -> Nearest:
    def nearest(problem: Problem, target: int) -> float:
        run = galvi.integrate(problem, method, step, duration=DURATION)
        if not run.success:
            return np.nan
        found = galvi.find_events(run, galvi.events.closest_approach(METEOROID, target))
        return min(found.value.tolist(), default=np.inf)

    return nearest


def _by_heyoka(problem: Problem, target: int) -> float:
    gap = passages(problem, [(METEOROID, target)], DURATION, {"compact_mode": True})[2]
    return min((float(np.linalg.norm(one)) for one in gap), default=np.inf)


def _by_rebound(every: float | None, seen: Callable[..., tuple[float, float]]) -> Nearest:
    def nearest(problem: Problem, target: int) -> float:
        states = rebound_passages.relative_states(problem, METEOROID, target, DURATION, every)
        return seen(*states)[1]

    return nearest


def _method(**clock: Any) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), **clock)


SAMPLES, CUBICS = rebound_passages.nearest_sample, rebound_passages.nearest_on_cubics
IAS15 = "REBOUND IAS15"
PARTICIPANTS: tuple[tuple[str, str, Nearest, Callable[[], str]], ...] = (
    (clock_label(8), "events, step=0.2", _by_galvi(_method(clock=galvi.DynamicalTime()), 0.2), str),
    (galvi_label(8), "events, step=0.5 d", _by_galvi(_method(), 0.5), str),
    ("heyoka", "events", _by_heyoka, lambda: heyoka_engine.missing("double")),
    (IAS15, "outputs every 73 d", _by_rebound(DAYS, SAMPLES), rebound_simulation.missing),
    (IAS15, "outputs every 2.9 h", _by_rebound(HOURS, SAMPLES), rebound_simulation.missing),
    (IAS15, "ends of steps", _by_rebound(None, SAMPLES), rebound_simulation.missing),
    (IAS15, "cubics between steps", _by_rebound(None, CUBICS), rebound_simulation.missing),
)


def flybys_table(
    quick: bool = False, report: Callable[[str], None] = lambda sentence: None, every: bool = False
) -> pd.DataFrame:
    """A row for flybys at the Moon and one for those at planets, of each contender.

    every  all flybys, not a part of them
    """
    known = flybys()
    count = len(known.t) if every else QUICK if quick else SOME
    chosen = np.linspace(0, len(known.t) - 1, count).astype(int)
    rows = []
    for contender, looks, nearest, missing in PARTICIPANTS:
        report(f"{contender}, {looks}")
        lunar = known.targets[chosen] == BODIES.index("Moon")
        for target, some in (("Moon", chosen[lunar]), ("planets", chosen[~lunar])):
            why = missing()
            own = {"flybys": 0, "status": why} if why else _measured(nearest, some)
            rows.append({"contender": contender, "looks": looks, "target": target, **own})
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _measured(nearest: Nearest, chosen: Any) -> dict[str, Any]:
    known = flybys()
    nearest(known.problem(chosen[0]), int(known.targets[chosen[0]]))  # compiles
    found, seconds = [], []
    for k in chosen.tolist():
        problem, target = known.problem(k), int(known.targets[k])
        distance, time = once(lambda: nearest(problem, target))  # noqa: B023
        found.append(distance)
        seconds.append(time)
    distance, true = np.array(found), known.distance[chosen]
    limit = WITHIN * np.array([hill_radius(int(one)) for one in known.targets[chosen]])
    failed, seen = np.isnan(distance), distance <= limit
    error = np.abs(distance - true)[seen]
    middle, most, share = (
        (float(np.median(error)), float(error.max()), float((error / true[seen]).max()))
        if error.size
        else (np.nan,) * 3
    )
    return {
        "flybys": len(chosen), "missed": int(np.sum(~seen & ~failed)), "median_km": middle / KM,
        "largest_km": most / KM, "largest_relative": share, "seconds": float(np.median(seconds)),
        "status": f"{failed.sum()} runs failed" if failed.any() else "",
    }  # fmt: skip


if __name__ == "__main__":
    print(flybys_table(every=True).to_string())
