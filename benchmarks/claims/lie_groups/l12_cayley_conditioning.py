"""L12: conditioning of the Cayley chart (H lemma 3.4.1), and of the other two.

In galvi's xi the inequalities are |Phi(xi) - Phi(zeta)| <= |xi - zeta| and |D Phi(xi) xi' -
D Phi(zeta) zeta'| <= min(|xi'|, |zeta'|) |xi - zeta| + |xi' - zeta'| in all charts; H's eta of
Cayley's chart is -xi / 2, so that H's C_G is twice the ratio in xi.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    CAYLEY,
    Array,
    DataFrame,
    Fault,
    MakeMethod,
    Measurement,
    Report,
    readings,
    row,
    rows,
    scaled,
    series,
    table_of,
)
from galvi.charts.chart import Chart, coordinates, place, tangent

GROUP, EXPONENTIAL, RODRIGUES = galvi.SO3(), galvi.Exponential(), galvi.ModifiedRodrigues()
FURTHER = (1.0, 10.0, 45.0, 90.0, 179.0, 270.0, 350.0)
ANGLES: Mapping[Chart, tuple[float, ...]] = {  # degrees
    CAYLEY: (1.0, 10.0, 20.0, 30.0, 36.0, 45.0, 90.0, 135.0, 170.0, 179.0, 179.9),
    EXPONENTIAL: FURTHER,
    RODRIGUES: FURTHER,
}
RATIO, DERIVATIVE = "largest |Phi(eta) - Phi(nu)| / |eta - nu|", "derivative over its bound"
OF_ETA = "largest derivative over 4 min(|eta'|, |nu'|) |eta - nu| + 2 |eta' - nu'|, all angles"
INVERSE = "1 / |xi|"  # xi of H's chart
MISSED = "steady turnings by 0.5 to 6 rad in a step that end otherwise than they should"
TURNS = {0.5: True, 1.0: True, 2.0: True, 3.3: False, 4.0: False, 5.0: False, 6.0: False}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """The largest ratios over the angle in degrees, in `t`; 1 / |xi| over pi minus the angle, in
    `step`; and the number of TURNS for which the success of a step is unexpected."""
    rng = np.random.default_rng(341)
    measured: list[dict[str, Any]] = []
    for chart, angles in ANGLES.items():
        report(chart.name)
        for angle in angles:
            ratios = largest_ratios(chart, math.radians(angle), 2000 if quick else 20000, rng)
            measured += rows(ratios, study=chart.name, t=angle)
    for gap in 2.0 ** -np.arange(1.0, 21.0):
        c, s = math.cos(gap), math.sin(gap)
        turn = np.array([[-c, -s, 0.0], [s, -c, 0.0], [0.0, 0.0, 1.0]])  # by pi - gap
        xi = coordinates(CAYLEY, GROUP, np.eye(3), turn)
        measured.append(row(quantity=INVERSE, step=gap, value=2.0 / np.linalg.norm(xi)))
    method = make_method(galvi.Polynomials(7), galvi.gauss(8))
    body = galvi.problems.free_rigid_body(velocity=(0.0, 0.0, 1.0))
    unexpected = sum(galvi.integrate(body, method, h, 1).success != TURNS[h] for h in TURNS)
    return table_of([*measured, row(quantity=MISSED, value=unexpected)])


def largest_ratios(
    chart: Chart, angle: float, pairs: int, rng: np.random.Generator
) -> dict[str, float]:
    """The largest ratios of both inequalities over random pairs of rotations by at most `angle`
    radians, and over one pair near 0."""
    poles = {CAYLEY: 2.0, RODRIGUES: 4.0}  # k of |xi| = k tan(angle / k)
    size = poles[chart] * math.tan(angle / poles[chart]) if chart in poles else angle
    lengths = size * rng.random(pairs), size * 10.0 ** rng.uniform(-3.0, 0.0, pairs)
    first, difference = (length[:, None] * directions(pairs, rng) for length in lengths)
    second = first + difference
    second *= np.minimum(1.0, size / np.linalg.norm(second, axis=1))[:, None]
    axis = directions(1, rng)
    near_zero = 1e-4 * min(size, 1.0) * axis
    xi = np.stack([np.vstack([first, near_zero]), np.vstack([second, -near_zero])])
    rate = np.stack([np.vstack([rng.standard_normal((pairs, 3)), axis]) for _ in range(2)])
    R = place(chart, GROUP, np.eye(3), xi)
    w = np.einsum("ikab,ikb->ika", tangent(chart, GROUP, xi), rate)
    slope = np.cross(R, w[:, :, None, :])  # R hat(w), whose rows are R_i x w
    gap = np.linalg.norm(xi[0] - xi[1], axis=1)
    allowed = np.min(np.linalg.norm(rate, axis=2), axis=0) * gap
    allowed += np.linalg.norm(rate[0] - rate[1], axis=1)
    return {
        RATIO: np.max(np.linalg.norm(R[0] - R[1], ord=2, axis=(1, 2)) / gap),
        DERIVATIVE: np.max(np.linalg.norm(slope[0] - slope[1], ord=2, axis=(1, 2)) / allowed),
    }


def directions(count: int, rng: np.random.Generator) -> Array:
    """Random unit vectors, (count, 3)."""
    v = rng.standard_normal((count, 3))
    return v / np.linalg.norm(v, axis=1)[:, None]


def read(table: DataFrame) -> dict[str, Measurement]:
    """The largest ratios of each chart, for Cayley's also the angle up to which C_G is 2; the order
    at which 1 / |xi| vanishes; and the number of unexpected steps."""
    angles, ratios = series(table, "t", study=CAYLEY.name, quantity=RATIO)
    beyond = np.min(angles[2.0 * ratios > 2.0 + 1e-9], initial=np.inf)
    proved = angles <= 36.9  # where 2 |eta| + |nu| = 1 for equal sizes
    numbers: dict[str, Measurement] = {
        "constant of the chart, angles up to 37 degrees": 2.0 * np.max(ratios[proved]),
        "angle up to which the constant is 2 [degrees]": np.max(
            angles[angles < beyond], initial=0.0
        ),
        OF_ETA: readings.largest_of(table, study=CAYLEY.name, quantity=DERIVATIVE),
        f"order at which {INVERSE} vanishes towards a turn by pi": readings.order(
            table, 0.0, quantity=INVERSE
        ),
        MISSED: readings.largest_of(table, quantity=MISSED),
    }
    for chart in (EXPONENTIAL, RODRIGUES):
        for quantity in (RATIO, DERIVATIVE):
            largest = readings.largest_of(table, study=chart.name, quantity=quantity)
            numbers[f"{quantity}, {chart.name} chart, all angles"] = largest
    return numbers


FAULTS = {
    f"{word} {function}": Fault(wrong={f"{__name__}.{function}": scaled(by)})
    for function in ("place", "tangent")
    for word, by in (("larger", 1.0 + 1e-6), ("smaller", 1.0 - 1e-6))
}
FAULTS["a chart that reaches farther"] = Fault(
    make=lambda space, rule: galvi.Galerkin(space, rule, EXPONENTIAL)
)
