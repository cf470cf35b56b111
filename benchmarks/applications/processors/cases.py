"""A run in each kernel; run as a script: final states for the CPU in NUMBA_CPU_NAME.

NUMBA_CPU_NAME, set before numba is imported, names the processor for which kernels are compiled,
and NUMBA_CPU_FEATURES, empty, that no instructions of this machine's are used besides.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from typing import Any

import galvi

STEPS = 100
Gauss = tuple[int, int]


def _method(gauss: Gauss, chart: Any = None) -> galvi.Galerkin:
    degree, points = gauss
    pair = galvi.Polynomials(degree), galvi.gauss(points)
    return galvi.Galerkin(*pair) if chart is None else galvi.Galerkin(*pair, chart)


# what runs -> (problem, method, step, further options)
CASES: Mapping[str, tuple[Callable[[], galvi.Problem], galvi.Galerkin, float, dict[str, Any]]] = {
    "point masses, lanes": (galvi.problems.outer_solar_system, _method((8, 8)), 200.0, {}),
    "point masses, Newton": (
        galvi.problems.outer_solar_system, _method((8, 8)), 200.0, {"solver": "newton"},
    ),
    "planets in the Kepler frame": (
        galvi.problems.outer_solar_system, _method((8, 8), galvi.KeplerFrame()), 400.0, {},
    ),
    "springs in the harmonic frame": (
        galvi.problems.fermi_pasta_ulam_tsingou, _method((8, 8), galvi.HarmonicFrame()), 0.5, {},
    ),
    "a built-in potential": (galvi.problems.henon_heiles, _method((8, 8)), 0.2, {}),
    "a Lagrangian": (galvi.problems.double_pendulum, _method((8, 8)), 0.05, {}),
    "a Lagrangian, more points": (galvi.problems.double_pendulum, _method((8, 9)), 0.05, {}),
    "a Lagrangian, Newton": (
        galvi.problems.double_pendulum, _method((8, 8)), 0.05, {"solver": "newton"},
    ),
    "a rigid body": (galvi.problems.free_rigid_body, _method((8, 8)), 0.2, {}),
    "a heavy top, Newton": (
        galvi.problems.heavy_top, _method((8, 9)), 0.02, {"solver": "newton"},
    ),
    "a body on SE(3)": (galvi.problems.free_body_se3, _method((8, 8)), 0.1, {}),
    "a tree of bodies": (galvi.problems.skew_arm, _method((8, 8)), 0.02, {}),
}  # fmt: skip


def ends() -> dict[str, dict[str, Any]]:
    """The last state of each run, as hexadecimal numbers, its status and iterations."""
    found = {}
    for name, (problem, method, step, options) in CASES.items():
        run = galvi.integrate(problem(), method, step, STEPS, **options)
        found[name] = {
            "q": [float(x).hex() for x in run.q[-1].ravel()],
            "p": [float(x).hex() for x in run.p[-1].ravel()],
            "status": run.status,
            "iterations": run.counts["iterations"],
        }
    return found


if __name__ == "__main__":
    json.dump(ends(), sys.stdout)
