"""Runs on groups: in parts, curves, what is kept, counts, attitudes, momenta."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import galvi
from galvi.systems.finite_differences import WEIGHTS
from tests.properties.group_matrices import cross_matrix, title
from tests.properties.group_motions import (
    ALL,
    COUPLED,
    EXPONENTIAL,
    FLYING,
    FREE,
    PENDULUM,
    RODRIGUES,
    collocation,
    each_chart,
    hall,
    same,
    same_rows,
    swung,
)

KEPLER = galvi.problems.kepler(0.6)


@pytest.mark.slow_cases("H's-pendulum and body")
@pytest.mark.parametrize("problem", ALL, ids=title)
@pytest.mark.parametrize(
    "method",
    [collocation(4), hall(5, EXPONENTIAL), collocation(4, RODRIGUES)],
    ids=["square", "H's", "modified Rodrigues"],
)
def test_a_run_in_parts_and_from_a_file_is_one_long_run_to_the_bit(problem, method, tmp_path):
    whole = galvi.integrate(problem, method, 0.11, 40)
    part = galvi.integrate(problem, method, 0.11, 23, save_every=4)
    rest = galvi.resume(part, 17, save_every=1)
    assert np.array_equal(rest.q, whole.q[23:]) and np.array_equal(rest.p, whole.p[23:])
    assert np.array_equal(rest.t, whole.t[23:])
    assert np.allclose(rest(rest.t[3] + 0.05), whole(rest.t[3] + 0.05), rtol=0.0, atol=1e-13)
    galvi.save(galvi.integrate(problem, method, 0.11, 23), tmp_path / "run.npz")
    given_again = {"problem": problem} if isinstance(problem.system, galvi.Lagrangian) else {}
    loaded = galvi.load(tmp_path / "run.npz", **given_again)
    assert loaded.method == method
    assert np.array_equal(galvi.resume(loaded, 17, save_every=1).q, whole.q[23:])
    assert np.array_equal(loaded(1.234), whole(1.234))
    assert np.array_equal(loaded.velocity(1.234), whole.velocity(1.234))


@pytest.mark.parametrize("problem", ALL, ids=title)
def test_backwards_undoes_forwards_for_degree_one_in_the_exponential_chart(problem):
    """exp(-x) exp((1 - tau) x) = exp(-tau x): the same curve from its other end."""
    for method in (collocation(1, EXPONENTIAL), hall(2, EXPONENTIAL)):
        assert galvi.round_trip_error(problem, method, 0.02, 100) < 2e-13  # 6e-14, while falling
    back = galvi.integrate(problem, method, -0.02, 10)
    assert back.success and back.t[-1] == -0.2


@pytest.mark.parametrize("problem", [PENDULUM, FLYING], ids=title)
@each_chart
@given(where=st.floats(0.15, 0.85), step=st.integers(0, 9))
def test_the_velocity_is_the_slope_of_the_curve(problem, chart, where, step):
    run = galvi.integrate(problem, collocation(6, chart), 0.2, 10)
    t, nudge = 0.2 * (step + where), 0.2 * 2.0**-5
    slope = sum(
        weight / nudge * (run(t + k * nudge) - run(t - k * nudge))
        for k, weight in enumerate(WEIGHTS, start=1)
    )
    body = np.linalg.inv(run(t)) @ slope
    v = run.velocity(t)
    assert np.allclose(body[:3, :3], cross_matrix(v[:3]), rtol=0.0, atol=1e-8)
    assert np.allclose(body[:3, 3:].ravel(), v[3:], rtol=0.0, atol=1e-7)


def test_counts_are_the_same_in_every_run():
    for problem in ALL:
        runs = [galvi.integrate(problem, collocation(4), 0.1, 50) for _ in range(2)]
        assert runs[0].counts == runs[1].counts and same(*runs)
        assert runs[0].counts["steps"] == 50
        assert runs[0].counts["force_evaluations"] >= 4 * runs[0].counts["iterations"]


@given(steps=st.integers(1, 20), save_every=st.integers(1, 25))
def test_what_is_kept_is_every_kth_step_and_the_last(steps, save_every):
    for problem, method in ((PENDULUM, collocation(3)), (FREE, hall(3)), (KEPLER, collocation(4))):
        full = galvi.integrate(problem, method, 0.1, steps)
        thin = galvi.integrate(problem, method, 0.1, steps, save_every=save_every)
        kept = sorted({*range(0, steps, save_every), steps})
        assert same_rows(thin, full, kept) and np.array_equal(thin.t, full.t[kept])
        assert (thin.curves is None) == (save_every > 1)


def test_attitudes_come_as_scipys_rotations():
    run = galvi.integrate(PENDULUM, collocation(6), 0.2, 10)
    turns = galvi.rotations(run)
    assert np.allclose(turns.as_matrix(), run.q, rtol=0.0, atol=1e-15)
    assert galvi.rotations(run, 0.33).as_quat().shape == (4,)
    assert np.allclose(galvi.rotations(run, [0.3]).as_matrix()[0], run(0.3), rtol=0.0, atol=1e-15)
    assert np.all(galvi.orthogonality_defect(run, np.linspace(0.0, 2.0, 30)) < 4e-15)
    assert galvi.orthogonality_defect(run).shape == (11,)
    flown = galvi.integrate(FLYING, collocation(6), 0.1, 10)
    assert np.allclose(galvi.rotations(flown).as_matrix(), flown.q[:, :3, :3], atol=1e-15)
    assert galvi.orthogonality_defect(flown).max() < 1e-15


NOT_IN_SPACE = r"attitudes need a run on SO\(3\) or SE\(3\), such as"
NO_MATRICES = r"needs a run on SO\(2\), SE\(2\), SO\(3\), SE\(3\) or a galvi\.Product"


@pytest.mark.parametrize(
    "ask, problem, message",
    [
        (galvi.rotations, galvi.problems.kepler(0.1), NOT_IN_SPACE),
        (galvi.rotations, COUPLED, NOT_IN_SPACE + r".* Take a factor's matrices from .*parts\("),
        (galvi.orthogonality_defect, galvi.problems.kepler(0.1), NO_MATRICES),
    ],
)
def test_attitudes_of_what_has_none_are_refused(ask, problem, message):
    run = galvi.integrate(problem, collocation(3), 0.1, 3)
    with pytest.raises(ValueError, match=message):
        ask(run)


def test_the_remedies_of_refused_attitudes_work():
    run = galvi.integrate(COUPLED, collocation(3), 0.1, 3)
    plane, space = run.problem.system.group.parts(run.q)
    turns = Rotation.from_matrix(space)
    assert np.allclose(turns.as_matrix(), space, rtol=0.0, atol=1e-14)
    angle = np.arctan2(plane[:, 1, 0], plane[:, 0, 0])
    assert angle[0] == pytest.approx(0.4) and galvi.orthogonality_defect(run).max() < 1e-15


@pytest.mark.parametrize("ask", [galvi.rotations, galvi.orthogonality_defect])
def test_attitudes_between_kept_steps_are_those_of_all_steps(ask):
    thin = galvi.integrate(FREE, collocation(3), 0.1, 9, save_every=3)
    whole = galvi.integrate(FREE, collocation(3), 0.1, 9)
    found, expected = (ask(run, 0.2) for run in (thin, whole))
    assert repr(found) == repr(expected)


def test_momenta_are_those_of_the_definition():
    run = galvi.integrate(FREE, collocation(6), 0.2, 10)
    by_hand = np.array([R @ p for R, p in zip(run.q, run.p, strict=True)])
    assert np.allclose(galvi.momentum_map(run), by_hand, rtol=0.0, atol=1e-14)
    t = [0.1, 1.7]
    v = run.velocity(t)
    energy = 0.5 * np.sum(v * (v @ FREE.system.inertia), axis=1)
    assert np.allclose(galvi.energy(run, t), energy, rtol=1e-14)
    flown = galvi.integrate(FLYING, collocation(6), 0.1, 10)
    assert galvi.linear_momentum(flown).shape == (11, 3)
    for refused, message in ((galvi.linear_momentum, run), (galvi.momentum_map, None)):
        other = message or galvi.integrate(COUPLED, collocation(3), 0.1, 3)
        with pytest.raises(ValueError, match="moment"):
            refused(other)


def test_a_recommendation_for_a_pendulum_is_kept():
    found = galvi.recommend(PENDULUM, 1e-8, 4.0, degrees=(4, 6), by="evaluations", budget=2e5)
    assert found.reached, found.status
    run = galvi.integrate(PENDULUM, found.method, found.step, found.steps)
    assert np.linalg.norm(run.q[-1] - swung()[0], axis=-1).max() < 1e-8
