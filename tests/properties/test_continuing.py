"""Runs that are resumed: in parts, from a file, after Ctrl-C."""

import signal
import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import galvi

KEPLER = galvi.problems.kepler(0.6)
HENON = galvi.problems.henon_heiles()
CHAIN = galvi.problems.fermi_pasta_ulam_tsingou(masses=6, beta=0.3)
FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_keeps_what_was_computed():
    timer = threading.Timer(0.5, signal.raise_signal, args=[signal.SIGINT])
    galvi.integrate(KEPLER, FOUR, 0.01, 2)
    timer.start()
    run = galvi.integrate(KEPLER, FOUR, 0.01, 50_000_000, save_every=1000)
    timer.join()
    assert run.outcome.end is galvi.End.INTERRUPTED and run.interrupted
    assert run.counts["steps"] == run.failed_step - 1 > 100
    resumed = galvi.resume(run, 100)
    assert resumed.success and resumed.t[0] == pytest.approx(0.01 * run.counts["steps"])
    completed = run.counts["steps"] // 1000
    assert np.isfinite(run.q[: completed + 1]).all() and np.isnan(run.q[completed + 1 :]).all()


def test_where_ctrl_c_is_ignored_it_stays_so():
    """The shell and nohup ignore it for processes in the background."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        timer = threading.Timer(0.01, signal.raise_signal, args=[signal.SIGINT])
        timer.start()
        run = galvi.integrate(KEPLER, FOUR, 0.01, 20_000, save_every=1000)
        timer.join()
        assert run.success and signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


@given(first=st.integers(1, 59), save_every=st.integers(1, 7))
def test_a_run_in_two_parts_is_one_long_run_to_the_bit(first, save_every):
    uncut = galvi.integrate(KEPLER, FOUR, 0.31, 60)
    part = galvi.integrate(KEPLER, FOUR, 0.31, first, save_every=save_every)
    resumed = galvi.resume(part, 60 - first, save_every=1)
    assert np.array_equal(resumed.q, uncut.q[first:])
    assert np.array_equal(resumed.p, uncut.p[first:])
    assert np.array_equal(resumed.t, uncut.t[first:])
    assert np.allclose(resumed(resumed.t[0] + 0.1), uncut(resumed.t[0] + 0.1), rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("problem", "step", "solver"),
    [(CHAIN, 0.3, "newton"), (galvi.problems.solar_system(), 5.0, "auto")],
)
def test_a_saved_run_comes_back_and_goes_on_to_the_bit(problem, step, solver, tmp_path):
    uncut = galvi.integrate(problem, FOUR, step, 40, solver=solver)
    galvi.save(galvi.integrate(problem, FOUR, step, 25, solver=solver), tmp_path / "run.npz")
    part = galvi.load(tmp_path / "run.npz")
    resumed = galvi.resume(part, 15)
    assert part.method == FOUR
    assert np.array_equal(resumed.q, uncut.q[25:]) and np.array_equal(resumed.p, uncut.p[25:])
    assert (resumed.counts["linear_solves"] > 0) == (solver == "newton")
    assert np.array_equal(part(step * 7.3), uncut(step * 7.3))
    assert np.array_equal(galvi.energy(part), galvi.energy(uncut)[:26])


def test_a_saved_run_of_functions_asks_for_its_problem(tmp_path):
    path = tmp_path / "run.npz"
    uncut = galvi.integrate(HENON, FOUR, 0.3, 20)
    galvi.save(galvi.integrate(HENON, FOUR, 0.3, 10), path)
    with pytest.raises(ValueError, match=r"needs its problem, because .* use galvi.load\(path, pr"):
        galvi.load(path)
    with pytest.raises(ValueError, match="received another q0, v0 or t0"):
        galvi.load(path, galvi.problems.henon_heiles(0.12))
    assert np.array_equal(galvi.resume(galvi.load(path, HENON), 10).q, uncut.q[10:])


def test_files_that_are_no_runs_are_refused(tmp_path):
    path = tmp_path / "not.npz"
    path.write_bytes(b"something else")
    with pytest.raises(ValueError, match=r"must be a run written by galvi.save"):
        galvi.load(path)
    with pytest.raises(FileNotFoundError):
        galvi.load(tmp_path / "absent.npz")
