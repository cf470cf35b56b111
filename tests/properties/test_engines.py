"""One way to run: what differs between vector spaces and Lie groups is in two values."""

import numpy as np
import pytest

import galvi
from galvi.curves.curves import GroupChart, IdentityChart
from galvi.run.engines import ENGINES
from galvi.run.request import RunRequest, from_start
from galvi.run.stepper import solve_steps
from tests.properties.lagrangians import opaque

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
KEPLER = galvi.problems.kepler(0.3)
CLOSE = 1e-10  # 1.1e-12 when this was written: the Lagrangian is differenced


def lagrangian(q, v):
    return 0.5 * v @ v + 1.0 / np.sqrt(q @ q)


ON_RN = galvi.Problem(galvi.Lagrangian(opaque(lagrangian), galvi.Rn(2)), KEPLER.q0, KEPLER.v0)


def test_both_engines_agree():
    one, other = (galvi.integrate(problem, FOUR, 0.1, 20) for problem in (KEPLER, ON_RN))
    assert one.counts.keys() < other.counts.keys()
    for name in ("t", "q", "p"):
        assert np.allclose(getattr(one, name), getattr(other, name), rtol=0.0, atol=CLOSE)
    t = np.linspace(0.0, 2.0, 13)
    assert np.allclose(one(t), other(t), rtol=0.0, atol=CLOSE)
    assert np.allclose(one.velocity(t), other.velocity(t), rtol=0.0, atol=CLOSE)


@pytest.mark.parametrize("problem", [KEPLER, galvi.problems.heavy_top()])
@pytest.mark.parametrize(("step", "fails"), [(0.1, False), (8.0, True)])
def test_steps_without_a_run_are_those_of_a_run(problem, step, fails):
    stepper, code = solve_steps(ENGINES, RunRequest(problem, FOUR, step, 5, from_start()))
    run, work = galvi.integrate(problem, FOUR, step, 5), stepper.work
    assert work.done == run.counts["steps"] and (code != 0) == fails
    assert np.array_equal(work.saved_q.reshape(run.q.shape), run.q, equal_nan=True)
    assert np.array_equal(work.coefficients, run.curves.coefficients, equal_nan=True)
    assert not fails or run.outcome.reason == stepper.failure(code).removesuffix(".")


@pytest.mark.parametrize("chart", [galvi.Cayley(), galvi.Exponential()])
def test_the_chart_of_a_vector_space_is_that_of_rn(chart):
    base, xi, rate = np.random.default_rng(3).standard_normal((3, 7, 4))
    identity, of_group = IdentityChart((4,)), GroupChart(galvi.Rn(4), chart)
    assert np.array_equal(identity.place(base, xi), of_group.place(base, xi))
    velocities = (one.velocity(lambda: xi, rate) for one in (identity, of_group))
    assert np.array_equal(*velocities)
    bodies = IdentityChart((2, 2))
    assert np.array_equal(bodies.place(base.reshape(7, 2, 2), xi).reshape(7, 4), base + xi)


@pytest.mark.parametrize("problem", [KEPLER, galvi.problems.heavy_top()])
def test_a_resumed_run_keeps_what_the_run_kept(problem, tmp_path):
    thin = galvi.integrate(problem, FOUR, 0.02, 12, save_every=4)
    galvi.save(thin, tmp_path / "run.npz")
    for run in (thin, galvi.load(tmp_path / "run.npz")):
        rest = galvi.resume(run, 9)
        assert len(rest.t) == 4 and rest.curves is None  # after 0, 4, 8 and 9 steps
        every = galvi.resume(run, 9, save_every=1)
        assert len(every.t) == 10 and every.curves is not None
    curved = galvi.integrate(problem, FOUR, 0.02, 12, save_every=4, curves=True)
    assert galvi.resume(curved, 9).curves is not None
    assert galvi.resume(curved, 9, save_every=3, curves=False).curves is None
    bare = galvi.integrate(problem, FOUR, 0.02, 12, curves=False)
    assert len(galvi.resume(bare, 9).t) == 10 and galvi.resume(bare, 9).curves is None
