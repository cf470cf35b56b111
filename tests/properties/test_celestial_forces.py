"""Celestial forces: their formulas, conserved quantities, files, and the runs that they end."""

import pickle
import re

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import galvi
from galvi.kernels.forces import celestial
from galvi.tracing import traced_lagrangian
from references import REFERENCES
from references.forces.celestial import accelerations
from tests.properties.celestial_cases import (
    CASES,
    FORCE_PAIRS,
    MASSES,
    WITH_ENERGY,
    Q,
    V,
    bodies,
    eccentric,
)

METHOD = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))


@pytest.mark.slow_cases("a function of time")
@pytest.mark.parametrize("name", CASES)
def test_accelerations_are_those_of_other_formulas(name):
    problem = bodies(CASES[name])
    system, plain = problem.system, galvi.NBody(MASSES)
    extra = system.acceleration(problem.q0, 0.7, problem.v0) - plain.acceleration(problem.q0, 0.7)
    expected = accelerations(system, problem.q0, problem.v0, 0.7)
    assert np.max(np.abs(expected)) > 1e-7
    assert np.max(np.abs(extra - expected)) < 4e-16 * np.max(
        np.abs(system.acceleration(problem.q0, 0.7, problem.v0))
    )


@given(
    J2=st.floats(-1.0, 1.0),
    J4=st.floats(-1.0, 1.0),
    n=st.floats(-4.0, 3.0),
    pole=st.tuples(*[st.floats(0.1, 1.0)] * 3),
    position=st.tuples(*[st.floats(0.5, 2.0)] * 3),
)
def test_the_gradient_of_the_potential_is_the_force(J2, J4, n, pole, position):
    forces = (
        galvi.Oblateness(0, J2, 0.4, J4, pole),
        galvi.PowerLaw(1, 0.3, n),
        galvi.Relativity(3.0, form="potential"),
    )
    acting = galvi.NBody([1.0, 0.3], forces=forces).acting
    q = np.array([[0.1, 0.0, -0.2], position])
    moved = q + 1e-40j * np.eye(6).reshape(6, 2, 3)
    slope = np.imag(celestial.pulls(acting.terms, acting.poles, moved)[1]).reshape(2, 3) / 1e-40
    a = celestial.pulls(acting.terms, acting.poles, q)[0]
    assert np.allclose(-slope, np.array([[1.0], [0.3]]) * a, rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("name", WITH_ENERGY)
def test_the_energy_with_the_forces_is_kept_and_without_them_is_not(name):
    problem = bodies(WITH_ENERGY[name])
    run = galvi.integrate(problem, METHOD, 0.05, 60)
    assert run.success, run.status
    total = galvi.energy(run)
    bare = total - (
        problem.system.potential_energy(run.q, run.t)
        - galvi.NBody(MASSES).potential_energy(run.q, run.t)
    )
    assert np.ptp(total) < 1e-4 * np.ptp(bare)


@pytest.mark.slow_cases("one source", "tides")
@pytest.mark.parametrize("name", FORCE_PAIRS)
def test_force_pairs_keep_the_momentum(name):
    run = galvi.integrate(bodies(CASES[name]), METHOD, 0.05, 60)
    assert run.success, run.status
    assert np.max(np.abs(galvi.linear_momentum(run))) < 1e-17


def test_the_order_is_that_of_the_method():
    method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    problem = bodies(CASES["tides"])
    truth = galvi.integrate(problem, METHOD, 1.0 / 32, 32).q[-1]
    errors = [
        np.max(np.abs(galvi.integrate(problem, method, 1.0 / n, n).q[-1] - truth))
        for n in (16, 32, 64)
    ]
    orders = np.log2(errors[:-1]) - np.log2(errors[1:])
    assert np.all((orders > 3.7) & (orders < 4.3)), orders


@pytest.mark.parametrize("name", ["potential", "J2 of a planet"])
def test_a_massless_body_moves_like_one_of_little_mass(name):
    runs = [
        galvi.integrate(bodies(CASES[name], masses), METHOD, 0.05, 40)
        for masses in ([1.0, 1e-3, 0.0], [1.0, 1e-3, 1e-14])
    ]
    assert np.max(np.abs(runs[0].q[-1] - runs[1].q[-1])) < 1e-12


def test_in_the_plane_they_are_those_of_space():
    for forces in (
        galvi.Oblateness(0, 1e-3, 0.3),
        galvi.Tides(0, 0.3, 0.3, 0.01, spin=(0, 0, 2)),
        galvi.Relativity(30.0, form="EIH"),
    ):
        planar = bodies(forces, plane=True)
        q, v = (np.pad(positions, ((0, 0), (0, 1))) for positions in (planar.q0, planar.v0))
        in_plane, in_space = (
            planar.system.acceleration(positions, 0.0, velocities)
            for positions, velocities in ((planar.q0, planar.v0), (q, v))
        )
        assert np.max(np.abs(in_space[:, :2] - in_plane)) < 1e-15 and not np.any(in_space[:, 2])


def test_only_forces_of_position_are_symplectic():
    assert galvi.symplecticity_defect(bodies(CASES["J2 and J4"]), METHOD, 0.05) < 1e-15


def test_references_without_forces_do_not_support_them():
    with_forces, plain = (
        {reference.name for reference in REFERENCES if reference.supports(bodies(forces))}
        for forces in (CASES["one source"], ())
    )
    engines = {name for name in with_forces if "REBOUND" in name or "heyoka" in name}
    assert with_forces < plain and engines == {"heyoka", "heyoka, quadruple precision"}


@pytest.mark.parametrize("name", ["J2 and J4", "tides", "radiation"])
def test_a_saved_run_continues_with_its_forces(name, tmp_path):
    path, problem = str(tmp_path / "run.npz"), pickle.loads(pickle.dumps(bodies(CASES[name])))
    galvi.save(galvi.integrate(problem, METHOD, 0.05, 4), path)
    resumed = galvi.resume(galvi.load(path), 4)
    assert np.array_equal(
        resumed.q[-1], galvi.integrate(bodies(CASES[name]), METHOD, 0.05, 8).q[-1]
    )


def test_a_saved_run_with_a_function_needs_its_problem(tmp_path):
    path = str(tmp_path / "run.npz")
    problem = pickle.loads(pickle.dumps(bodies(CASES["Python"])))
    run = galvi.integrate(problem, METHOD, 0.05, 2)
    assert run.engine == "lanes" or not galvi.FAST  # it is traced again
    galvi.save(run, path)
    with pytest.raises(ValueError, match="needs its problem"):
        galvi.load(path)
    assert galvi.load(path, problem=problem).success
    with pytest.raises(ValueError, match="it has another one"):
        galvi.load(path, problem=bodies(CASES["drag"]))


@pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
def test_a_law_too_long_to_be_written_out_gives_the_same_run_in_the_general_kernel(monkeypatch):
    lane_run = galvi.integrate(bodies(CASES["tides"]), METHOD, 0.05, 40)
    monkeypatch.setattr(traced_lagrangian, "MAX_BUILT_IN_OPERATIONS", 0)
    general_run = galvi.integrate(bodies(CASES["tides"]), METHOD, 0.05, 40)
    assert (lane_run.engine, general_run.engine) == ("lanes", "general")
    assert np.max(np.abs(lane_run.q - general_run.q)) < 1e-14


@pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
def test_a_function_is_traced_again_when_a_number_that_it_refers_to_changes():
    strength = [-1e-3]
    problem = bodies(galvi.Force(lambda q, v: strength[0] * v, takes_velocity=True))
    before = galvi.integrate(problem, METHOD, 0.05, 40)
    strength[0] = -2e-3
    after, fresh = (
        galvi.integrate(version, METHOD, 0.05, 40)
        for version in (problem, bodies(problem.system.forces))
    )
    assert np.array_equal(after.q, fresh.q) and fresh.engine == "lanes"
    assert np.max(np.abs(after.q - before.q)) > 1e-6


@pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
@pytest.mark.slow(beside="test_a_function_is_traced_again_when_a_number_that_it_refers_to_changes")
def test_a_function_that_branches_is_called_by_the_general_kernel():
    def drag(q, v):
        return -1e-3 * v if q[1, 0] > 0.0 else -2e-3 * v

    python, jitted = (
        galvi.integrate(bodies(galvi.Force(function, takes_velocity=True)), METHOD, 0.05, 40)
        for function in (drag, numba.njit(drag))
    )
    assert (python.engine, jitted.engine) == ("general", "general")
    assert "branches" in jitted.problem.system.untraced
    assert np.max(np.abs(python.q - jitted.q)) < 1e-13


@pytest.mark.slow_cases("charges1")
@pytest.mark.parametrize("charges", [(0.3, 3e-4), (0.3, 0.3)])
def test_a_force_that_does_no_work_settles_in_a_clock(charges):
    """As in a magnetic field, where F . v is rounding error alone. The second pair of charges turns
    the planet by 15 rad a step, which only Newton's method solves."""

    def turning(q, v):
        return np.array(charges)[:, None] * np.stack([v[:, 1], -v[:, 0], 0.0 * v[:, 0]], 1)

    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), clock=galvi.DynamicalTime())
    problem = eccentric(galvi.Force(turning, takes_velocity=True))
    run = galvi.integrate(problem, method, 0.2, 4)
    assert run.success and (run.counts["linear_solves"] == 0) == (charges[1] < 0.3), run.status
    if charges[1] < 0.3:
        energy = galvi.energy(run)
        assert np.max(np.abs(energy - energy[0])) < 1e-13 * abs(energy[0])  # 4e-15


@pytest.mark.slow(beside="tests/agreement/test_agreement.py::test_every_problem_agrees")
def test_a_driven_clock_takes_newtons_method_where_passes_do_not_settle():
    method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2), clock=galvi.DynamicalTime())
    fallback_run, newton_run = (
        galvi.integrate(bodies(CASES["drag"]), method, 2.4, 2, solver=solver)
        for solver in ("auto", "newton")
    )
    assert fallback_run.success and fallback_run.counts["linear_solves"] > 0
    assert np.max(np.abs(fallback_run.q - newton_run.q)) < 1e-13
    fixed_point = galvi.integrate(bodies(CASES["drag"]), method, 2.4, 2, solver="fixed_point")
    assert not fixed_point.success and "or the solver auto" in fixed_point.status


def test_a_force_that_has_no_value_at_rest_is_asked_at_the_start_alone():
    def push_along_velocity(q, v):
        return 1e-6 * v / np.sqrt(np.sum(v**2, axis=-1, keepdims=True))

    problem = bodies(galvi.Force(push_along_velocity, takes_velocity=True))
    assert galvi.integrate(problem, METHOD, 0.05, 3).success


def test_a_force_that_pushes_a_body_without_mass_later_ends_the_run_in_words():
    def late_push(q, t):
        force = 0.0 * q
        if t > 0.5:
            force[2, 0] = 1.0
        return force

    problem = bodies(galvi.Force(late_push, takes_time=True), [1.0, 1e-3, 0.0])
    run = galvi.integrate(problem, METHOD, 0.05, 20)
    assert not run.success and "push a body without mass" in run.status
    assert 9 <= np.count_nonzero(np.isfinite(run.q[:, 0, 0])) <= 11


def test_a_function_of_time_is_asked_at_the_time_of_the_start():
    force = galvi.Force(lambda q, t: q - (np.inf if t < 0.5 else q), takes_time=True)
    problem = galvi.Problem(galvi.NBody(MASSES, forces=force), Q, V, t0=1.0)
    assert galvi.integrate(problem, METHOD, 0.05, 2).success


@pytest.mark.slow(beside="test_a_run_with_a_negligible_force_says_of_passages_what_it_says_without")
def test_a_step_that_newton_cannot_solve_is_tried_in_parts_and_ends_the_run_in_words():
    problem = bodies([force for name in ("tides", "EIH", "power laws") for force in CASES[name]])
    run = galvi.integrate(problem, METHOD, 3.0, 5)
    assert not run.success and "with the forces beside gravity the step cannot" in run.status


NEGLIGIBLE = {
    "drag": galvi.Drag([1e-14] * 3),
    "relativity": galvi.Relativity(1e8),
    "EIH": galvi.Relativity(1e8, form="EIH"),
    "jitted": galvi.Force(numba.njit(lambda q, v: -1e-16 * v), takes_velocity=True),
    "Python": galvi.Force(lambda q, v: -1e-16 * v, takes_velocity=True),
}


def grazing_pair(forces):
    """Two bodies from the apocentre of an orbit with e = 0.95, and a light one far away."""
    q, v = [[0, 0], [1.95, 0], [9, 0]], [[0, 0], [0, 0.05**0.5 / 1.95**0.5], [0, 1 / 3]]
    return galvi.Problem(galvi.NBody([1.0, 1e-3, 1e-9], forces=forces), q, v)


@pytest.mark.slow_cases(but=["relativity-auto", "EIH-auto"])
@pytest.mark.parametrize(
    ("name", "solver"), [("drag", "newton"), *((name, "auto") for name in NEGLIGIBLE)]
)
def test_a_run_with_a_negligible_force_says_of_passages_what_it_says_without(name, solver):
    """The energy of a forced run is not assessed. A step of 1e-3 resolves the passage, one of 0.05
    does not, and one of 0.5 cannot be solved."""
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))

    def run(forces, step, steps):
        return galvi.integrate(
            grazing_pair(forces), method, step, steps, solver=solver, save_every=20
        )

    plain, forced = (run(forces, 0.05, 80) for forces in ((), NEGLIGIBLE[name]))
    assert "bodies 0 and 1 passed at a distance of about " in plain.status
    assert forced.status == re.sub("the energy changed by [^;]*; ", "", plain.status)
    assert galvi.resume(run(NEGLIGIBLE[name], 0.05, 70), 10).status == forced.status
    plain, forced = (run(forces, 0.5, 40) for forces in ((), NEGLIGIBLE[name]))
    assert forced.status == plain.status and plain.status.startswith("Stopped at step 7 of 40")
    if name != "Python":  # the same at 3200 calls of many functions
        assert run(NEGLIGIBLE[name], 1e-3, 3200).status == "Completed."
