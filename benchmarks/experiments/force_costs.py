"""What a force costs: the time of a step of six bodies with it, over that without.

    python -m benchmarks.experiments.force_costs

The Sun and the outer planets at degree 8 and 200 days: the Sun's J2, the potential of general
relativity and a power law in lanes; in the general kernel the same without and with forces of
velocity. The least of interleaved runs.
"""

from __future__ import annotations

import time
from typing import Any

import galvi

ROUNDS = 7
STEP = 200.0  # days
SPEED = 173.14463  # of light, au / day


def costs() -> list[tuple[str, float, float]]:
    """(name, microseconds a step, over the plain step of the same kernel) of each force."""
    outer: Any = galvi.problems.outer_solar_system()
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    none = [0.0] * len(outer.q0)
    in_lanes: dict[str, Any] = {
        "none": (), "J2": galvi.Oblateness(0, 2e-7, 4.65e-3),
        "potential": galvi.Relativity(SPEED, form="potential"),
        "power law": galvi.PowerLaw(0, 1e-12, -2.5),
    }  # fmt: skip
    general: dict[str, Any] = {
        "none, forces of velocity": galvi.Drag(none), "one source": galvi.Relativity(SPEED),
        "EIH": galvi.Relativity(SPEED, form="EIH"),
        "radiation": galvi.Radiation([0.0, *[1e-12] * (len(none) - 1)], SPEED),
        "tides": galvi.Tides(0, 0.03, 4.65e-3, 1e-3),
    }  # fmt: skip
    rows = []
    for forces, steps in ((in_lanes, 20_000), (general, 200)):
        problems = {
            name: galvi.Problem(
                galvi.NBody(outer.system.masses, outer.system.G, force), outer.q0, outer.v0
            )
            for name, force in forces.items()
        }
        best = dict.fromkeys(problems, float("inf"))
        for _ in range(ROUNDS):
            for name, problem in problems.items():
                begin = time.perf_counter()
                galvi.integrate(problem, method, STEP, steps, save_every=steps)
                best[name] = min(best[name], time.perf_counter() - begin)
        plain = next(iter(best.values()))
        rows += [(name, 1e6 * each / steps, each / plain) for name, each in best.items()]
    return rows


if __name__ == "__main__":
    for name, microseconds, ratio in costs():
        print(f"{name:26} {microseconds:9.2f} us a step  {ratio:6.2f}")
