"""V9: the solar system in steps longer than Mercury's year (H figure 2.14)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks import verdicts
from benchmarks.claim import Claim, MakeMethod, Report, Row
from benchmarks.errors import PER_STEP, curve_times, energy_errors
from benchmarks.orbit_shape import angle, extent, perihelion, period
from benchmarks.refinement import method_of
from benchmarks.tidy import frame, number, pick, row
from galvi import Problem, Trajectory
from references import ias15

STEP, STEPS = 100.0, 100
N, HIGHER = 25, 41
SAMPLES = 5000  # of the orbits, every 2 days
INNER = ("Mercury", "Venus", "Earth", "Mars")  # those of H figure 2.14
SETUP = (
    "Sun, 8 planets, Pluto; JPL DE421 states of 2000-01-01 (JD 2451544.5 TDB), au and days; "
    f"Polynomials(n - 1), gauss(2 n), n = %d; h = {STEP:g} d, {STEPS} steps"
)
DISTANCE, AT_END = "distance to IAS15", "distance to IAS15 at the end"
ENERGY = "energy error"
CHANGE, DIFFERENCE = "change of extent", "extent against IAS15"
TURN = "perihelion against IAS15"


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series, with the body in `label` (au, rad, relative for the energy):

    'n = 25', 'n = 41'  distance to IAS15, largest over step ends and at the end; energy error
    'shape'             extents over the first and the last revolution, their change relative to the
                        mean distance, their difference from IAS15's, the perihelion's direction
    'orbit'             places from the Sun, 'position on the curve' and 'position at step ends'
    'reference'         distance between IAS15 with its two step criteria, at the end
    """
    problem = galvi.problems.solar_system()
    report("IAS15")
    duration = STEP * STEPS
    truth = ias15.IAS15.run(problem, duration, {"samples": SAMPLES})
    other = ias15.IAS15.run(problem, duration, {"samples": 1, **ias15.GLOBAL})
    bodies = problem.parameters["bodies"]
    gap = np.linalg.norm(truth.q[-1] - other.q[-1], axis=-1)
    rows = [
        row(study="reference", quantity=AT_END, label=body, value=gap[k])
        for k, body in enumerate(bodies)
    ]
    for n in (N, HIGHER):
        report(f"n = {n}, {STEPS} steps of {STEP:g} d")
        run = galvi.integrate(problem, method_of(make_method, n), STEP, STEPS)
        rows += _errors(run, truth, n, bodies)
        if n == N:
            rows += _orbits(run, bodies) + _shapes(problem, run, truth, bodies)
    return frame(rows)


def _errors(run: Trajectory, truth: Trajectory, n: int, bodies: tuple[str, ...]) -> Any:
    settings = {
        "study": f"n = {n}",
        "n": n,
        "step": STEP,
        "steps": STEPS,
        "status": "" if run.success else run.status,
        "force_evaluations": run.counts["force_evaluations"],
    }
    distance = np.linalg.norm(run.q - truth.q[:: SAMPLES // STEPS], axis=-1)
    energy = float(np.max(np.abs(energy_errors(run))))
    rows = [row(quantity=ENERGY, value=energy, **settings)]
    for k, body in enumerate(bodies):
        largest = float(np.max(distance[:, k]))
        rows.append(row(quantity=DISTANCE, label=body, value=largest, **settings))
        rows.append(row(quantity=AT_END, label=body, value=distance[-1, k], **settings))
    return rows


def _orbits(run: Trajectory, bodies: tuple[str, ...]) -> Any:
    times = curve_times(run, PER_STEP)
    rows = []
    for quantity, t, q in (
        ("position on the curve", times, run(times)),
        ("position at step ends", run.t, run.q),
    ):
        place = q - q[:, :1]
        for k, body in enumerate(bodies):
            rows += [
                row(study="orbit", quantity=quantity, n=N, label=body, t=s, x=x, y=y, z=z)
                for s, (x, y, z) in zip(t, place[:, k], strict=True)
            ]
    return rows


def _shapes(problem: Problem, run: Trajectory, truth: Trajectory, bodies: Any) -> Any:
    q, end = run(truth.t), float(truth.t[-1])
    rows = []
    for body in INNER:
        k = bodies.index(body)
        year = period(problem, k)
        first, last, exact = (
            np.array(extent(truth.t, places, k, start, start + year))
            for places, start in ((q, 0.0), (q, end - year), (truth.q, end - year))
        )
        turned = angle(perihelion(run, k)[-1], perihelion(truth, k)[-1])
        for quantity, value in (
            ("closest distance, first revolution", first[0]),
            ("farthest distance, first revolution", first[1]),
            ("closest distance, last revolution", last[0]),
            ("farthest distance, last revolution", last[1]),
            (CHANGE, np.max(np.abs(last - first)) / np.mean(first)),
            (DIFFERENCE, np.max(np.abs(last - exact))),
            (TURN, turned),
        ):
            rows.append(row(study="shape", quantity=quantity, n=N, label=body, value=value))
    return rows


def judge(table: pd.DataFrame) -> list[Row]:
    """Near IAS15, energy kept, orbits closed and in place; the same again with n = 41."""
    long_step = (
        "In a step of 100 days Mercury does more than a revolution; 25 basis functions resolve it "
        "to about 1e-4, and slower planets far better."
    )
    closed = (
        "The radii of the inner planets return to within what the other planets change them, in "
        "IAS15's orbits as in these; the method adds no visible precession."
    )
    higher = "Mercury's error falls geometrically with n; at n = 41 it is resolved to 1e-9."
    return [
        _row("Mercury, distance to IAS15 at the end [au]", N, 2e-4, long_step,
             number(table, study=f"n = {N}", quantity=AT_END, label="Mercury")),
        _row("Earth, distance to IAS15 at the end [au]", N, 1e-9, long_step,
             number(table, study=f"n = {N}", quantity=AT_END, label="Earth")),
        _row("energy error", N, 1e-9, "The method is symplectic; what is left is Mercury's "
             "truncation error, weighted by its small mass.",
             number(table, study=f"n = {N}", quantity=ENERGY)),
        _row("change of the inner orbits' extent, first to last revolution [mean distance]", N,
             1e-3, closed, _worst(table, CHANGE)),
        _row("extent of the inner orbits in the last revolution, against IAS15 [au]", N, 1e-4,
             closed, _worst(table, DIFFERENCE)),
        _row("direction of the inner perihelia at the end, against IAS15 [rad]", N, 5e-3, closed,
             _worst(table, TURN)),
        _row("Mercury, distance to IAS15 at the end [au]", HIGHER, 1e-8, higher,
             number(table, study=f"n = {HIGHER}", quantity=AT_END, label="Mercury")),
        _row("energy error", HIGHER, 1e-13, "With Mercury resolved, energy is kept to round-off.",
             number(table, study=f"n = {HIGHER}", quantity=ENERGY)),
    ]  # fmt: skip


def _worst(table: pd.DataFrame, quantity: str) -> float:
    """The largest over the inner planets; NaN when one is missing."""
    values = pick(table, study="shape", quantity=quantity)["value"].to_numpy()
    return float(np.max(values)) if values.size == len(INNER) else float("nan")


def _row(quantity: str, n: int, limit: float, reason: str, measured: float) -> Row:
    return Row(
        id="V9",
        quantity=f"{quantity}, n = {n}",
        source="H fig. 2.14",
        setup=SETUP % n,
        claimed="closed, stable orbits although h exceeds Mercury's period",
        bound=f"at most {limit:g}",
        measured=measured,
        uncertainty=None,
        expected=verdicts.HOLDS,
        reason=reason,
        reference="initial energy" if "energy" in quantity else ias15.IAS15.name,
        verdict=verdicts.bound(measured, limit),
    )


V9 = Claim(
    "V9",
    "Solar system at h = 100 d: closed, stable orbits beyond Mercury's period",
    study,
    judge,
    ("H fig. 2.14",),
)
