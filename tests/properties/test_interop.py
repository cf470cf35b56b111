"""From and to REBOUND and SciPy, pictures, citations, elements of orbits, resuming until a time."""

from __future__ import annotations

import pickle
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
from galvi.interop import rebound as reader
from galvi.run.request import steps_until
from references.rebound.ias15 import IAS15

matplotlib.use("Agg")
rebound = pytest.importorskip("rebound")
EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
SIX = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))


def simulation(active: bool = True):
    """A star, a planet and an asteroid, at t = 3 years."""
    sim = rebound.Simulation()
    sim.units = ("AU", "yr", "Msun")
    sim.add(m=1.0, name="Sun")
    sim.add(m=1e-3, a=1.0, e=0.1, inc=0.1, name="Planet")
    sim.add(m=0.0 if active else 1e-6, a=2.1, e=0.05)
    if not active:
        sim.N_active = 2
    sim.integrator = "whfast"
    sim.integrator.safe_mode, sim.integrator.keep_unsynchronized = 0, 1
    sim.dt = 0.01
    sim.steps(300)
    return sim


@pytest.mark.parametrize("active", [True, False])
def test_a_simulation_comes_in_with_all_it_has_and_stays_as_it_was(active):
    sim = simulation(active)
    before = sim.particles[1].x
    problem = galvi.from_rebound(sim)
    assert not sim.is_synchronized and sim.particles[1].x == before  # as it was
    assert problem.t0 == sim.t and problem.system.G == sim.G
    assert problem.units == "length au, time yr, mass msun"
    assert problem.parameters["bodies"] == ("Sun", "Planet", "2")
    assert problem.parameters["integrator"] == "whfast" and problem.parameters["dt"] == 0.01
    assert problem.system.masses.tolist() == [1.0, 1e-3, 0.0]
    sim.synchronize()
    assert np.array_equal(problem.q0, [p.xyz for p in sim.particles])


@pytest.mark.parametrize("active", [True, False])
def test_the_run_of_a_simulation_goes_out_with_all_it_has(active):
    sim = simulation(active)
    problem = galvi.from_rebound(sim)
    run = galvi.integrate(problem, EIGHT, 0.1, 100)
    truth = IAS15.run(problem, 10.0, {"samples": 1})
    assert np.max(np.abs(run.q[-1] - truth.q[-1])) < 1e-11
    out = run.to_rebound()
    assert out.units == sim.units and out.G == sim.G and out.t == run.t[-1]
    assert [p.name for p in out.particles] == ["Sun", "Planet", None] and out.N_active == 2
    assert out.energy() == pytest.approx(galvi.energy(run)[-1], rel=1e-14)
    again = galvi.from_rebound(run.to_rebound(at=7))
    assert again.t0 == run.t[7] and np.array_equal(again.q0, run.q[7])
    assert np.array_equal(again.v0, run.v[7])


@pytest.mark.slow(
    beside="test_reading_rebound.py::test_the_usual_time_between_the_states_of_an_archive_is_read"
)
def test_snapshots_of_an_archive(tmp_path):
    path, sim = tmp_path / "run.bin", simulation()
    sim.save_to_file(str(path))
    sim.integrate(5.0)
    sim.save_to_file(str(path))
    times = [galvi.from_rebound(path, snapshot=k).t0 for k in (0, 1, -1)]
    assert times[1] == times[2] == sim.t > times[0]
    assert galvi.from_rebound(str(path)).parameters["bodies"] == ("Sun", "Planet", "2")
    with pytest.raises(ValueError, match="snapshot must be a whole number from -2 to 1"):
        galvi.from_rebound(path, snapshot=2)
    whole, broken = path.read_bytes(), tmp_path / "broken.bin"
    for content in (b"", b"no archive", whole[:100], whole[: len(whole) // 2]):
        broken.write_bytes(content)
        with pytest.raises(ValueError, match=r"broken\.bin must be a file of REBOUND's"):
            galvi.from_rebound(broken)
    with pytest.raises(FileNotFoundError, match="there is no file"):
        galvi.from_rebound(tmp_path / "absent.bin")


def test_a_file_is_read_in_another_process_which_may_crash(tmp_path, monkeypatch):
    path, sim = tmp_path / "run.bin", simulation()
    sim.save_to_file(str(path))
    there = galvi.from_rebound(path)
    monkeypatch.setattr(rebound, "Simulationarchive", None)  # here nothing is read
    assert there.q0.tobytes() == galvi.from_rebound(path).q0.tobytes()
    assert pickle.loads(pickle.dumps(galvi.from_rebound(sim))).parameters == there.parameters
    program, damaged = tmp_path / "program.py", "it is damaged: REBOUND crashes"
    monkeypatch.setattr(reader, "READER", str(program))
    for text, words in (
        ("import os; os.kill(os.getpid(), 6)", damaged),
        ("import os; os.kill(os.getpid(), 11)", damaged),
        ("import os; os._exit(3)", damaged),
        ("import galvi_absent", "ended with: ModuleNotFoundError: No module named"),
    ):
        program.write_text(text)
        with pytest.raises(ValueError, match=words):
            galvi.from_rebound(path)


@pytest.mark.parametrize("snapshot", ["x", 1.5, True, None])
def test_a_snapshot_is_a_whole_number(tmp_path, snapshot):
    simulation().save_to_file(str(tmp_path / "run.bin"))
    with pytest.raises(ValueError, match=r"snapshot must be a whole number; received .* -1 is"):
        galvi.from_rebound(tmp_path / "run.bin", snapshot=snapshot)


def forces(sim):
    sim.additional_forces = lambda pointer: None


def variations(sim):
    sim.add_variation()


def pulling(sim):
    sim.N_active, sim.testparticle_type, sim.particles[2].m = 2, 1, 1e-6


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(
    ("change", "named"),
    [
        (forces, "additional forces"),
        (lambda sim: setattr(sim, "collision", "direct"), "collisions"),
        (lambda sim: setattr(sim, "softening", 0.1), r"softening \(0\.1\)"),
        (variations, "variational particles"),
        (pulling, "test particles that pull"),
    ],
)
def test_what_is_more_than_point_masses_is_refused_by_name(change, named):
    sim = simulation()
    change(sim)
    with pytest.raises(ValueError, match=named):
        galvi.from_rebound(sim)


def test_forces_of_reboundx_are_refused_with_what_to_give():
    sim = simulation()
    forces(sim)
    sim.extras = 1  # as REBOUNDx sets it
    for give in (galvi.from_rebound, galvi.judge):
        with pytest.raises(ValueError, match=r"additional forces\. Give .*extras=rebx\)\.$"):
            give(sim)
    sim.softening = 0.1
    with pytest.raises(ValueError, match=r"extras=rebx\)\. Remove softening \(0\.1\) in REBOUND"):
        galvi.from_rebound(sim)


def test_what_is_no_simulation_is_refused():
    with pytest.raises(ValueError, match="must have particles"):
        galvi.from_rebound(rebound.Simulation())
    with pytest.raises(TypeError, match=r"source must be a rebound\.Simulation"):
        galvi.from_rebound(3)
    swing = galvi.integrate(galvi.problems.planar_pendulum(), SIX, 0.1, 2)
    with pytest.raises(ValueError, match="holds point masses"):
        swing.to_rebound()
    with pytest.raises(ValueError, match="at must be a whole number from -3 to 2"):
        galvi.integrate(galvi.from_rebound(simulation()), SIX, 0.1, 2).to_rebound(at=3)


def test_an_import_needs_no_engine_and_a_missing_one_is_a_sentence():
    code = (
        "import sys; sys.modules['rebound'] = sys.modules['matplotlib'] = None\n"
        "import galvi\n"
        "run = galvi.integrate(galvi.problems.kepler(0.1), "
        "galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6)), 0.1, 2)\n"
        "for one in (run.plot, lambda: galvi.from_rebound('x')):\n"
        "    try: one()\n"
        "    except ModuleNotFoundError as error: print(error)\n"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert told.stdout.splitlines() == [
        "matplotlib is not installed. Install it: pip install matplotlib.",
        "REBOUND is not installed. Install it: pip install rebound.",
    ]


@pytest.mark.slow(beside="test_a_run_as_a_result_of_scipy")
def test_a_run_as_a_data_set_of_xarray():
    problem = galvi.from_rebound(simulation())
    run = galvi.integrate(problem, EIGHT, 0.1, 10)
    found = run.to_xarray()
    assert found["q"].dims == ("t", "body", "axis") and found.attrs["steps"] == 10
    planet = found["q"].sel(body="Planet", axis="y")
    assert np.array_equal(planet, run.q[:, 1, 1]) and np.array_equal(found["t"], run.t)
    assert np.array_equal(found["v"], run.v) and np.array_equal(found["energy"], galvi.energy(run))
    for other, dims in (
        (galvi.problems.free_rigid_body(), ("t", "row", "column")),
        (galvi.problems.kepler(0.3), ("t", "coordinate")),
        (galvi.problems.skew_arm(floating=True), ("t", "entry")),
    ):
        found = galvi.integrate(other, SIX, 0.1, 3).to_xarray()
        assert found["q"].dims == dims and found["p"].dims == found["v"].dims
    assert found["velocity"].values[[0, 5, 6]].tolist() == [
        "free of body, 0", "free of body, 5", "hinge of link 1",
    ]  # fmt: skip


def test_xarray_is_imported_when_called(monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    run = galvi.integrate(galvi.problems.kepler(0.3), SIX, 0.1, 3)
    with pytest.raises(ModuleNotFoundError, match="pip install xarray"):
        run.to_xarray()


def test_a_run_as_a_result_of_scipy():
    problem = galvi.problems.kepler(0.3)
    run = galvi.integrate(problem, EIGHT, 0.1, 20)
    found = run.to_scipy()
    assert found.success and found.status == 0 and found.message == "Completed."
    assert found.nfev == run.counts["force_evaluations"] and len(run) == found.t.size == 21
    assert np.array_equal(found.y[:2].T, run.q) and np.array_equal(found.y[2:].T, run.p)
    assert found.sol(0.05).shape == (4,) and found.sol([0.05, 0.06, 0.07]).shape == (4, 3)
    for rows, limit in ((slice(0, 2), 1e-13), (slice(2, 4), 1e-6)):  # q' jumps between the steps
        ends = found.sol(run.t[1:-1])[rows]
        assert np.allclose(ends, found.y[rows, 1:-1], rtol=0, atol=limit)
    sparse = galvi.integrate(galvi.problems.free_rigid_body(), SIX, 0.1, 20, save_every=10)
    found = sparse.to_scipy()
    assert found.y.shape == (12, 3) and found.sol(0.75).shape == (12,)
    assert IAS15.run(problem, 1.0, {"samples": 1}).to_scipy().sol is None
    failing = galvi.integrate(galvi.problems.solar_system(), SIX, 500.0, 3).to_scipy()
    assert not failing.success and failing.status == -1 and "Stopped" in failing.message


@pytest.mark.parametrize(
    "name",
    ["solar_system", "free_rigid_body", "double_pendulum", "free_body_se3", "brownout", "kepler",
     "henon_heiles", "planar_pendulum"],
)  # fmt: skip
def test_every_kind_of_run_has_a_picture(name):
    import matplotlib.pyplot as plt

    problem = getattr(galvi.problems, name)()
    step = 4.0 if name == "solar_system" else 0.05
    for save_every in (1, 5):
        run = galvi.integrate(problem, SIX, step, 20, save_every=save_every)
        figure = run.plot()
        motion, invariant = figure.axes
        assert motion.get_lines() and invariant.get_lines()
        assert all(np.all(np.isfinite(line.get_xydata())) for line in invariant.get_lines())
        assert figure.get_suptitle() == problem.name
        if name == "free_body_se3":
            assert "".join(text.get_text() for text in motion.get_legend().get_texts()) == "xyz"
            shown = np.stack([line.get_ydata() for line in motion.get_lines()])
            assert save_every == 1 or np.array_equal(shown.T, run.q[:, :3, 3])
        plt.close(figure)


def test_a_citation_names_what_was_used_and_nothing_else():
    run = galvi.integrate(galvi.problems.solar_system(), EIGHT, 4.0, 2)
    cited = galvi.cite(run)
    keys = [line.split("{")[1].rstrip(",") for line in cited.bibtex.splitlines() if "@" in line]
    assert keys == ["Hall2013", "Miglio2016", "galvi", "Folkner2009"]
    assert all(f"{key}" in cited.sentence for key in keys)
    assert galvi.__version__ in cited.sentence and galvi.__version__ in cited.bibtex
    other = galvi.cite(IAS15.run(galvi.from_rebound(simulation()), 1.0, {"samples": 1}))
    assert "Hall2013" not in str(other)
    assert {"ReinLiu2012", "ReinSpiegel2015", "galvi"} <= set(
        other.sentence.replace("]", "[").replace(", ", "[").split("[")
    )
    assert cited.bibtex.count("{") == cited.bibtex.count("}")
    beside = replace(run.problem, parameters={"source": "not DE421"}, units="of DE421")
    assert "Folkner2009" not in str(galvi.cite(galvi.integrate(beside, EIGHT, 4.0, 2)))
    with pytest.raises(TypeError, match="run must be"):
        galvi.cite(3)


@settings(max_examples=200)
@given(
    e=st.one_of(st.floats(0.0, 0.999), st.floats(1.001, 50.0)),
    size=st.floats(1e-3, 1e3),
    angles=st.tuples(st.floats(0.01, 3.1), *(st.floats(0.0, 6.28),) * 2),
    mean=st.floats(-3.0, 3.0),
)
def test_elements_and_states_are_inverse(e, size, angles, mean):
    a = np.array([[size if e < 1.0 else -size]])
    ones = np.ones_like(a)
    given_ = galvi.OrbitalElements(a, e * ones, *(x * ones for x in angles), mean * ones)
    q, v = given_.states(2.0)
    system = galvi.NBody([2.0, 0.0])
    places = np.concatenate([np.zeros((1, 1, 3)), q], axis=1)
    speeds = np.concatenate([np.zeros((1, 1, 3)), v], axis=1)
    problem = galvi.Problem(system, places[0], speeds[0])
    run = galvi.Trajectory(problem, np.zeros(1), places, speeds, velocities=speeds)
    back = galvi.orbital_elements(run)
    r = float(np.linalg.norm(q))
    scale = (1.0 + e) * max(1.0, size / r) / abs(1.0 - e)
    assert abs(back.semi_major_axis / a - 1.0) < 1e-14 * scale
    assert abs(back.eccentricity - e) < 1e-14 * scale * (1.0 + e)
    again = back.states(2.0)
    assert np.allclose(again[0], q, rtol=0, atol=1e-13 * scale * r)
    assert np.allclose(again[1], v, rtol=0, atol=1e-13 * scale * np.linalg.norm(v))


@pytest.mark.parametrize("e", [0.0, 0.3, 0.99, 1.0 - 1e-9, 1.0 + 1e-9, 1.01, 30.0])
@pytest.mark.parametrize("mean", [1e-12, 1e-6, 0.01, 1.0, 3.1, -2.0])
def test_keplers_equation_against_arbitrary_precision(e, mean):
    found = float(_anomaly(np.array(e), np.array(mean), np.array(e < 1.0)))
    with mp.workdps(60):
        big, M = mp.mpf(e), mp.mpf(mean)
        equation = (lambda x: x - big * mp.sin(x) - M) if e < 1 else (
            lambda x: big * mp.sinh(x) - x - M
        )  # fmt: skip
        exact = mp.findroot(equation, mp.mpf(found))
        slope = abs(mp.diff(equation, exact))
        # An error of half a unit in E or e sin E moves the root by this much.
        limit = 4e-16 * (abs(exact) * (1 + e) / slope + abs(exact))
    assert abs(found - exact) < limit


def test_a_run_resumes_until_a_time():
    problem = galvi.problems.kepler(0.3)
    whole = galvi.integrate(problem, EIGHT, 0.1, 50)
    rest = galvi.resume(galvi.integrate(problem, EIGHT, 0.1, 20), until=5.0)
    assert np.array_equal(rest.q, whole.q[20:])
    assert steps_until(2451544.507, 2451544.5, 1e-3, 0) == 7  # as well as such times are known
    for bad, words in ((5.05, "a whole number of steps after"), (1.0, "where the run ends")):
        with pytest.raises(ValueError, match=words):
            galvi.resume(whole, until=bad)
    with pytest.raises(ValueError, match="give one of steps, duration and until"):
        galvi.resume(whole, 5, until=9.0)
