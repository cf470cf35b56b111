"""Point masses: the packed kernel against the general one, and what a failing step says."""

import numpy as np
import pytest

import galvi
from galvi.kernels.forces.passages import FOUND, PASSAGE_REACH, near_limit
from galvi.run import engines
from galvi.run.point_masses.encounters import encounter

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))


@pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
@pytest.mark.parametrize(("stages", "dimension"), [(3, 3), (8, 2), (11, 3), (24, 2)])
def test_the_packed_kernel_does_what_the_general_one_does_in_fewer_passes(
    stages, dimension, monkeypatch
):
    sun = galvi.problems.solar_system()
    sun = galvi.Problem(sun.system, sun.q0[:, :dimension], sun.v0[:, :dimension])
    method = galvi.Galerkin(galvi.Polynomials(stages), galvi.gauss(stages))
    packed = galvi.integrate(sun, method, 1.0 * stages, 40)
    monkeypatch.setattr(engines, "ENGINES", (engines.GENERAL,))
    general = galvi.integrate(sun, method, 1.0 * stages, 40)
    # Round-off grows along Mercury's orbit; 1e-13 after 40 steps of 3 days, 2e-12 of 24 days.
    assert np.allclose(packed.q, general.q, rtol=0, atol=1e-11)
    assert np.allclose(packed.q[:3], general.q[:3], rtol=0, atol=2e-14)
    # The pair's own passes save from 57 (2 stages) to 137 (16 stages) of 40 steps' passes.
    assert packed.counts["iterations"] < general.counts["iterations"]


def test_a_step_too_large_for_a_planet_names_it_and_a_step_that_works():
    sun = galvi.problems.solar_system()
    run = galvi.integrate(sun, FOUR, 60.0, 10)
    assert not run.success and run.failed_step == 1
    assert "bodies Sun and Mercury pass at a distance of about 4.7e-01" in run.status
    assert "Use a smaller step or a higher degree" in run.status
    advised = float(run.status.split("steps of up to about ")[1].split(" ")[0])
    assert galvi.integrate(sun, FOUR, advised, 10).success


def test_a_body_at_infinity_is_named():
    sun = galvi.problems.solar_system()
    state = np.zeros((4, 30))
    state[0], state[2] = sun.q0.ravel(), sun.v0.ravel()
    state[0, 3] = 1e180
    assert encounter(sun, sun.system, 4, 10.0, state) == (
        "body Mercury is 1.0e+180 away. Remove it, or stop before then."
    )


def test_a_passage_is_looked_at_from_where_a_parabola_is_passed_too_fast_for_the_stages():
    """Three bodies at rest: only gravity can have sped them up, to v^2 = 2 G m / d at d."""
    h, n, passage = 0.1, 8, np.array([0.0] * FOUND + [2.0, 2.0, 0.5, 0.25])
    fast, slow = near_limit.py_func(passage, np.zeros(6), h, n)
    distance = slow ** (1.0 / 3.0)
    speed = np.sqrt(2.0 * 2.5 / distance)
    assert fast == 0.0 and distance == pytest.approx(PASSAGE_REACH * h * speed / n, rel=1e-12)


@pytest.mark.slow(
    beside="test_massless_bodies_do_not_collide_and_those_that_pass_once_need_a_clock"
)
def test_bodies_that_pass_are_not_said_to_collide():
    """Runs into a passage and from one. Where a smaller step would help, it is what is advised."""

    def status(pericentre, anomaly, h, forces=()):
        r = pericentre + 2.0 * (1.0 - pericentre) * np.sin(0.5 * anomaly) ** 2
        b = np.sqrt(pericentre * (2.0 - pericentre))
        position = np.array([pericentre - 2.0 * np.sin(0.5 * anomaly) ** 2, b * np.sin(anomaly)])
        speed = np.array([-np.sin(anomaly), b * np.cos(anomaly)]) / r
        q, v = np.array([[0.0, 0.0], position]), np.array([[0.0, 0.0], speed])
        problem = galvi.Problem(galvi.NBody([1.0, 1e-3], forces=forces), q, v)
        run = galvi.integrate(problem, EIGHT, h, int(4.0 / h))
        assert not run.success or run.status.startswith("Completed, but"), run.status
        return run.status

    force = galvi.Force(lambda q: 0.0 * q)
    passes = [(0.0, 0.3), (0.0, 1e-2), (np.pi, 0.3), (np.pi, 0.05), (0.0, 0.3, force)]
    for anomaly, h, *acting_forces in passes:
        reason = status(1e-7, anomaly, h, acting_forces)
        assert "collide" not in reason and "at a distance of about 1.0e-07" in reason, reason
        assert "Use clock=galvi.DynamicalTime(), whose steps follow" in reason, reason
        assert "smaller step" not in reason and "KeplerFrame" not in reason, reason
    assert "Use a smaller step or a higher degree." in status(1e-2, 0.0, 0.1)


def test_massless_bodies_do_not_collide_and_those_that_pass_once_need_a_clock():
    q = np.array([[0.0, 0.0], [1.0, 0.0], [3.0, 2.0]])
    v = np.array([[0.0, 0.0], [0.0, 1.0], [0.5, 0.0]])
    coarse = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    run = galvi.integrate(galvi.Problem(galvi.NBody([1.0, 0.0, 0.0]), q, v), coarse, 10.0, 5)
    assert "bodies 0 and 1" in run.status, run.status
    passing = galvi.Problem(
        galvi.NBody([1.0, 0.1]), [[0.0, 0.0], [-10.0, 1e-3]], [[0.0, 0.0], [1.0, 0.0]]
    )
    fine = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
    run = galvi.integrate(passing, fine, 0.3, 60)
    assert "DynamicalTime()" in run.status, run.status
