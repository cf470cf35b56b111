"""The label of an error's axis, with the unit of its problem."""

from __future__ import annotations

from benchmarks.work_precision.problem import ANGLE, ATTITUDE, COORDINATES, MOTION, POSITION

WORDS = {
    POSITION: "error of the position at the end",
    ATTITUDE: "error of the attitude at the end, largest entry of $R - R_{true}$",
    ANGLE: "error of the angles at the end",
    COORDINATES: "error of the coordinates at the end",
    MOTION: "error of attitude and place at the end",
}
DIMENSIONLESS = "1"
OF_QUANTITY = {ANGLE: "rad", ATTITUDE: DIMENSIONLESS}
OF_PROBLEM = {  # where a problem's name begins so
    "outer solar system": "au",
    "solar system": "au",
    "kepler e=0.6": "semi-major axis",
    "kepler e=0.3 in polar": "semi-major axis, rad",
    "brownout": "m",
    "skew arm": "rad",
    "floating arm": "1, m, rad",
    "free body on SE(3)": "1, unit of length",
    "elastic pendulum": "unit of length, rad",
}


def error_label(problem: str, quantity: str) -> str:
    """E.g. "error of the position at the end [au]"; [1] where lengths have no unit."""
    known = next((unit for name, unit in OF_PROBLEM.items() if problem.startswith(name)), None)
    unit = OF_QUANTITY.get(quantity) or known or DIMENSIONLESS
    return f"{WORDS.get(quantity, f'error of the {quantity} at the end')} [{unit}]"
