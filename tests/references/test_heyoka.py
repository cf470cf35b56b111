"""heyoka in double and quadruple precision."""

import numpy as np
import pytest

import galvi
from references.closed_forms.kepler import KEPLER
from references.heyoka.taylor import BEST, HEYOKA, HEYOKA_QUADRUPLE
from references.stored.planets import STORED_TRUTH
from tests.properties.celestial_cases import CASES, MASSES, Q, V

needs_heyoka = pytest.mark.skipif(bool(HEYOKA.missing), reason=HEYOKA.missing or "present")
needs_real128 = pytest.mark.skipif(
    bool(HEYOKA_QUADRUPLE.missing), reason=HEYOKA_QUADRUPLE.missing or "present"
)
QUICK = {"compact_mode": True}


@needs_heyoka
def test_it_finds_the_planets_and_says_with_what():
    problem = galvi.problems.outer_solar_system()
    truth = STORED_TRUTH.run(problem, 36_525.0, {})
    for setting in ({}, BEST):
        run = HEYOKA.run(problem, 36_525.0, {**setting, **QUICK})
        assert np.abs(run.q[-1] - truth.q[-1]).max() < 1e-11  # 4e-13
        assert "heyoka 7" in run.method and "double" in run.method
        assert f"tolerance={setting.get('tolerance', 2.0**-52)}" in run.method
    assert run.counts["steps"] > 100


@needs_heyoka
def test_a_second_run_is_the_first_one_again():
    problem = galvi.problems.kepler(0.5)
    first, second = (HEYOKA.run(problem, 20.0, {"samples": 4, **QUICK}) for _ in range(2))
    assert np.array_equal(first.q, second.q)
    scaled = galvi.Problem(problem.system, 1.1 * problem.q0, problem.v0)
    scaled_run = HEYOKA.run(scaled, 20.0, QUICK)
    assert np.abs(scaled_run.q[-1] - KEPLER.run(scaled, 20.0, {}).q[-1]).max() < 1e-11


@needs_real128
def test_quadruple_precision_is_exact_in_double_at_any_eccentricity():
    # the last passes the pericentre four times, 1e-6 from the centre
    for e in (0.3, 0.99, 0.999999):
        problem = galvi.problems.kepler(e)
        run = HEYOKA_QUADRUPLE.run(problem, 30.0, {"samples": 8})
        exact = KEPLER.run(problem, 30.0, {"samples": 8})
        np.testing.assert_allclose(run.q, exact.q, rtol=4e-16, atol=4e-16)


@needs_real128
def test_in_quadruple_precision_all_forces_together_are_those_of_galvi():
    forces = [
        force for case in CASES.values() for force in case if not isinstance(force, galvi.Force)
    ]
    problem = galvi.Problem(galvi.NBody(MASSES, forces=forces), Q, V)
    assert len({type(force) for force in forces}) == 6 and HEYOKA_QUADRUPLE.supports(problem)
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    run = galvi.integrate(problem, method, 0.01, 40)
    truth = HEYOKA_QUADRUPLE.run(problem, 0.4, {})
    assert np.abs(run.q[-1] - truth.q[-1]).max() < 1e-13
    of_user = galvi.NBody(MASSES, forces=galvi.Force(lambda q: 0.0 * q))
    assert not HEYOKA_QUADRUPLE.supports(galvi.Problem(of_user, Q, V))


def test_without_heyoka_there_is_a_sentence(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "heyoka", None)
    for contender in (HEYOKA, HEYOKA_QUADRUPLE):
        assert contender.missing.endswith("Install heyoka, which has wheels for Linux on x86-64.")
        with pytest.raises(ModuleNotFoundError, match="cannot run"):
            contender.run(galvi.problems.kepler(), 1.0, {})
