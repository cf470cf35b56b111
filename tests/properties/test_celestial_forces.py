"""Celestial forces: their formulas, what they keep, their order and their refusals."""

import re

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import galvi
from galvi.kernels.forces import celestial
from references.forces.celestial import accelerations
from tests.properties.celestial_cases import (
    CASES,
    MASSES,
    OF_VELOCITY,
    PAIRS,
    WITH_ENERGY,
    Q,
    V,
    bodies,
)

METHOD = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))


@pytest.mark.slow_cases("a function of time")
@pytest.mark.parametrize("name", CASES)
def test_accelerations_are_those_of_other_formulas(name):
    problem = bodies(CASES[name])
    system, plain = problem.system, galvi.NBody(MASSES)
    ours = system.acceleration(problem.q0, 0.7, problem.v0) - plain.acceleration(problem.q0, 0.7)
    theirs = accelerations(system, problem.q0, problem.v0, 0.7)
    assert np.max(np.abs(theirs)) > 1e-7
    assert np.max(np.abs(ours - theirs)) < 4e-16 * np.max(
        np.abs(system.acceleration(problem.q0, 0.7, problem.v0))
    )


@given(
    J2=st.floats(-1.0, 1.0), J4=st.floats(-1.0, 1.0), n=st.floats(-4.0, 3.0),
    pole=st.tuples(*[st.floats(0.1, 1.0)] * 3), place=st.tuples(*[st.floats(0.5, 2.0)] * 3),
)  # fmt: skip
def test_the_gradient_of_the_potential_is_the_force(J2, J4, n, pole, place):
    forces = (
        galvi.Oblateness(0, J2, 0.4, J4, pole), galvi.PowerLaw(1, 0.3, n),
        galvi.Relativity(3.0, form="potential"),
    )  # fmt: skip
    acting = galvi.NBody([1.0, 0.3], forces=forces).acting
    q = np.array([[0.1, 0.0, -0.2], place])
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
@pytest.mark.parametrize("name", PAIRS)
def test_force_pairs_keep_the_momentum(name):
    run = galvi.integrate(bodies(CASES[name]), METHOD, 0.05, 60)
    assert run.success, run.status
    assert np.max(np.abs(galvi.linear_momentum(run))) < 1e-17


@pytest.mark.parametrize("name", ["J2 and J4", "one source", "tides"])
def test_the_order_is_that_of_the_method(name):
    method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    problem = bodies(CASES[name])
    ends = [galvi.integrate(problem, method, 1.0 / n, n).q[-1] for n in (16, 32, 64)]
    true = galvi.integrate(problem, METHOD, 1.0 / 32, 32).q[-1]
    errors = [np.max(np.abs(end - true)) for end in ends]
    orders = np.log2(errors[:-1]) - np.log2(errors[1:])
    assert np.all((orders > 3.7) & (orders < 4.3)), orders


@pytest.mark.slow_cases(but=["one source", "tides"])
@pytest.mark.parametrize("name", OF_VELOCITY)
def test_the_energy_of_a_run_with_a_force_of_velocity_is_not_judged(name):
    run = galvi.integrate(bodies(OF_VELOCITY[name]), METHOD, 0.05, 20)
    assert run.success
    assert run.v.shape == run.p.shape == (21, 3, 3)
    q, v = run(0.52), run.velocity(0.52)
    assert q.shape == v.shape == (3, 3)
    between = galvi.integrate(run.problem, METHOD, 0.04, 13)
    assert np.max(np.abs(q - between.q[-1])) < 1e-7
    assert np.max(np.abs(v - between.v[-1])) < 1e-6
    assert np.ptp(galvi.energy(run)) > 1e-9


@pytest.mark.parametrize("name", ["potential", "J2 of a planet"])
def test_a_massless_body_moves_like_one_of_little_mass(name):
    runs = [
        galvi.integrate(bodies(CASES[name], masses), METHOD, 0.05, 40)
        for masses in ([1.0, 1e-3, 0.0], [1.0, 1e-3, 1e-14])
    ]
    assert np.max(np.abs(runs[0].q[-1] - runs[1].q[-1])) < 1e-12


@pytest.mark.parametrize(("forces", "words"), [
    ((galvi.Oblateness(2, 1e-3, 0.1),), "a body with a mass; received 2"),
    ((galvi.PowerLaw(3, 1.0, 1.0),), "one of 3 bodies, by number; received 3"),
    ((galvi.Drag([0.0, 0.0, 1e-3]),), "every body needs a mass; received 1"),
    ((galvi.Force(lambda q: q),), "on a body without mass"),
    ((galvi.Force(lambda q: q[0]),), r"shape \(3, 3\)"),
])  # fmt: skip
def test_forces_on_massless_bodies_and_of_them_are_refused(forces, words):
    with pytest.raises(ValueError, match=words):
        bodies(forces, [1.0, 1e-3, 0.0])


def test_other_wrong_forces_are_refused():
    with pytest.raises(TypeError, match="forces must be values"):
        galvi.NBody([1.0], forces=(3.0,))
    with pytest.raises(ValueError, match="a number for each of 2 bodies"):
        galvi.NBody([1.0, 1.0], forces=galvi.Drag([1.0]))
    with pytest.raises(ValueError, match=r"pole of Oblateness must be \(0, 0, z\)"):
        bodies(galvi.Oblateness(0, 1e-3, 0.1, pole=(1, 0, 1)), plane=True)
    for make, words in (
        (lambda: galvi.Relativity(1.0, form="other"), "form must be one of"),
        (lambda: galvi.Relativity(1.0, form=np.zeros(0)), "form must be one of"),
        (lambda: galvi.Oblateness(0, 1e-3, 0.1, pole=(0, 0, 0)), "pole must have a length"),
        (lambda: galvi.Oblateness(0, 1e-3, 0.1, pole=(0, 0, 1e308)), "pole must have a length"),
        (lambda: galvi.Drag([-1.0]), "must not be negative"),
        (lambda: galvi.Tides(0, -1.0, 1.0, 1.0), "k2 must not be negative"),
    ):
        with pytest.raises(ValueError, match=words):
            make()
    with pytest.raises(TypeError, match=r"one of \(q, v\)"):
        galvi.Force(3.0, takes_velocity=True)
    with pytest.raises(TypeError, match="takes_velocity must be"):
        galvi.Force(3.0, takes_velocity=np.zeros(0))
    for function in (lambda q, v: -v, numba.njit(lambda q, v: -v)):
        with pytest.raises(TypeError, match=r"one of \(q\); received one of \(q, v\). Set takes"):
            galvi.Force(function)
    with pytest.raises(ValueError, match="power must be -1 or differ from it by at least"):
        galvi.PowerLaw(0, 1.0, -1.0 + 1e-9)


@pytest.mark.slow(beside="tests/agreement/test_agreement.py::test_every_problem_agrees")
def test_in_the_plane_a_run_is_that_of_space():
    forces = (galvi.Oblateness(0, 1e-3, 0.3), galvi.Tides(0, 0.3, 0.3, 0.01, spin=(0, 0, 2)))
    flat = galvi.integrate(bodies(forces, plane=True), METHOD, 0.05, 20)
    q, v = (np.pad(x, ((0, 0), (0, 1))) for x in (flat.problem.q0, flat.problem.v0))
    whole = galvi.integrate(galvi.Problem(flat.problem.system, q, v), METHOD, 0.05, 20)
    assert np.max(np.abs(whole.q[-1, :, :2] - flat.q[-1])) < 1e-14


IN_CLOCK = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6), clock=galvi.DynamicalTime())


def eccentric(force):
    """Two bodies on an orbit of e = 0.6, a = 1, from its pericentre."""
    masses = np.array([1.0, 1e-3])
    share = np.array([[-1e-3], [1.0]]) / 1.001
    speed = np.sqrt(1.001 * 1.6 / 0.4)
    return galvi.Problem(
        galvi.NBody(masses, forces=force), share * [[0.4, 0.0, 0.0]], share * [[0.0, speed, 0.0]]
    )


@pytest.mark.slow_cases("charges1")
@pytest.mark.parametrize("charges", [(0.3, 3e-4), (0.3, 0.3)])
def test_a_force_that_does_no_work_settles_in_a_clock(charges):
    """As of a magnetic field: F . v is rounding alone. The second turns the planet by 15 rad a
    step, which Newton's method solves."""

    def turning(q, v):
        return np.array(charges)[:, None] * np.stack([v[:, 1], -v[:, 0], 0.0 * v[:, 0]], 1)

    eight = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), clock=galvi.DynamicalTime())
    problem = eccentric(galvi.Force(turning, takes_velocity=True))
    run = galvi.integrate(problem, eight, 0.2, 4)
    assert run.success and (run.counts["linear_solves"] == 0) == (charges[1] < 0.3), run.status
    if charges[1] < 0.3:
        energy = galvi.energy(run)
        assert np.max(np.abs(energy - energy[0])) < 1e-13 * abs(energy[0])  # 4e-15


def test_a_clock_with_a_force_refuses_what_it_cannot_do():
    lobatto = galvi.Galerkin(galvi.Polynomials(2), galvi.lobatto(3), clock=galvi.DynamicalTime())
    with pytest.raises(ValueError, match=r"solver fixed_point needs a constant mass and gauss"):
        galvi.integrate(bodies(CASES["drag"]), lobatto, 0.1, 1, solver="fixed_point")
    problem = bodies(galvi.Force(lambda q: 0.0 * q), [1.0, 1e-3, 0.0])
    with pytest.raises(ValueError, match="massless bodies have no Lagrangian"):
        galvi.integrate(problem, IN_CLOCK, 0.1, 1)


@pytest.mark.slow(beside="tests/agreement/test_agreement.py::test_every_problem_agrees")
def test_a_driven_clock_takes_newtons_method_where_passes_do_not_settle():
    two = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2), clock=galvi.DynamicalTime())
    long, newton = (
        galvi.integrate(bodies(CASES["drag"]), two, 2.4, 2, solver=solver)
        for solver in ("auto", "newton")
    )
    assert long.success and long.counts["linear_solves"] > 0
    assert np.max(np.abs(long.q - newton.q)) < 1e-13
    alone = galvi.integrate(bodies(CASES["drag"]), two, 2.4, 2, solver="fixed_point")
    assert not alone.success and "or the solver auto" in alone.status


def test_a_force_that_has_no_value_at_rest_is_asked_at_the_start_alone():
    def along(q, v):
        return 1e-6 * v / np.sqrt(np.sum(v**2, axis=-1, keepdims=True))

    problem = bodies(galvi.Force(along, takes_velocity=True))
    assert galvi.integrate(problem, METHOD, 0.05, 3).success


def test_a_force_that_pushes_a_body_without_mass_later_ends_the_run_in_words():
    def late(q, t):
        push = 0.0 * q
        if t > 0.5:
            push[2, 0] = 1.0
        return push

    problem = bodies(galvi.Force(late, takes_time=True), [1.0, 1e-3, 0.0])
    run = galvi.integrate(problem, METHOD, 0.05, 20)
    assert not run.success and "push a body without mass" in run.status
    assert 9 <= np.count_nonzero(np.isfinite(run.q[:, 0, 0])) <= 11


def test_a_function_of_time_is_asked_at_the_time_of_the_start():
    force = galvi.Force(lambda q, t: -1e-3 * q / (t - 1.0), takes_time=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        with pytest.raises(ValueError, match="a Force must be finite at the start"):
            galvi.Problem(galvi.NBody(MASSES, forces=force), Q, V, t0=1.0)
        again = galvi.Force(lambda q, t: -1e-3 * q / t, takes_time=True)
        problem = galvi.Problem(galvi.NBody(MASSES, forces=again), Q, V, t0=1.0)
    assert galvi.integrate(problem, METHOD, 0.05, 2).success


@pytest.mark.slow(beside="test_a_run_with_a_negligible_force_says_of_passages_what_it_says_without")
def test_a_step_that_newton_cannot_solve_is_tried_in_parts_and_ends_the_run_in_words():
    problem = bodies([one for name in ("tides", "EIH", "power laws") for one in CASES[name]])
    run = galvi.integrate(problem, METHOD, 3.0, 5)
    assert not run.success and "with the forces beside gravity the step cannot" in run.status


NEGLIGIBLE = {
    "drag": galvi.Drag([1e-14] * 3),
    "radiation": galvi.Radiation([0.0, 1e-14, 0.0], 1e6),
    "relativity": galvi.Relativity(1e8),
    "EIH": galvi.Relativity(1e8, form="EIH"),
    "tides": galvi.Tides(1, 0.3, 1e-5, 0.01),
    "jitted": galvi.Force(numba.njit(lambda q, v: -1e-16 * v), takes_velocity=True),
    "Python": galvi.Force(lambda q, v: -1e-16 * v, takes_velocity=True),
}


def passing(forces):
    """Two bodies from the apocentre of an orbit with e = 0.95, and a light one far away."""
    q, v = [[0, 0], [1.95, 0], [9, 0]], [[0, 0], [0, 0.05**0.5 / 1.95**0.5], [0, 1 / 3]]
    return galvi.Problem(galvi.NBody([1.0, 1e-3, 1e-9], forces=forces), q, v)


@pytest.mark.slow_cases(but=["relativity-auto", "EIH-auto"])
@pytest.mark.parametrize(
    ("name", "solver"), [("drag", "newton"), *((name, "auto") for name in NEGLIGIBLE)]
)
def test_a_run_with_a_negligible_force_says_of_passages_what_it_says_without(name, solver):
    """Its energy is not judged; a step of 1e-3 resolves the passage, of 0.05 does not, and one of
    0.5 cannot be solved."""
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))

    def run(forces, step, steps):
        return galvi.integrate(passing(forces), method, step, steps, solver=solver, save_every=20)

    plain, forced = (run(forces, 0.05, 80) for forces in ((), NEGLIGIBLE[name]))
    assert "bodies 0 and 1 passed at a distance of about " in plain.status
    assert forced.status == re.sub("the energy changed by [^;]*; ", "", plain.status)
    assert galvi.resume(run(NEGLIGIBLE[name], 0.05, 70), 10).status == forced.status
    plain, forced = (run(forces, 0.5, 40) for forces in ((), NEGLIGIBLE[name]))
    assert forced.status == plain.status and plain.status.startswith("Stopped at step 7 of 40")
    if name != "Python":  # the same at 3200 calls of many functions
        assert run(NEGLIGIBLE[name], 1e-3, 3200).status == "Completed."
