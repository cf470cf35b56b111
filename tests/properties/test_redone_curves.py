"""Curves of runs that saved none are the same to the bit as those of runs that did."""

import pickle

import numpy as np
import pytest

import galvi
from galvi.run import loop


def gauss(degree, chart=None):
    charts = {} if chart is None else {"chart": chart}
    return galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree), **charts)


CASES = {
    "canonical": (galvi.problems.kepler(0.3), gauss(8), -0.3),
    "point masses": (galvi.problems.outer_solar_system(particles=2), gauss(8), 300.0),
    "a law": (galvi.problems.double_pendulum(), gauss(6), 0.02),
    "a body": (galvi.problems.free_rigid_body(), gauss(6), 0.2),
    "a frame": (galvi.problems.outer_solar_system(), gauss(8, galvi.KeplerFrame()), -400.0),
}


@pytest.mark.parametrize("name", CASES)
def test_a_curve_that_was_not_kept_is_the_same_to_the_bit(name, tmp_path, monkeypatch):
    monkeypatch.setattr(loop, "STEPS_BETWEEN_STATES", 64)
    problem, method, h = CASES[name]
    full, thin, without_curves = (
        galvi.integrate(problem, method, h, 200, **options)
        for options in ({}, {"save_every": 70}, {"curves": False})
    )
    assert [checkpoint.first for checkpoint in thin.again.checkpoints] == [0, 64, 128, 192]
    joints = h * np.array([0, 1, 63, 64, 65, 128, 199, 200])
    times = np.append(joints, h * np.random.default_rng(3).uniform(0.0, 200.0, 12))
    galvi.save(thin, tmp_path / "thin.npz")
    for run in (
        thin,
        galvi.load(tmp_path / "thin.npz"),
        pickle.loads(pickle.dumps(thin)),
        without_curves,
    ):
        assert run.curves is None
        assert np.array_equal(run(times), full(times))
        assert np.array_equal(run.velocity(times), full.velocity(times))
    half = galvi.integrate(problem, method, h, 90)
    resumed_thin, resumed_full = (galvi.resume(half, 110, save_every=k) for k in (50, 1))
    later = times[times / h > 90.0]
    assert np.array_equal(resumed_thin(later), resumed_full(later))


def test_past_a_failure_there_is_nothing(monkeypatch):
    monkeypatch.setattr(loop, "STEPS_BETWEEN_STATES", 4)
    falling = galvi.Problem(
        galvi.Canonical(1.0, lambda q: -1.0 / q[0], lambda q: 1.0 / q**2), [1.0], [0.0]
    )
    failed = galvi.integrate(falling, gauss(4), 0.1, 40, save_every=40)
    with_curves = galvi.integrate(falling, gauss(4), 0.1, 40)
    assert not failed.success and failed.failed_step == with_curves.failed_step
    end = 0.1 * (with_curves.counts["steps"])
    times = np.array([0.0, 0.5 * end, end, end + 0.05, 4.0])
    assert np.array_equal(failed(times), with_curves(times), equal_nan=True)
    assert np.isnan(failed(4.0)).all() and np.isfinite(failed(end)).all()


def test_states_are_few_in_a_long_run():
    run = galvi.integrate(
        galvi.problems.harmonic_oscillator(), gauss(2), 0.1, 10**6, save_every=10**6
    )
    gaps = np.diff([checkpoint.first for checkpoint in run.again.checkpoints])
    assert len(run.again.checkpoints) <= loop.MAX_CHECKPOINTS + 1 and set(gaps) == {1954}


STIFFNESS = 1.0


def spring(q):
    return 0.5 * STIFFNESS * q @ q if q[0] < 1e300 else 0.0  # a branch, so that it is not traced


def pull(q):
    return STIFFNESS * q if q[0] < 1e300 else q


def lagrangian(q, v):
    return 0.5 * v @ v - spring(q)


def harmonic(q):
    return 0.5 * q @ q


def push(q, v):
    return -STIFFNESS * v if q[0] < 1e300 else v


SYSTEMS_WITH_STIFFNESS = {
    "a potential": galvi.Canonical(1.0, spring),
    "its gradient": galvi.Canonical(1.0, spring, pull),
    "a Lagrangian": galvi.Lagrangian(lagrangian, galvi.Rn(1)),
    "a force": galvi.Canonical(1.0, harmonic, force=push),
}


@pytest.mark.slow_cases("a Lagrangian-None", "a potential-clock4")
@pytest.mark.parametrize(
    ("name", "clock"),
    [
        *((name, None) for name in SYSTEMS_WITH_STIFFNESS),
        ("a potential", galvi.Clock(lambda q: 1.0 + q[0] ** 2)),
    ],
)
def test_a_run_whose_functions_have_changed_is_not_done_again(name, clock, monkeypatch):
    problem = galvi.Problem(SYSTEMS_WITH_STIFFNESS[name], [1.0], [0.5])
    method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), clock=clock)
    run, with_curves = (
        galvi.integrate(problem, method, 0.1, 12, curves=curves) for curves in (False, True)
    )
    assert run.curves is None and np.array_equal(run(0.42), with_curves(0.42))
    monkeypatch.setitem(globals(), "STIFFNESS", 4.0)
    for changed in (run, pickle.loads(pickle.dumps(run)) if clock is None else run):
        for evaluate in (changed, changed.velocity):
            with pytest.raises(ValueError, match="a number to which they refer has changed"):
                evaluate(0.42)
    monkeypatch.setitem(globals(), "STIFFNESS", 1.0)
    assert np.array_equal(run(0.42), with_curves(0.42))


def test_what_was_traced_is_kept(monkeypatch):
    """A run in lanes is that of the traced numbers, until its system is traced anew."""
    traced = galvi.Canonical(1.0, lambda q: 0.5 * STIFFNESS * q @ q)
    problem = galvi.Problem(traced, [1.0], [0.5])
    run, with_curves = (
        galvi.integrate(problem, gauss(4), 0.1, 12, curves=curves) for curves in (False, True)
    )
    monkeypatch.setitem(globals(), "STIFFNESS", 4.0)
    assert run.engine == "lanes" and np.array_equal(run(0.42), with_curves(0.42))
    later_run = galvi.integrate(problem, gauss(4), 0.1, 12)
    assert abs(later_run(0.42) - with_curves(0.42)) > 0.1
    with pytest.raises(ValueError, match="a number to which they refer has changed"):
        run(0.42)


@pytest.mark.slow_cases(but=["planets, steps", "planets, duration"])
@pytest.mark.parametrize(
    ("problem", "clock", "length"),
    [
        (galvi.problems.harmonic_oscillator(), galvi.Clock(lambda q: 1.0 + q @ q), {"steps": 12}),
        (galvi.problems.kepler(0.5), galvi.Sundman(), {"duration": 3.0}),
        (galvi.problems.outer_solar_system(), galvi.DynamicalTime(), {"steps": 12}),
        (galvi.problems.outer_solar_system(), galvi.DynamicalTime(), {"duration": 3.0}),
    ],
    ids=["oscillator", "Kepler", "planets, steps", "planets, duration"],
)
def test_a_step_in_a_clock_is_done_again_at_its_own_length(problem, clock, length):
    method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), clock=clock)
    with_curves, thin = (
        galvi.integrate(problem, method, 0.2, **length, curves=curves) for curves in (True, False)
    )
    times = np.linspace(problem.t0, with_curves.t[-1], 7)
    assert np.array_equal(thin(times), with_curves(times))
    assert np.array_equal(thin.velocity(times), with_curves.velocity(times))


def test_a_change_that_the_start_does_not_show_is_seen(monkeypatch):
    """In the origin the force is 0 whatever the stiffness, and so is the drag at rest."""
    for system, q0, v0 in (
        (galvi.Canonical(1.0, spring, pull), [0.0], [1.0]),
        (galvi.Canonical(1.0, harmonic, force=push), [1.0], [0.0]),
    ):
        run = galvi.integrate(galvi.Problem(system, q0, v0), gauss(4), 0.1, 20, curves=False)
        monkeypatch.setitem(globals(), "STIFFNESS", 4.0)
        with pytest.raises(ValueError, match="a number to which they refer has changed"):
            run(1.23)
        monkeypatch.setitem(globals(), "STIFFNESS", 1.0)
        run(1.23)


def test_a_bound_of_steps_that_is_never_reached_does_not_thin_out_the_known_states():
    sundman = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), clock=galvi.Sundman())
    bounded, free = (
        galvi.integrate(
            galvi.problems.kepler(0.5),
            sundman,
            0.02,
            steps,
            duration=60.0,
            curves=False,
            save_every=10**6,
        )
        for steps in (10**8, None)
    )
    assert len(bounded.again.checkpoints) == len(free.again.checkpoints) > 1
