"""Forces of position keep the order in the Kepler frame, in a hierarchy and in a clock."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import galvi

MASSES = np.array([1.0, 1e-3, 1e-5, 2e-4])  # a star, a planet with a moon, and one farther out
Q0 = np.array([[0.0, 0.0, 0.0], [1.0, 0.1, 0.2], [1.012, 0.1, 0.2], [-0.3, 2.1, 0.1]])
V0 = np.array([[0.0, 0.0, 0.0], [0.1, 0.95, 0.1], [0.1, 1.239, 0.12], [-0.65, -0.1, 0.05]])
J2_OF_THE_PLANET = galvi.Oblateness(1, 1e-2, 0.01, pole=(0.2, 0.4, 1.0))
DURATION = 12.0
ALL, WITHOUT_MOON = [0, 1, 2, 3], [0, 1, 3]
# Name -> indices of the bodies, options of the method, its two steps, and its stages.
CASES: dict[str, tuple[list[int], dict[str, Any], tuple[float, float], int]] = {
    "star and planets": (WITHOUT_MOON, {"chart": galvi.KeplerFrame(even=True)}, (0.2, 0.1), 2),
    "hierarchy": (
        ALL,
        {"chart": galvi.KeplerFrame(even=True, hierarchy=(0, (1, 2), 3))},
        (0.01, 0.005),
        2,
    ),
    "clock": (WITHOUT_MOON, {"clock": galvi.DynamicalTime()}, (0.4, 0.2), 4),
}


def end_positions(bodies: list[int], forces: Any, stages: int, step: float, **options: Any) -> Any:
    problem = galvi.Problem(galvi.NBody(MASSES[bodies], forces=forces), Q0[bodies], V0[bodies])
    method = galvi.Galerkin(galvi.Polynomials(stages), galvi.gauss(stages), **options)
    run = galvi.integrate(problem, method, step, duration=DURATION)
    assert run.success, run.status
    return run.q[-1]


@pytest.mark.parametrize("name", CASES)
def test_a_force_of_position_keeps_the_order(name: str) -> None:
    bodies, options, steps, stages = CASES[name]
    truth, unforced = (end_positions(bodies, force, 16, 0.005) for force in (J2_OF_THE_PLANET, ()))
    errors = [
        np.abs(end_positions(bodies, J2_OF_THE_PLANET, stages, step, **options) - truth).max()
        for step in steps
    ]
    assert abs(np.log2(errors[0] / errors[1]) - 2 * stages) < 0.3  # 4.02, 4.00, 7.98
    assert 100.0 * errors[1] < np.abs(truth - unforced).max() > 1e-6
