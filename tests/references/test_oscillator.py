"""The oscillator's closed form against 50-digit arithmetic."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest

import galvi
from references.closed_forms.oscillator import OSCILLATOR

EPS = 2.0**-52


@pytest.mark.parametrize("t", [1e-9, 0.3, 31.0, -400.0, 1e6])
def test_every_component_is_its_own_oscillator(t):
    mass, q0, v0 = [0.3, 2.0, 7.0], [1.0, -2.0, 0.5], [0.2, 3.0, 0.0]
    problem = galvi.Problem(galvi.Canonical(mass, galvi.LinearSpring(1.7)), q0, v0)
    run = OSCILLATOR.run(problem, t, {})
    with mp.workdps(50):
        for k in range(3):
            w = mp.sqrt(mp.mpf(1.7) / mp.mpf(mass[k]))
            q = q0[k] * mp.cos(w * t) + v0[k] / w * mp.sin(w * t)
            v = v0[k] * mp.cos(w * t) - w * q0[k] * mp.sin(w * t)
            size = mp.hypot(q, v / w)
            # 0.33 was measured when the factor 4 was set
            assert abs(run.q[-1, k] - q) <= 4 * EPS * float(size * (1 + w * abs(t)))
            assert abs(run.p[-1, k] / mass[k] - v) <= 4 * EPS * float(w * size * (1 + w * abs(t)))


def test_a_coupling_mass_is_refused():
    mass = np.array([[2.0, 1.0], [1.0, 2.0]])
    system = galvi.Canonical(mass, galvi.LinearSpring(1.0))
    assert not OSCILLATOR.supports(galvi.Problem(system, [1.0, 0.0], [0.0, 0.0]))
