"""What is said about bad input to Lagrangians and groups, and systems that are stored."""

import pickle
from functools import cache

import numpy as np
import pytest

import galvi
from tests.galvi.lagrangians import METHOD, MOMENTS, swinging


@cache
def swinging_run():
    return galvi.integrate(swinging(1.0), METHOD, 0.1, 1)


def test_the_energy_of_a_lagrangian_at_no_times_is_empty():
    run = swinging_run()
    assert galvi.energy(run, []).shape == (0,)
    assert galvi.energy(run, [0.05]) == pytest.approx(galvi.energy(run)[:1], abs=1e-6)


@pytest.mark.parametrize(
    "system",
    [
        galvi.RigidBody(MOMENTS, galvi.UniformGravity(1.0, (0.0, 0.0, 1.0))),
        galvi.RigidBody(MOMENTS, np.sum, explicit_time=True),
        galvi.FreeBody(1.0, MOMENTS),
        galvi.UniformGravity(1.0, (0.0, 0.0, 1.0)),
    ],
    ids=lambda system: type(system).__name__,
)
def test_a_pickled_system_comes_back_equal_and_read_only(system):
    copy = pickle.loads(pickle.dumps(system))
    for name, value in vars(system).items():
        if isinstance(value, np.ndarray):
            assert np.array_equal(getattr(copy, name), value)
            assert not getattr(copy, name).flags.writeable
    assert getattr(copy, "explicit_time", None) == getattr(system, "explicit_time", None)


@pytest.mark.skipif(not galvi.FAST, reason="a mass by differences is not exactly singular")
def test_the_velocities_that_change_no_momentum_are_named():
    system = galvi.Lagrangian(lambda q, v: 0.5 * (v[0] + 100.0 * v[1]) ** 2 - q @ q, galvi.Rn(2))
    problem = galvi.Problem(system, [1.0, 1.0], [0.3, 0.2])
    with pytest.raises(ValueError, match=r"degenerate .* along v\[0\] - 0\.01 v\[1\]\."):
        galvi.integrate(problem, METHOD, 0.1, 1)
