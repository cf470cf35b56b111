"""What else meets point masses with forces: frames, exports, files and references."""

import pickle

import numpy as np
import pytest

import galvi
from references import REFERENCES
from tests.properties.celestial_cases import CASES, bodies

METHOD = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))


def test_references_without_forces_do_not_support_them():
    known = {one.name for one in REFERENCES if one.supports(bodies(CASES["one source"]))}
    plain = {one.name for one in REFERENCES if one.supports(bodies(()))}
    assert known < plain
    engines = {name for name in known if "REBOUND" in name or "heyoka" in name}
    assert engines == {"heyoka", "heyoka, quadruple precision"}


@pytest.mark.parametrize("name", ["J2 and J4", "tides"])
def test_a_problem_is_pickled_with_its_forces(name):
    problem = bodies(CASES[name])
    again = pickle.loads(pickle.dumps(problem))
    assert np.array_equal(
        again.system.acceleration(again.q0, 0.0, again.v0),
        problem.system.acceleration(problem.q0, 0.0, problem.v0),
    )


def test_exports_refuse_forces():
    run = galvi.integrate(bodies(CASES["J2 and J4"]), METHOD, 0.05, 2)
    with pytest.raises(ValueError, match="holds no forces"):
        run.to_rebound()


@pytest.mark.parametrize("name", ["J2 and J4", "tides", "radiation"])
def test_a_saved_run_continues_with_its_forces(name, tmp_path):
    path, problem = str(tmp_path / "run.npz"), bodies(CASES[name])
    galvi.save(galvi.integrate(problem, METHOD, 0.05, 4), path)
    again = galvi.resume(galvi.load(path), 4)
    assert np.array_equal(again.q[-1], galvi.integrate(problem, METHOD, 0.05, 8).q[-1])


def test_a_saved_run_with_a_function_needs_its_problem(tmp_path):
    path, problem = str(tmp_path / "run.npz"), bodies(CASES["Python"])
    galvi.save(galvi.integrate(problem, METHOD, 0.05, 2), path)
    with pytest.raises(ValueError, match="needs its problem"):
        galvi.load(path)
    assert galvi.load(path, problem=problem).success
    with pytest.raises(ValueError, match="it has another one"):
        galvi.load(path, problem=bodies(CASES["drag"]))


@pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
def test_a_kepler_frame_refuses_forces_of_velocity():
    framed = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), chart=galvi.KeplerFrame())
    with pytest.raises(ValueError, match="received an NBody system with Tides"):
        galvi.integrate(bodies(CASES["tides"]), framed, 0.05, 4)


def test_only_forces_of_position_are_symplectic():
    assert galvi.symplecticity_defect(bodies(CASES["J2 and J4"]), METHOD, 0.05) < 1e-15
    with pytest.raises(ValueError, match="forces of velocity"):
        galvi.symplecticity_defect(bodies(CASES["tides"]), METHOD, 0.05)
