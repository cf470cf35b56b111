"""Many at once: what is refused, and which problem is named."""

import tracemalloc

import numba
import numpy as np
import psutil
import pytest

import galvi
from galvi.run import request
from galvi.run.request import RunRequest, check_memory

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
KEPLER = galvi.problems.kepler(0.3)


@pytest.mark.parametrize("where", [0, 2, 3])
def test_what_a_function_raises_tells_which_problem_it_was(where):
    def gradient(q):
        if q[1] > 5.0:
            raise RuntimeError("out of the table")
        return q

    system = galvi.Canonical(1.0, lambda q: 0.5 * q @ q, gradient)
    calm = galvi.Problem(system, [1.0, 0.0], [0.0, 1.0])
    starts = [calm] * 4
    starts[where] = calm.with_initial_state([1.0, 0.0], [0.0, 9.0])
    with pytest.raises(RuntimeError, match="out of the table") as caught:
        galvi.integrate_many(starts, EIGHT, 0.1, 100)
    assert caught.value.__notes__ == [f"This was problems[{where}]."]


@numba.njit
def raising(q):
    if q[0] < 0.0:
        raise ValueError("no such place")
    return q


def test_a_jitted_function_that_raises_in_a_thread_is_told_too():
    system = galvi.Canonical(1.0, lambda q: 0.5 * q @ q, raising)
    start = galvi.Problem(system, [1.0], [0.0])
    with pytest.raises(ValueError, match="no such place") as caught:
        galvi.integrate_many([start] * 3, EIGHT, 0.5, 20, threads=2)
    assert caught.value.__notes__ == ["This was problems[0]."]


def test_memory_is_counted_for_each_problem_by_its_own_size(monkeypatch):
    """One of 100 bodies among 999 small ones: 2,298 components, not 300 for each of 1,000."""
    places = np.random.default_rng(3).standard_normal((2, 100, 3))
    large = galvi.Problem(galvi.NBody(np.full(100, 1e-3)), *places)
    monkeypatch.setattr(request, "free_memory", lambda: float(2**30))
    big, small = (
        RunRequest.checked(one, EIGHT, 0.1, 10_000, curves=False) for one in (large, KEPLER)
    )
    check_memory([big] + [small] * 999)
    with pytest.raises(ValueError, match=r"1000 runs of 10000 steps would keep 67\.1 GiB in all"):
        check_memory([big] * 1000)
    with pytest.raises(ValueError, match="2 runs of 300000 steps would keep") as caught:
        galvi.integrate_many([large, KEPLER], EIGHT, 0.1, 300_000, curves=False)
    assert not hasattr(caught.value, "__notes__")  # no single problem is at fault


@pytest.mark.parametrize("curves", [True, False])
def test_the_memory_counted_is_what_a_run_takes(curves, monkeypatch):
    problem = galvi.problems.outer_solar_system()
    galvi.integrate(problem, EIGHT, 10.0, 2)
    run = RunRequest.checked(problem, EIGHT, 10.0, 4000, curves=curves)
    tracemalloc.start()
    galvi.integrate(problem, EIGHT, 10.0, 4000, curves=curves)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    monkeypatch.setattr(request, "ALWAYS_FREE", 0.0)
    monkeypatch.setattr(request, "free_memory", lambda: 1.1 * peak)
    check_memory([run])
    monkeypatch.setattr(request, "free_memory", lambda: 0.9 * peak)
    with pytest.raises(ValueError, match=r"^4000 steps would .* that are free on this machine"):
        check_memory([run])
    monkeypatch.setattr(request, "free_memory", lambda: 2.0**20)
    with pytest.raises(ValueError, match=r"more than the 0\.000977 GiB that are free"):
        check_memory([run])


def test_the_free_memory_is_a_part_of_all():
    everything = psutil.virtual_memory().total
    assert 1e-3 * everything < request.free_memory() <= everything


@pytest.mark.parametrize("problem", [KEPLER, galvi.problems.heavy_top()])
def test_numbers_that_fill_the_counters_are_whole_numbers_too(problem):
    assert galvi.integrate(problem, EIGHT, 0.01, 3, save_every=2**62).t.size == 2


def test_a_bad_problem_is_told_apart():
    centre = KEPLER.with_initial_state([0.0, 0.0], [0.0, 1.0])
    with pytest.raises(ValueError, match="potential must be finite at the start") as caught:
        galvi.integrate_many([KEPLER, centre], EIGHT, 0.1, 3)
    assert caught.value.__notes__ == ["This was problems[1]."]
