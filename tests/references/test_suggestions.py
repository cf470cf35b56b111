"""Names, defaults and forces of references; remedies for what users tried first."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import galvi
from references import REFERENCES, reference
from reports.tables.number_format import with_uncertainty

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
CHAIN = galvi.problems.double_pendulum()
SPRING = galvi.problems.harmonic_oscillator()
MOMENTS = (1.0, 2.0, 2.5)


def test_default_tolerances_that_are_no_truth_say_so():
    for name, problem in (
        ("SciPy DOP853, chains", CHAIN),
        ("SciPy DOP853", SPRING),
        ("SciPy RK45 (ode45), matrices", galvi.problems.heavy_top()),
        ("DOP853 on quaternions, compiled", galvi.problems.heavy_top()),
        ("REBOUND BS", galvi.problems.kepler(0.3)),
    ):
        if reference(name).missing:
            continue
        loose = reference(name).run(problem, 1.0, {})
        tight = reference(name).run(problem, 1.0, {"tolerance": 1e-12})
        assert loose.success and "for a truth, set" in loose.status
        assert tight.status == "Completed."


def test_damping_keeps_a_chain_and_agrees_with_galvi():
    damped = replace(CHAIN, system=replace(CHAIN.system, force=lambda q, v: -0.3 * v))
    taken = [c.name for c in REFERENCES if c.supports(damped)]
    assert taken == ["SciPy DOP853, chains"]
    truth = reference(taken[0]).run(damped, 2.0, {"rtol": 3e-14, "atol": 1e-15})
    free = reference(taken[0]).run(CHAIN, 2.0, {"rtol": 3e-14, "atol": 1e-15})
    mine = galvi.integrate(damped, EIGHT, 0.02, 100)
    assert np.max(np.abs(mine.q[-1] - truth.q[-1])) < 1e-12  # 1.5e-14 when this was written
    assert np.max(np.abs(free.q[-1] - truth.q[-1])) > 0.1


def test_slopes_that_are_a_chains_own_keep_its_references_and_others_do_not():
    own = CHAIN.system.function.slopes
    names = [c.name for c in REFERENCES if c.supports(CHAIN)]
    given = replace(CHAIN, system=replace(CHAIN.system, slopes=lambda q, v: own(q, v)))
    kept = [c.name for c in REFERENCES if c.supports(given)]
    assert kept == names and len(kept) >= 3
    other = replace(CHAIN.system, slopes=lambda q, v: 1.001 * own(q, v), check=False)
    assert not [c.name for c in REFERENCES if c.supports(replace(CHAIN, system=other))]


@pytest.mark.parametrize(
    ("name", "meant"),
    [("Gauss", "gauss"), ("polynomials", "Polynomials"), ("Lobatto", "lobatto"),
     ("kepler", "problems.kepler"), ("nbody", "NBody")],
)  # fmt: skip
def test_a_name_in_another_case_has_a_hint(name, meant):
    with pytest.raises(
        AttributeError, match=rf"no attribute '{name}'. Did you mean galvi.{meant}\?"
    ):
        getattr(galvi, name)
    assert not hasattr(galvi, "nothing_like_it")


def test_rotations_of_another_form_are_refused_with_the_conversion():
    turn = Rotation.from_rotvec([0.1, 0.2, 0.3])
    body, free = galvi.RigidBody(MOMENTS), galvi.FreeBody(1.0, MOMENTS)
    for system, q0, remedy in (
        (body, turn, r"Give q0\.as_matrix\(\)\."),
        (body, turn.as_quat(), r"Rotation\.from_quat\(quaternion\)\.as_matrix\(\)"),
        (free, turn.as_quat(), r"Rotation\.from_quat"),
        (free, np.zeros(7), r"Rotation\.from_quat"),
    ):
        with pytest.raises(ValueError, match=remedy):
            galvi.Problem(system, q0, np.zeros(6 if system is free else 3))


@pytest.mark.parametrize(
    ("value", "remedy"),
    [(galvi.PlanarChain([1.0], [1.0]), r"galvi\.Lagrangian\(PlanarChain\(\.\.\.\), galvi\.Rn"),
     (galvi.CentralForce(1.0), r"galvi\.Canonical\(mass, CentralForce"),
     (galvi.UniformGravity(1.0, [0, 0, 1]), r"galvi\.RigidBody\(inertia, UniformGravity")],
)  # fmt: skip
def test_what_is_no_system_yet_is_refused_with_the_way_to_one(value, remedy):
    with pytest.raises(TypeError, match=remedy):
        galvi.Problem(value, [1.0], [0.0])


@pytest.mark.parametrize("rule", [galvi.gauss, galvi.lobatto, galvi.radau, galvi.clenshaw_curtis])
def test_too_many_points_are_refused_before_any_work(rule):
    with pytest.raises(ValueError, match=r"from . to 1000; received 100000\. .*galvi\.composite"):
        rule(100000)


def test_a_time_span_is_answered_with_the_arguments_of_a_run():
    for arguments, remedy in (
        ((SPRING, (0, 10), 0.1), r"Call galvi\.integrate\(problem, method, step, steps\)"),
        ((SPRING, EIGHT, (0, 10)), "given by steps or duration"),
    ):
        with pytest.raises((TypeError, ValueError), match=remedy):
            galvi.integrate(*arguments)


def test_an_uncertainty_far_below_a_number_shows_the_digits_it_leaves():
    assert with_uncertainty(1.5, 7.3e-6) == "1.5000000 \u00b1 0.0000073"
    assert with_uncertainty(1e-12, 2e-14) == "1.00·10⁻¹² \u00b1 2.0·10⁻¹⁴"


def test_resuming_keeps_what_is_saved(tmp_path):
    run = galvi.integrate(SPRING, EIGHT, 0.1, 20, save_every=10)
    galvi.save(run, tmp_path / "run.npz")
    for before in (run, galvi.load(tmp_path / "run.npz")):
        after = galvi.resume(before, 40)
        assert len(after.t) == 5 and after.curves is None
    assert len(galvi.resume(run, 4, save_every=2).t) == 3


def test_a_method_is_short_in_words():
    assert len(repr(galvi.Galerkin(galvi.Polynomials(60), galvi.gauss(60)))) < 80
