"""Print the coefficients of galvi.fast.lanes.functions, with the error of each series.

    python -m benchmarks.experiments.function_coefficients

Each series is the polynomial that agrees with the function at Chebyshev points, in 40 digits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath as mp

DIGITS = 40
WIDER = 1.0001  # of the interval, for arguments whose reduction is rounded
NEAR_ZERO = 1e-9  # below, the functions are evaluated by the first terms of their series
Function = Callable[[Any], Any]


def series(function: Function, low: Any, high: Any, degree: int) -> list[Any]:
    """Coefficients, ascending, of the interpolating polynomial at Chebyshev points."""
    half = (high - low) / 2
    nodes = [
        low + half + half * mp.cos(mp.pi * (2 * k + 1) / (2 * degree + 2))
        for k in range(degree + 1)
    ]
    matrix = mp.matrix([[x**j for j in range(degree + 1)] for x in nodes])
    return list(mp.lu_solve(matrix, mp.matrix([function(x) for x in nodes])))


def tables() -> dict[str, tuple[Function, Any, Any, int]]:
    """Name -> (function of z, interval, degree)."""
    quarter, binary = (mp.pi / 4) ** 2 * WIDER, mp.log(2) / 2 * WIDER
    ratio = ((mp.sqrt(2) - 1) / (mp.sqrt(2) + 1)) ** 2 * WIDER
    eighth = mp.tan(mp.pi / 8) ** 2 * WIDER
    root = mp.sqrt

    def near(z: Any, limit: Any, function: Function) -> Any:
        return limit if abs(z) < NEAR_ZERO else function(z)

    return {
        "SINE": (  # sin x = x + x^3 SINE(x^2)
            lambda z: near(z, -mp.mpf(1) / 6, lambda z: (mp.sin(root(z)) / root(z) - 1) / z),
            mp.mpf(0), quarter, 6,
        ),
        "COSINE": (  # cos x = 1 - x^2 / 2 + x^4 COSINE(x^2)
            lambda z: near(z, mp.mpf(1) / 24, lambda z: (mp.cos(root(z)) - 1 + z / 2) / z**2),
            mp.mpf(0), quarter, 6,
        ),
        "EXPONENTIAL": (  # exp x = 1 + x + x^2 EXPONENTIAL(x)
            lambda z: near(z, mp.mpf(1) / 2, lambda z: (mp.exp(z) - 1 - z) / z**2),
            -binary, binary, 11,
        ),
        "LOGARITHM": (  # log((1 + s) / (1 - s)) = 2 s + s^3 (2 / 3 + s^2 LOGARITHM(s^2))
            lambda z: near(
                z, mp.mpf(2) / 5,
                lambda z: ((2 * mp.atanh(root(z)) / root(z) - 2) / z - mp.mpf(2) / 3) / z,
            ),
            mp.mpf(0), ratio, 7,
        ),
        "ARCTANGENT": (  # atan x = x + x^3 ARCTANGENT(x^2)
            lambda z: near(z, -mp.mpf(1) / 3, lambda z: (mp.atan(root(z)) / root(z) - 1) / z),
            mp.mpf(0), eighth, 11,
        ),
    }  # fmt: skip


def main() -> None:
    """Print the tables as Python source."""
    mp.mp.dps = DIGITS
    for name, (function, low, high, degree) in tables().items():
        found = series(function, low, high, degree)
        worst = max(
            abs(mp.polyval(found[::-1], z) - function(z)) for z in mp.linspace(low, high, 301)[1:]
        )
        print(f"{name} = (  # to {mp.nstr(worst, 2)}")
        for coefficient in found:
            print(f"    {float(coefficient)!r},")
        print(")")
    for name, value, bits in (
        ("HALF_PI", mp.pi / 2, (53, 53)),
        ("QUARTER_TURN", mp.pi / 2, (33, 53, 53)),  # multiples of its first part are exact, as
        ("LOG_2", mp.log(2), (42, 42)),  # here
        ("TWO_THIRDS", mp.mpf(2) / 3, (53, 53)),
    ):
        parts = []
        for precision in bits:
            with mp.workprec(precision):
                parts.append(float(+value))
            value -= parts[-1]
        print(f"{name} = {tuple(parts)!r}")


if __name__ == "__main__":
    main()
