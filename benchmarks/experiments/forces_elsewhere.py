"""Forces of position in the Kepler frame and in a clock: errors when the step is halved.

    python -m benchmarks.experiments.forces_elsewhere

A star, a planet with a moon and a farther one, to a given time, against 16 stages in short steps in
the inertial frame; each row has the errors, the last order from one to the next, and the same
without the force, which is what no kick would leave.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import galvi

MASSES = [1.0, 1e-3, 1e-5, 2e-4]
TIME = 12.0
TREE = (0, (1, 2), 3)
FORCES = {
    "J2 of the star": galvi.Oblateness(0, 1e-3, 0.3, J4=-1e-4, pole=(0.3, 0.1, 1.0)),
    "J2 of the planet": galvi.Oblateness(1, 1e-2, 0.01, pole=(0.2, 0.4, 1.0)),
    "power law": galvi.PowerLaw(0, -1e-2, -2.5),
    "potential": galvi.Relativity(30.0, form="potential"),
}
EVEN = galvi.KeplerFrame(even=True)
PLACES: dict[str, tuple[dict[str, Any], tuple[float, ...], int]] = {
    "star and planets": ({"chart": EVEN}, (0.4, 0.2, 0.1), 2),
    "hierarchy": ({"chart": galvi.KeplerFrame(even=True, hierarchy=TREE)}, (0.02, 0.01, 0.005), 2),
    "DynamicalTime": ({"clock": galvi.DynamicalTime()}, (0.8, 0.4, 0.2), 4),
}


def bodies(forces: Any, moon: bool) -> galvi.Problem:
    """The bodies, with the moon or without."""
    q = np.array([[0.0, 0.0, 0.0], [1.0, 0.1, 0.2], [1.012, 0.1, 0.2], [-0.3, 2.1, 0.1]])
    v = np.array([[0.0, 0.0, 0.0], [0.1, 0.95, 0.1], [0.1, 1.239, 0.12], [-0.65, -0.1, 0.05]])
    kept = [0, 1, 2, 3] if moon else [0, 1, 3]
    return galvi.Problem(galvi.NBody(np.array(MASSES)[kept], forces=forces), q[kept], v[kept])


def errors(place: str, force: str) -> tuple[list[float], float, float]:
    """At the steps of a place; the order from the last two; and how far the force moves the end."""
    given, steps, s = PLACES[place]
    moon = place == "hierarchy"
    forced, plain = bodies(FORCES[force], moon), bodies((), moon)
    fine = galvi.Galerkin(galvi.Polynomials(16), galvi.gauss(16))
    true, unforced = (
        galvi.integrate(one, fine, TIME / 2400, 2400, save_every=2400).q[-1]
        for one in (forced, plain)
    )
    used = galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s), **given)
    found = []
    for step in steps:
        run = galvi.integrate(forced, used, step, duration=TIME)
        assert run.success, run.status
        found.append(float(np.max(np.abs(run.q[-1] - true))))
    order = np.log2(found[-2] / found[-1]) / np.log2(steps[-2] / steps[-1])
    return found, float(order), float(np.max(np.abs(true - unforced)))


if __name__ == "__main__":
    for place, (_, steps, s) in PLACES.items():
        print(f"{place}: {s} stages, order {2 * s}, steps {', '.join(map(str, steps))}")
        for force in FORCES:
            found, order, moved = errors(place, force)
            print(f"    {force:17} {'  '.join(f'{x:.1e}' for x in found)}  order {order:5.2f}"
                  f"   without the force {moved:.1e}")  # fmt: skip
