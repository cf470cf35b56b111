"""The stored truths of the planets: whose they are, what they hold, and that they can be remade."""

import decimal

import numpy as np
import pytest

import galvi
from references.heyoka.engine import QUADRUPLE
from references.heyoka.taylor import HEYOKA_QUADRUPLE
from references.rebound.ias15 import IAS15
from references.stored.encounters import ENCOUNTERS, burrau
from references.stored.planets import CASES, FOLDER, STORED_TRUTH, as_kept, sampled, stored

every = pytest.mark.parametrize("case", CASES)


@every
def test_it_is_kept_for_its_problem_and_no_other(case):
    problem, _ = CASES[case]
    assert STORED_TRUTH.supports(problem) and stored(case).of(problem)
    assert sum(stored(other).of(problem) for other in CASES) == 1
    named = galvi.Problem(problem.system, problem.q0, problem.v0, t0=3.0, name="another")
    assert STORED_TRUTH.supports(named)
    masses, q0, v0 = problem.system.masses, problem.q0, problem.v0
    near = [
        galvi.Problem(galvi.NBody(np.nextafter(masses, 99.0), problem.system.G), q0, v0),
        galvi.Problem(galvi.NBody(masses, np.nextafter(problem.system.G, 0.0)), q0, v0),
        galvi.Problem(problem.system, np.nextafter(q0, 99.0), v0),
        galvi.Problem(problem.system, q0, np.nextafter(v0, 99.0)),
    ]
    assert not any(STORED_TRUTH.supports(other) for other in near)
    assert not STORED_TRUTH.supports(galvi.problems.kepler())


@pytest.mark.parametrize("case", ENCOUNTERS)
def test_a_start_made_on_another_processor_is_that_of_the_file(case):
    problem, _ = CASES[case]
    other = problem.with_initial_state(problem.q0 * (1.0 + 2.0**-52), problem.v0)
    assert not STORED_TRUTH.supports(other) and STORED_TRUTH.supports(as_kept(case, other))
    wrong = problem.with_initial_state(problem.q0 * (1.0 + 1e-12), problem.v0)
    with pytest.raises(ValueError, match="Make the file anew"):
        as_kept(case, wrong)


def test_burraus_bodies_are_at_rest_about_their_barycentre():
    problem = burrau()
    masses = problem.system.masses
    assert np.allclose(masses @ problem.q0, 0.0) and not np.any(problem.v0)
    sides = [np.linalg.norm(problem.q0[i] - problem.q0[j]) for i, j in ((1, 2), (0, 2), (0, 1))]
    assert np.allclose(sides, masses)


@every
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
    with pytest.raises(ValueError, match=r"stored truth is kept .* received a sample at"):
        STORED_TRUTH.run(problem, horizon / 3, {})
    with pytest.raises(ValueError, match="received a sample at -"):
        STORED_TRUTH.run(problem, -horizon, {})


@every
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
@every
def test_an_independent_engine_agrees(case):
    problem, horizon = CASES[case]
    setting = {"samples": 10} if case != "solar_system" else {"samples": 1}
    truth = STORED_TRUTH.run(problem, horizon / 10, setting)
    run = IAS15.run(problem, horizon / 10, setting)
    assert np.abs(run.q - truth.q).max() < 1e-10  # 9e-12


@pytest.mark.skipif(bool(HEYOKA_QUADRUPLE.missing), reason=HEYOKA_QUADRUPLE.missing or "present")
@every
def test_its_first_hundredth_can_be_made_again(case):
    problem, horizon = CASES[case]
    times = np.array([0.0, horizon / 100])
    states, _, failure = HEYOKA_QUADRUPLE.states(problem, times, QUADRUPLE)
    assert failure is None
    text = (FOLDER / f"{case}.csv").read_text("ascii").splitlines()
    bodies = problem.system.masses.size
    lines = [line for line in text if line[0].isdigit()][bodies : 2 * bodies]
    kept = [decimal.Decimal(x) for line in lines for x in line.split(",")[2:]]
    made = [decimal.Decimal(str(x)) for x in states[1]]
    apart = [abs(a - b) for a, b in zip(kept, made, strict=True)]
    assert max(apart) < decimal.Decimal("1e-20")  # 1e-22, of which 5e-25 is the file's rounding


def test_a_time_that_was_rounded_moves_the_bodies_along():
    problem, horizon = CASES["outer_solar_system"]
    exact = STORED_TRUTH.run(problem, horizon, {})
    later = np.nextafter(horizon, np.inf)
    run = STORED_TRUTH.run(problem, later, {})
    moved = exact.p[-1] / problem.system.masses[:, None] * (later - horizon)
    np.testing.assert_allclose(run.q[-1] - exact.q[-1], moved, rtol=0, atol=8e-15)
    assert run.t[-1] == later
