"""Runs as objects of SciPy and xarray, plots, citations, orbital elements, and resumed runs."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import matplotlib
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp

import galvi
from galvi.diagnostics.orbits import _anomaly
from galvi.run.request import steps_until
from references.rebound.ias15 import IAS15

matplotlib.use("Agg")
pytest.importorskip("rebound")
EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
SIX = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))


@pytest.fixture(scope="module")
def orbit():
    return galvi.integrate(galvi.problems.kepler(0.3), EIGHT, 0.1, 20)


def test_an_import_needs_no_engine_and_a_missing_one_is_a_sentence(orbit, monkeypatch):
    calls = {
        "matplotlib": orbit.plot,
        "xarray": orbit.to_xarray,
        "rebound": lambda: galvi.from_rebound("x"),
    }
    code = f"import sys; sys.modules.update(dict.fromkeys({list(calls)})); import galvi"
    subprocess.run([sys.executable, "-c", code], check=True)
    for name, call in calls.items():
        monkeypatch.setitem(sys.modules, name, None)
        with pytest.raises(ModuleNotFoundError, match=f"Install it: pip install {name}"):
            call()


@pytest.mark.slow(beside="test_a_run_as_a_result_of_scipy")
def test_a_run_as_a_data_set_of_xarray():
    run = galvi.integrate(galvi.problems.outer_solar_system(), EIGHT, 5.0, 10)
    dataset = run.to_xarray()
    assert dataset["q"].dims == ("t", "body", "axis") and dataset.attrs["steps"] == 10
    planet = dataset["q"].sel(body="Jupiter", axis="y")
    assert np.array_equal(planet, run.q[:, 1, 1]) and np.array_equal(dataset["t"], run.t)
    assert np.array_equal(dataset["v"], run.v) and np.array_equal(
        dataset["energy"], galvi.energy(run)
    )
    for problem, dims in (
        (galvi.problems.free_rigid_body(), ("t", "row", "column")),
        (galvi.problems.kepler(0.3), ("t", "coordinate")),
        (galvi.problems.skew_arm(floating=True), ("t", "entry")),
    ):
        dataset = galvi.integrate(problem, SIX, 0.1, 3).to_xarray()
        assert dataset["q"].dims == dims and dataset["p"].dims == dataset["v"].dims
    assert dataset["velocity"].values[[0, 5, 6]].tolist() == [
        "free of body, 0",
        "free of body, 5",
        "hinge of link 1",
    ]


def test_a_run_as_a_result_of_scipy(orbit):
    run, solution = orbit, orbit.to_scipy()
    assert solution.success and solution.status == 0 and solution.message == "Completed."
    assert solution.nfev == run.counts["force_evaluations"] and len(run) == solution.t.size == 21
    assert np.array_equal(solution.y[:2].T, run.q) and np.array_equal(solution.y[2:].T, run.p)
    assert solution.sol(0.05).shape == (4,) and solution.sol([0.05, 0.06, 0.07]).shape == (4, 3)
    for rows, limit in ((slice(0, 2), 1e-13), (slice(2, 4), 1e-6)):  # q' jumps between the steps
        ends = solution.sol(run.t[1:-1])[rows]
        assert np.allclose(ends, solution.y[rows, 1:-1], rtol=0, atol=limit)
    sparse = galvi.integrate(galvi.problems.free_rigid_body(), SIX, 0.1, 20, save_every=10)
    solution = sparse.to_scipy()
    assert solution.y.shape == (12, 3) and solution.sol(0.75).shape == (12,)
    assert IAS15.run(run.problem, 1.0, {"samples": 1}).to_scipy().sol is None
    failing = galvi.integrate(sparse.problem, SIX, 1.2, 3).to_scipy()
    assert not failing.success and failing.status == -1 and "Stopped" in failing.message


@pytest.mark.parametrize(
    "name",
    [
        "solar_system",
        "free_rigid_body",
        "double_pendulum",
        "free_body_se3",
        "brownout",
        "kepler",
        "planar_pendulum",
    ],
)
def test_every_kind_of_run_has_a_picture(name):
    import matplotlib.pyplot as plt

    problem = getattr(galvi.problems, name)()
    step, save_every = 4.0 if name == "solar_system" else 0.05, 5 if name == "kepler" else 1
    run = galvi.integrate(problem, SIX, step, 20, save_every=save_every)
    figure = run.plot()
    motion, invariant = figure.axes
    assert motion.get_lines() and invariant.get_lines()
    assert all(np.all(np.isfinite(line.get_xydata())) for line in invariant.get_lines())
    assert figure.get_suptitle() == problem.name
    if name == "free_body_se3":
        assert "".join(text.get_text() for text in motion.get_legend().get_texts()) == "xyz"
        shown = np.stack([line.get_ydata() for line in motion.get_lines()])
        assert np.array_equal(shown[:, :: shown.shape[1] // 20].T, run.q[:, :3, 3])
    plt.close(figure)


def test_a_citation_names_what_was_used_and_nothing_else(orbit):
    run = galvi.integrate(galvi.problems.solar_system(), EIGHT, 4.0, 2)
    cited = galvi.cite(run)
    keys = [line.split("{")[1].rstrip(",") for line in cited.bibtex.splitlines() if "@" in line]
    assert keys == ["Hall2013", "Miglio2016", "galvi", "Folkner2009"]
    assert all(f"{key}" in cited.sentence for key in keys)
    assert galvi.__version__ in cited.sentence and galvi.__version__ in cited.bibtex
    of_ias15 = galvi.cite(IAS15.run(orbit.problem, 1.0, {"samples": 1}))
    assert "Hall2013" not in str(of_ias15)
    assert {"ReinLiu2012", "ReinSpiegel2015", "galvi"} <= set(
        of_ias15.sentence.replace("]", "[").replace(", ", "[").split("[")
    )
    assert cited.bibtex.count("{") == cited.bibtex.count("}")
    problem_of_another_source = replace(
        run.problem, parameters={"source": "not DE421"}, units="of DE421"
    )
    assert "Folkner2009" not in str(
        galvi.cite(galvi.integrate(problem_of_another_source, EIGHT, 4.0, 2))
    )
    with pytest.raises(TypeError, match="run must be"):
        galvi.cite(3)


@settings(max_examples=60)
@given(
    e=st.one_of(st.floats(0.0, 0.999), st.floats(1.001, 50.0)),
    size=st.floats(1e-3, 1e3),
    angles=st.tuples(st.floats(0.01, 3.1), *(st.floats(0.0, 6.28),) * 2),
    mean=st.floats(-3.0, 3.0),
)
def test_elements_and_states_are_inverse(e, size, angles, mean):
    a = np.array([[size if e < 1.0 else -size]])
    ones = np.ones_like(a)
    elements = galvi.OrbitalElements(a, e * ones, *(x * ones for x in angles), mean * ones)
    q, v = elements.states(2.0)
    system = galvi.NBody([2.0, 0.0])
    positions = np.concatenate([np.zeros((1, 1, 3)), q], axis=1)
    velocities = np.concatenate([np.zeros((1, 1, 3)), v], axis=1)
    problem = galvi.Problem(system, positions[0], velocities[0])
    run = galvi.Trajectory(problem, np.zeros(1), positions, velocities, velocities=velocities)
    returned = galvi.orbital_elements(run)
    r = float(np.linalg.norm(q))
    scale = (1.0 + e) * max(1.0, size / r) / abs(1.0 - e)
    assert abs(returned.semi_major_axis / a - 1.0) < 1e-14 * scale
    assert abs(returned.eccentricity - e) < 1e-14 * scale * (1.0 + e)
    returned_states = returned.states(2.0)
    assert np.allclose(returned_states[0], q, rtol=0, atol=1e-13 * scale * r)
    assert np.allclose(returned_states[1], v, rtol=0, atol=1e-13 * scale * np.linalg.norm(v))


@pytest.mark.parametrize("e", [0.0, 0.3, 0.99, 1.0 - 1e-9, 1.0 + 1e-9, 1.01, 30.0])
@pytest.mark.parametrize("mean", [1e-12, 1e-6, 0.01, 1.0, 3.1, -2.0])
def test_keplers_equation_against_arbitrary_precision(e, mean):
    anomaly = float(_anomaly(np.array(e), np.array(mean), np.array(e < 1.0)))
    with mp.workdps(60):
        eccentricity, M = mp.mpf(e), mp.mpf(mean)
        equation = (
            (lambda x: x - eccentricity * mp.sin(x) - M)
            if e < 1
            else (lambda x: eccentricity * mp.sinh(x) - x - M)
        )
        exact = mp.findroot(equation, mp.mpf(anomaly))
        slope = abs(mp.diff(equation, exact))
        # An error of half a unit in E or e sin E moves the root by this much.
        tolerance = 4e-16 * (abs(exact) * (1 + e) / slope + abs(exact))
    assert abs(anomaly - exact) < tolerance


def test_a_run_resumes_until_a_time(orbit):
    uncut = galvi.integrate(orbit.problem, EIGHT, 0.1, 50)
    resumed = galvi.resume(orbit, until=5.0)
    assert np.array_equal(resumed.q, uncut.q[20:])
    assert (
        steps_until(2451544.507, 2451544.5, 1e-3, 0) == 7
    )  # times of this size are rounded to 5e-10
    for bad, message in ((5.05, "a whole number of steps after"), (1.0, "where the run ends")):
        with pytest.raises(ValueError, match=message):
            galvi.resume(uncut, until=bad)
    with pytest.raises(ValueError, match="give one of steps, duration and until"):
        galvi.resume(uncut, 5, until=9.0)
