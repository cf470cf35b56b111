"""Stored truths of planets, bodies, chains and Lagrangians, the ephemeris, and their sources."""

from __future__ import annotations

import decimal
import hashlib
import importlib
from importlib import resources

import numpy as np
import pytest

import galvi
from references.heyoka.engine import QUADRUPLE
from references.heyoka.taylor import HEYOKA_QUADRUPLE
from references.jpl import states as jpl
from references.jpl.ephemeris import JPL_EPHEMERIS, differences
from references.rebound.ias15 import IAS15
from references.scipy.ivp import DOP853, TIGHT
from references.scipy.lagrangian_ivp import CHAIN_DOP853, LAGRANGIAN_DOP853
from references.scipy.rigid_ivp import RIGID_DOP853
from references.stored import provenance
from references.stored.attitude import STORED_ATTITUDE
from references.stored.chain import STORED_CHAIN
from references.stored.encounters import ENCOUNTERS, burrau
from references.stored.lagrangian import STORED_LAGRANGIAN
from references.stored.planets import (
    CASES,
    FOLDER,
    STORED_TRUTH,
    sampled,
    stored,
    with_stored_start,
)
from references.textbook.quaternions import QUATERNION_DOP853

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
PENDULUM = STORED_ATTITUDE.cases["pendulum_3d"][0]
double, sprung = galvi.problems.double_pendulum, galvi.problems.elastic_pendulum
chain = galvi.problems.fermi_pasta_ulam_tsingou
SIMILAR_PROBLEMS = {  # problems that differ slightly from those whose motions are stored
    STORED_ATTITUDE: (
        galvi.problems.pendulum_3d(weight=np.nextafter(9.81, 10.0)),
        galvi.problems.pendulum_3d(inverted=True),
        galvi.problems.heavy_top(spin=np.nextafter(8.0, 9.0)),
        galvi.problems.free_rigid_body(),
        PENDULUM.with_initial_state(PENDULUM.q0, np.nextafter(PENDULUM.v0, 9.0)),
    ),
    STORED_CHAIN: (
        double(gravity=np.nextafter(9.81, 10.0)),
        double(angles=(2.0, np.nextafter(2.5, 3.0))),
        galvi.problems.planar_chain(4),
        galvi.problems.planar_pendulum(),
    ),
    STORED_LAGRANGIAN: (
        sprung(gravity=np.nextafter(9.81, 10.0)),
        sprung(mass=2.0, stiffness=80.0),  # the same motion, with other momenta
        sprung(angle=np.nextafter(1.5, 2.0)),
        chain(14),
        chain(beta=1e-15),
        galvi.problems.henon_heiles(0.11),
        galvi.problems.kepler_polar(),
    ),
}
TRUTH_OF_CASE = {case: truth for truth in SIMILAR_PROBLEMS for case in truth.makers}
# case, peer, setting, duration, bounds on the errors of q and p; measured errors in comments
COMPILED, SLOW, CHAINS = {"tolerance": 1e-15}, {"tolerance": 1e-12}, {"rtol": 3e-14, "atol": 1e-15}
PEERS = (
    ("heavy_top", QUATERNION_DOP853, COMPILED, 20, 1e-12, 1e-11),  # 1.7e-13
    ("heavy_top", RIGID_DOP853, SLOW, 20, 2e-10, 2e-9),  # 2.5e-11
    ("pendulum_3d", QUATERNION_DOP853, COMPILED, 20, 1e-13, 1e-12),  # 2.0e-14
    ("pendulum_3d", RIGID_DOP853, SLOW, 20, 2e-11, 2e-10),  # 2.6e-12
    ("double_pendulum", CHAIN_DOP853, CHAINS, 4, 1e-11, 1e-11),  # 1e-12
    ("planar_chain", CHAIN_DOP853, CHAINS, 4, 1e-11, 1e-11),
    ("elastic_pendulum", LAGRANGIAN_DOP853, TIGHT, 5, 2e-13, 2e-13),  # 2e-14
    ("henon_heiles", DOP853, TIGHT, 5, 2e-13, 2e-13),
    ("fermi_pasta_ulam_tsingou", DOP853, TIGHT, 5, 2e-13, 2e-13),
)
GALVI_RUNS = {  # duration, steps per half unit, bounds on the error of q and the range of energy
    "double_pendulum": (4, 40, 1e-11, 2e-13),  # 5e-13
    "planar_chain": (4, 40, 1e-11, 2e-13),
    "elastic_pendulum": (5, 20, 1e-13, 5e-14),  # 3e-15
    "henon_heiles": (5, 20, 1e-13, 5e-14),
    "fermi_pasta_ulam_tsingou": (5, 20, 1e-13, 5e-14),
}
every_planet = pytest.mark.parametrize("case", CASES)


@pytest.mark.parametrize("truth", SIMILAR_PROBLEMS, ids=lambda truth: truth.name)
def test_a_truth_is_kept_for_its_problems_at_its_times_and_no_others(truth):
    assert not any(truth.supports(problem) for problem in SIMILAR_PROBLEMS[truth])
    for problem, horizon in truth.cases.values():
        assert truth.supports(problem)
        for duration, setting in ((horizon, {"samples": 7}), (-1.0, {}), (2 * horizon, {})):
            message = rf"is stored every 0\.5 up to {horizon:g} .* received a sample"
            with pytest.raises(ValueError, match=message):
                truth.run(problem, duration, setting)


@pytest.mark.slow_cases(
    "planar_chain-SciPy DOP853, chains", "fermi_pasta_ulam_tsingou-SciPy DOP853"
)
@pytest.mark.parametrize(
    ("case", "peer", "setting", "duration", "q_bound", "p_bound"),
    PEERS,
    ids=[f"{case}-{peer.name}" for case, peer, *_ in PEERS],
)
def test_other_methods_come_to_it(case, peer, setting, duration, q_bound, p_bound):
    truth, samples = TRUTH_OF_CASE[case], {"samples": 2 * duration}
    problem, _ = truth.cases[case]
    stored_run = truth.run(problem, float(duration), samples)
    run = peer.run(problem, float(duration), samples | setting)
    assert run.success and np.max(np.abs(run.q - stored_run.q)) < q_bound
    assert np.max(np.abs(run.p - stored_run.p)) < p_bound


@pytest.mark.slow_cases("planar_chain", "fermi_pasta_ulam_tsingou")
@pytest.mark.parametrize("case", GALVI_RUNS)
def test_galvi_comes_to_it_and_it_keeps_its_energy(case):
    duration, substeps, q_bound, energy_bound = GALVI_RUNS[case]
    problem, _ = TRUTH_OF_CASE[case].cases[case]
    stored_run = TRUTH_OF_CASE[case].run(problem, float(duration), {"samples": 2 * duration})
    run = galvi.integrate(problem, EIGHT, 0.5 / substeps, 2 * duration * substeps)
    assert np.abs(run.q[::substeps] - stored_run.q).max() < q_bound
    assert np.ptp(galvi.energy(stored_run)) < energy_bound  # 1e-14: the states are rounded


@pytest.mark.slow_cases("double_pendulum", "planar_chain")
@pytest.mark.parametrize("case", TRUTH_OF_CASE)
def test_it_can_be_made_again(case):
    truth = TRUTH_OF_CASE[case]
    if truth.engine.missing:
        pytest.skip(truth.engine.missing)
    stored_lines = (FOLDER / f"{case}.csv").read_text("ascii").splitlines()
    lines = truth.table(case).splitlines()
    rows = [i for i, line in enumerate(stored_lines) if not line.startswith("# source")]
    assert [lines[i] for i in rows] == [stored_lines[i] for i in rows]


def test_it_conserves_energy_and_vertical_momentum_and_is_a_rotation():
    run = STORED_ATTITUDE.run(PENDULUM, 20.0, {"samples": 40})
    energy = galvi.energy(run)
    assert np.max(np.abs(energy / energy[0] - 1.0)) < 2e-15  # 7e-16: the states are rounded
    assert np.max(galvi.orthogonality_defect(run)) < 1e-15
    vertical = np.einsum("ti,ti->t", run.q[:, 2], run.p)
    assert np.max(np.abs(vertical - vertical[0])) < 2e-15


@every_planet
def test_a_motion_of_planets_is_kept_for_its_problem_and_no_other(case):
    problem, _ = CASES[case]
    assert STORED_TRUTH.supports(problem) and stored(case).of(problem)
    assert sum(stored(name).of(problem) for name in CASES) == 1
    named = galvi.Problem(problem.system, problem.q0, problem.v0, t0=3.0, name="another")
    assert STORED_TRUTH.supports(named)
    masses, q0, v0 = problem.system.masses, problem.q0, problem.v0
    similar = [
        galvi.Problem(galvi.NBody(np.nextafter(masses, 99.0), problem.system.G), q0, v0),
        galvi.Problem(galvi.NBody(masses, np.nextafter(problem.system.G, 0.0)), q0, v0),
        galvi.Problem(problem.system, np.nextafter(q0, 99.0), v0),
        galvi.Problem(problem.system, q0, np.nextafter(v0, 99.0)),
    ]
    assert not any(STORED_TRUTH.supports(changed) for changed in similar)
    assert not STORED_TRUTH.supports(galvi.problems.kepler())


@pytest.mark.parametrize("case", ENCOUNTERS)
def test_a_start_made_on_another_processor_is_that_of_the_file(case):
    problem, _ = CASES[case]
    rounded = problem.with_initial_state(problem.q0 * (1.0 + 2.0**-52), problem.v0)
    assert not STORED_TRUTH.supports(rounded) and STORED_TRUTH.supports(
        with_stored_start(case, rounded)
    )
    wrong = problem.with_initial_state(problem.q0 * (1.0 + 1e-12), problem.v0)
    with pytest.raises(ValueError, match="Make the file anew"):
        with_stored_start(case, wrong)


def test_burraus_bodies_are_at_rest_about_their_barycentre():
    problem = burrau()
    masses = problem.system.masses
    assert np.allclose(masses @ problem.q0, 0.0) and not np.any(problem.v0)
    sides = [np.linalg.norm(problem.q0[i] - problem.q0[j]) for i, j in ((1, 2), (0, 2), (0, 1))]
    assert np.allclose(sides, masses)


@every_planet
def test_it_has_ten_samples_at_its_horizon_and_at_a_tenth_of_it(case):
    problem, horizon = CASES[case]
    late = galvi.Problem(problem.system, problem.q0, problem.v0, t0=7.0)
    for duration, samples in ((horizon, 10), (horizon, 5), (horizon / 10, 10), (horizon / 100, 1)):
        run = STORED_TRUTH.run(late, duration, {"samples": samples})
        np.testing.assert_allclose(run.t, 7.0 + duration * np.arange(samples + 1) / samples)
        assert np.array_equal(run.q[0], problem.q0) and np.array_equal(run.p[0], problem.p0)
        energy = galvi.energy(run)
        # 2e-15: the roundings of the states; 4e-13 where bodies meet.
        assert np.abs(energy / energy[0] - 1.0).max() < (1e-12 if case in ENCOUNTERS else 1e-14)
    with pytest.raises(ValueError, match=r"truth is stored at .* received a sample at"):
        STORED_TRUTH.run(problem, horizon / 3, {})
    with pytest.raises(ValueError, match="received a sample at -"):
        STORED_TRUTH.run(problem, -horizon, {})


@every_planet
def test_its_file_has_25_digits_and_says_how_it_was_made(case):
    text = (FOLDER / f"{case}.csv").read_text("ascii")
    assert (
        f"python -m references.stored.planets {case}" in text and "real128, tolerance 1e-28" in text
    )
    rows = [line.split(",") for line in text.splitlines() if line[0].isdigit()]
    assert len(rows) == len(sampled(CASES[case][1])) * CASES[case][0].system.masses.size
    digits = [
        len(decimal.Decimal(x).as_tuple().digits) for row in rows for x in row[2:] if float(x)
    ]
    assert min(digits) == max(digits) == 25
    accuracy = float(text.split("differ by at most ")[1].split()[0])
    assert accuracy < 1e-16  # of the looser of two tolerances; 1.3e-18 au, 6e-17 in Burrau's


@pytest.mark.skipif(bool(IAS15.missing), reason=IAS15.missing or "present")
@every_planet
def test_an_independent_engine_agrees(case):
    problem, horizon = CASES[case]
    setting = {"samples": 10} if case != "solar_system" else {"samples": 1}
    truth = STORED_TRUTH.run(problem, horizon / 10, setting)
    run = IAS15.run(problem, horizon / 10, setting)
    assert np.abs(run.q - truth.q).max() < 1e-10  # 9e-12


@pytest.mark.skipif(bool(HEYOKA_QUADRUPLE.missing), reason=HEYOKA_QUADRUPLE.missing or "present")
@every_planet
def test_its_first_hundredth_can_be_made_again(case):
    problem, horizon = CASES[case]
    times = np.array([0.0, horizon / 100])
    states, _, failure = HEYOKA_QUADRUPLE.states(problem, times, QUADRUPLE)
    assert failure is None
    text = (FOLDER / f"{case}.csv").read_text("ascii").splitlines()
    bodies = problem.system.masses.size
    lines = [line for line in text if line[0].isdigit()][bodies : 2 * bodies]
    stored_values = [decimal.Decimal(x) for line in lines for x in line.split(",")[2:]]
    values = [decimal.Decimal(str(x)) for x in states[1]]
    gaps = [abs(a - b) for a, b in zip(stored_values, values, strict=True)]
    assert max(gaps) < decimal.Decimal("1e-20")  # 1e-22, of which 5e-25 is the file's rounding


def test_a_time_that_was_rounded_moves_the_bodies_along():
    problem, horizon = CASES["outer_solar_system"]
    exact = STORED_TRUTH.run(problem, horizon, {})
    later = np.nextafter(horizon, np.inf)
    run = STORED_TRUTH.run(problem, later, {})
    displacement = exact.p[-1] / problem.system.masses[:, None] * (later - horizon)
    np.testing.assert_allclose(run.q[-1] - exact.q[-1], displacement, rtol=0, atol=8e-15)
    assert run.t[-1] == later


def test_every_file_has_its_engine_command_and_hash() -> None:
    sources = {source["file"]: source for source in provenance.truths()}
    assert set(sources) == {path.name for path in FOLDER.iterdir()}
    for name, source in sources.items():
        assert list(source) == list(provenance.HEADINGS)
        assert source["engine"].startswith("heyoka ") and "real128" in source["engine"]
        assert source["SHA-256"] == hashlib.sha256((FOLDER / name).read_bytes()).hexdigest()
        module, case = source["made by"].removeprefix("python -m ").split()[:2]
        assert f"{case}.csv" == name and importlib.util.find_spec(module) is not None


BODIES = (
    *("Sun", "Mercury", "Venus", "Earth", "Mars"),
    *("Jupiter", "Saturn", "Uranus", "Neptune", "Pluto"),
)
DATA = resources.files("galvi") / "problems" / "data" / "solar_system.csv"


def test_the_stored_file_is_what_its_command_writes():
    if jpl.missing():
        pytest.skip(jpl.missing())
    stored_lines = DATA.read_text("ascii").splitlines()
    lines = jpl.table(jpl.ephemeris()).splitlines()
    assert len(stored_lines) == len(lines)
    for old, new in zip(stored_lines, lines, strict=True):
        if "," not in old or old.startswith(("#", "body")):
            assert old == new
            continue
        assert old.split(",")[0] == new.split(",")[0]
        numbers = [np.array([float(x) for x in line.split(",")[1:]]) for line in (old, new)]
        np.testing.assert_allclose(*numbers, rtol=1e-14)  # sums may be ordered otherwise elsewhere


def test_the_problem_holds_the_file_to_the_last_digit():
    problem = galvi.problems.solar_system()
    rows = np.genfromtxt(DATA.read_text("ascii").splitlines()[6:], delimiter=",", skip_header=1)
    assert np.array_equal(problem.system.masses, rows[:, 1])
    assert np.array_equal(problem.q0, rows[:, 2:5]) and np.array_equal(problem.v0, rows[:, 5:])
    assert problem.parameters["bodies"] == BODIES
    assert problem.system.G == 1.0 and "au^3/day^2" in problem.units
    fewer = galvi.problems.solar_system(pluto=False)
    assert fewer.q0.shape == (9, 3) and fewer.parameters["bodies"] == BODIES[:-1]


def test_the_planets_are_where_almanacs_have_them():
    problem = galvi.problems.solar_system()
    masses, q, v = problem.system.masses, problem.q0, problem.v0
    distance = np.linalg.norm(q[1:] - q[0], axis=1)
    distances = [0.466, 0.720, 0.983, 1.391, 4.965, 9.184, 19.924, 30.121, 30.223]  # au, 2000-01-01
    np.testing.assert_allclose(distance, distances, atol=1e-3)
    semi_axis = 1.0 / (
        2.0 / distance - np.sum((v[1:] - v[0]) ** 2, axis=1) / (masses[0] + masses[1:])
    )
    mean = [0.3871, 0.7233, 1.0000, 1.5237, 5.203, 9.54, 19.19, 30.07, 39.5]  # Standish, J2000
    np.testing.assert_allclose(semi_axis, mean, rtol=0.01)
    mass_ratios = masses[0] / masses[1:]  # IAU 1976-2009
    expected = [6.0236e6, 408523.7, 328900.56, 3098708, 1047.3486, 3497.9, 22903, 19412.2, 1.36e8]
    np.testing.assert_allclose(mass_ratios, expected, rtol=2e-3)
    gauss = 0.01720209895**2
    np.testing.assert_allclose(masses[0], gauss, rtol=1e-9)


def test_the_barycentre_is_at_rest_at_the_origin_but_for_what_is_left_out():
    problem = galvi.problems.solar_system()
    total = np.sum(problem.system.masses)
    centre = problem.system.masses @ problem.q0 / total
    drift = np.sum(problem.p0, axis=0) / total
    assert np.linalg.norm(centre) < 1e-8  # au; 2e-9: asteroids and relativity
    assert np.linalg.norm(drift) < 1e-10  # au / day; 7e-12


SOLAR = galvi.problems.solar_system()
needs_jpl = pytest.mark.skipif(bool(jpl.missing()), reason=jpl.missing() or "present")


@needs_jpl
def test_it_starts_where_the_problem_does_and_moves_as_its_velocity_says():
    run = JPL_EPHEMERIS.run(SOLAR, 0.25, {"samples": 2})
    assert np.array_equal(run.q[0], SOLAR.q0)
    v = run.p / SOLAR.system.masses[:, None]
    np.testing.assert_allclose((run.q[2] - run.q[0]) / 0.25, v[1], atol=2e-7)
    assert "DE421" in run.method and "jplephem" in run.method and not JPL_EPHEMERIS.exact


@needs_jpl
def test_newtons_point_masses_miss_what_relativity_and_the_moon_do():
    gaps = differences(STORED_TRUTH.run(SOLAR, 10_000.0, {}))[-1]
    sun, mercury, earth = gaps[0], gaps[1], gaps[3]
    assert 1e-8 < sun < 1e-6  # 7.0e-8
    assert 1e-5 < mercury < 5e-5  # 2.5e-5: relativity moves its perihelion 43" a century
    assert 5e-6 < earth < 2e-5  # 1.1e-5
    assert np.all(gaps[7:] < 1e-7)  # 4e-8 and less
    early = differences(STORED_TRUTH.run(SOLAR, 100.0, {}))[-1]
    assert np.all(early < gaps)


@needs_jpl
def test_times_outside_the_ephemeris_are_refused():
    for duration in (1e5, -1e5):
        with pytest.raises(ValueError, match=r"DE421 covers -36552 to 73080 days.*received"):
            JPL_EPHEMERIS.run(SOLAR, duration, {})


def test_it_knows_its_own_start_only():
    assert JPL_EPHEMERIS.supports(SOLAR)
    assert JPL_EPHEMERIS.supports(galvi.problems.solar_system(pluto=False))
    assert not JPL_EPHEMERIS.supports(galvi.problems.outer_solar_system())
    assert not JPL_EPHEMERIS.supports(galvi.problems.kepler())
    nudged = galvi.Problem(SOLAR.system, np.nextafter(SOLAR.q0, 99.0), SOLAR.v0)
    assert not JPL_EPHEMERIS.supports(nudged)
    run = galvi.Trajectory(nudged, np.zeros(1), nudged.q0[None], nudged.p0[None])
    with pytest.raises((ValueError, ModuleNotFoundError), match="JPL DE421"):
        differences(run)
