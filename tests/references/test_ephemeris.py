"""DE421 as a trajectory, and what point masses miss of it."""

import numpy as np
import pytest

import galvi
from references.jpl import states as jpl
from references.jpl.ephemeris import JPL_EPHEMERIS, differences
from references.stored.planets import STORED_TRUTH

SOLAR = galvi.problems.solar_system()
needs_jpl = pytest.mark.skipif(bool(jpl.missing()), reason=jpl.missing() or "present")


@needs_jpl
def test_it_starts_where_the_problem_does_and_moves_as_its_velocity_says():
    run = JPL_EPHEMERIS.run(SOLAR, 0.25, {"samples": 2})
    assert np.array_equal(run.q[0], SOLAR.q0)
    v = run.p / SOLAR.system.masses[:, None]
    np.testing.assert_allclose((run.q[2] - run.q[0]) / 0.25, v[1], atol=2e-7)
    assert "DE421" in run.method and "jplephem" in run.method and not JPL_EPHEMERIS.exact


@needs_jpl
def test_newtons_point_masses_miss_what_relativity_and_the_moon_do():
    far = differences(STORED_TRUTH.run(SOLAR, 10_000.0, {}))[-1]
    sun, mercury, earth = far[0], far[1], far[3]
    assert 1e-8 < sun < 1e-6  # 7.0e-8
    assert 1e-5 < mercury < 5e-5  # 2.5e-5: relativity moves its perihelion 43" a century
    assert 5e-6 < earth < 2e-5  # 1.1e-5
    assert np.all(far[7:] < 1e-7)  # 4e-8 and less
    early = differences(STORED_TRUTH.run(SOLAR, 100.0, {}))[-1]
    assert np.all(early < far)


@needs_jpl
def test_times_outside_the_ephemeris_are_refused():
    for duration in (1e5, -1e5):
        with pytest.raises(ValueError, match=r"DE421 covers -36552 to 73080 days.*received"):
            JPL_EPHEMERIS.run(SOLAR, duration, {})


def test_it_knows_its_own_start_only():
    assert JPL_EPHEMERIS.supports(SOLAR)
    assert JPL_EPHEMERIS.supports(galvi.problems.solar_system(pluto=False))
    assert not JPL_EPHEMERIS.supports(galvi.problems.outer_solar_system())
    assert not JPL_EPHEMERIS.supports(galvi.problems.kepler())
    nudged = galvi.Problem(SOLAR.system, np.nextafter(SOLAR.q0, 99.0), SOLAR.v0)
    assert not JPL_EPHEMERIS.supports(nudged)
    run = galvi.Trajectory(nudged, np.zeros(1), nudged.q0[None], nudged.p0[None])
    with pytest.raises((ValueError, ModuleNotFoundError), match="JPL DE421"):
        differences(run)
