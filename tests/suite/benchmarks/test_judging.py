"""Judging simulations of point masses: the judged run is the engine's on the user's own model, the
sentences on it are true, and the recommended setting was tried and reaches the error."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from benchmarks.applications.judging import bodies, clock, neighbours
from benchmarks.applications.judging.candidate import Candidate, Kind, Model, Source, UserSetting
from benchmarks.applications.judging.judgement import OWN_SUFFIX, Judgement, judge, own_setting
from benchmarks.applications.judging.scan import Limits, ScanRow, Search, explained, scan
from benchmarks.applications.judging.truth import agreements, in_pieces
from galvi import Problem, Trajectory
from galvi.interop.rebound import read
from references.closed_forms.kepler import KEPLER
from references.rebound.ias15 import IAS15
from references.rebound.leapfrog import LEAPFROG
from references.stored.encounters import burrau
from reports.judge.files import page_html
from reports.judge.sentences import sentences

rebound = pytest.importorskip("rebound")
YEAR = 2.0 * math.pi


def simulation(*particles: dict[str, Any], **settings: Any) -> Any:
    """A REBOUND simulation with these particles and attributes."""
    sim = rebound.Simulation()
    for particle in particles:
        sim.add(**particle)
    for name, value in settings.items():
        setattr(sim, name, value)
    return sim


STAR = {"m": 1.0}


def planet(eccentricity: float = 0.2, **overrides) -> Problem:
    """A star and a massless planet, whose motion has a closed form."""
    pericentre, speed = 1.0 - eccentricity, math.sqrt((1.0 + eccentricity) / (1.0 - eccentricity))
    q, v = np.zeros((2, 3)), np.zeros((2, 3))
    q[1, 0], v[1, 1] = pericentre, speed
    parameters = {"integrator": "leapfrog", "dt": YEAR / 200, **overrides}
    return Problem(galvi.NBody([1.0, 0.0]), q, v, name="planet", parameters=parameters)


def planets(**overrides) -> Problem:
    """Jupiter and Saturn around the Sun and the inner planets."""
    outer = galvi.problems.outer_solar_system()
    system = galvi.NBody(outer.system.masses[:3])
    parameters = {
        "integrator": "whfast",
        "dt": 200.0,
        "bodies": ("Sun", "Jupiter", "Saturn"),
        **overrides,
    }
    return Problem(system, outer.q0[:3], outer.v0[:3], parameters=parameters)


def sources(problem: Problem, span: float) -> list[Source]:
    return bodies.sources(Model(problem), span, UserSetting("", KEPLER, {}, None))


def star_last() -> Any:
    """Two planets that were added before their star."""
    sim = simulation(
        {"m": 1e-3, "x": 1.0, "vy": 1.0},
        {"m": 5e-4, "x": -0.7, "y": 1.6, "vx": -0.69, "vy": -0.30},
        STAR,
        integrator="whfast",
        dt=0.05,
    )
    sim.move_to_com()
    return sim


def judged(
    sim: Any, duration: float, error: float | None = None, **integrator_settings: Any
) -> Judgement:
    problem, engine_sim = read(sim, -1)
    return judge(Model(problem, engine_sim), duration, error, integrator_settings, quick=True)


def error_by_rebound(sim: Any, steps: int) -> float:
    """Largest distance of a particle from IAS15's after `steps` steps, by REBOUND alone."""
    users_sim, truth = sim.copy(), sim.copy()
    truth.integrator, truth.gravity = "ias15", "basic"
    users_sim.steps(steps)
    users_sim.synchronize()
    truth.integrate(steps * sim.dt + sim.t)
    positions = ([particle.xyz for particle in copy.particles] for copy in (users_sim, truth))
    return float(np.linalg.norm(np.subtract(*positions), axis=1).max())


@pytest.mark.slow(beside="test_an_own_run_is_the_engines_to_the_last_bit")
def test_particles_keep_their_order_and_a_ruined_run_is_not_called_good(monkeypatch) -> None:
    sim = star_last()
    judgement = judged(sim, 100.0, 1e-3)
    assert judgement.own_errors["error"].iloc[-1] == pytest.approx(
        error_by_rebound(sim, 2000), rel=1e-6
    )
    assert judgement.own["error"] > 100.0 and not judgement.passed
    expected = "2, is particle 2, but REBOUND WHFast expects it first"
    assert any(expected in note for note in judgement.notes)
    assert judgement.recommended is not None  # candidates have the star first
    # Planted: the run of a simulation that was built from the problem, the heaviest first.
    monkeypatch.setattr(bodies, "own_contender", lambda model, name: bodies.INTEGRATORS[name])
    planted = judged(sim, 10.0).own_errors["error"].iloc[-1]
    assert planted != pytest.approx(error_by_rebound(sim, 200), rel=1e-2)


@pytest.mark.slow_cases(but=["janus"])
@pytest.mark.parametrize("integrator", ["whfast", "saba", "janus"])
def test_another_own_integrator_than_that_of_the_simulation(integrator: str) -> None:
    """WHFast leaves to BS the setting that its Kepler motion has the star's pull."""
    sim = star_last()
    sim.integrator = integrator
    judgement = judged(sim, 5.0, 1e-6, integrator="bs")
    assert judgement.own["status"].startswith("Completed.") and judgement.passed


def own_run(sim: Any, steps: int, save_every: int) -> Trajectory:
    problem, engine_sim = read(sim, -1)
    setting = own_setting(bodies, Model(problem, engine_sim), {})
    assert setting.step is not None
    return setting.contender.run(
        problem,
        steps * setting.step,
        {**setting.options, "step": setting.step, "save_every": save_every},
    )


@settings(max_examples=25, deadline=None)
@given(
    st.permutations(range(4)),
    st.sampled_from(["whfast", "saba", "leapfrog", "eos", "janus", "mercurius", "trace"]),
    st.sampled_from([-0.1, 0.05, 0.1]),
    st.integers(0, 3),
    st.booleans(),
)
def test_an_own_run_is_the_engines_to_the_last_bit(
    order: list[int], integrator: str, dt: float, steps_before: int, massless: bool
) -> None:
    """For any order of the particles, either direction of time, and after earlier steps."""
    sim = rebound.Simulation()
    in_order = rebound.Simulation()
    in_order.add(m=1.0)
    for m, a, e, f in ((1e-3, 1.0, 0.1, 0.3), (3e-4, 1.8, 0.05, 2.0), (1e-5, 3.1, 0.2, 4.0)):
        in_order.add(m=m, a=a, e=e, f=f)
    chosen = [*[k for k in order if k < 3], 3] if massless else order
    for k in chosen:
        sim.add(in_order.particles[k])
    if massless:
        sim.N_active = 3
    sim.integrator, sim.dt = integrator, dt
    if integrator == "whfast":
        sim.integrator.safe_mode, sim.integrator.corrector = 0, 11
    sim.steps(steps_before)
    by_hand = sim.copy()
    run = own_run(sim, 12, 4)
    for row in range(1, 4):
        by_hand.steps(4)
        by_hand.synchronize()
        assert np.array_equal(run.q[row], [p.xyz for p in by_hand.particles])
    assert run.t[-1] == pytest.approx(sim.t + 12 * dt)


def backwards() -> Any:
    sim = simulation(
        STAR, {"m": 1e-3, "a": 5.2, "e": 0.05}, {"m": 0.0, "a": 3.46, "e": 0.64, "f": 2.0}, dt=-0.01
    )
    sim.move_to_com()
    return sim


@pytest.mark.slow_cases("ias15")
@pytest.mark.parametrize("integrator", ["ias15", "whfast"])
def test_a_run_backwards_is_judged_backwards(integrator: str) -> None:
    sim = backwards()
    sim.integrator, sim.dt = integrator, -0.01
    judgement = judged(sim, 20.0, 1e-6)
    assert judgement.duration == pytest.approx(-20.0)
    assert judgement.own_errors["t"].iloc[-1] == pytest.approx(-20.0)
    assert "backwards" in sentences(judgement)[0]
    assert all(agreement.t[-1] < 0.0 for agreement in judgement.agreements)
    assert judgement.recommended is not None and judgement.recommended["error"] <= 1e-6


@pytest.mark.slow(beside="test_a_run_backwards_is_judged_backwards")
def test_encounters_of_the_past_are_those_of_the_past() -> None:
    sim = backwards()
    past = judged(sim, 440.0, 1e-6).encounters
    gaps = []
    for t in np.linspace(0.0, -440.0, 44_001):
        sim.integrate(t)
        gaps.append(float(np.linalg.norm(np.subtract(sim.particles[2].xyz, sim.particles[1].xyz))))
    k = int(np.argmin(gaps))
    assert (past["time"] < 0.0).all()
    assert past["time"].iloc[0] == pytest.approx(-0.01 * k, abs=0.05)
    assert past["distance"].iloc[0] == pytest.approx(gaps[k], rel=0.05)


@pytest.mark.slow(
    beside="tests/properties/test_reading_rebound.py::test_a_tree_is_read_as_point_masses_and_says_so"
)
def test_a_tree_of_gravity_is_that_of_the_own_run_only() -> None:
    generator = np.random.default_rng(3)
    sim = simulation(
        STAR,
        *({"m": 1e-3, "a": a, "f": generator.uniform(0, 6.28)} for a in np.linspace(1.0, 4.0, 30)),
        root_size=40.0,
        gravity="tree",
        integrator="leapfrog",
        dt=0.01,
    )
    judgement = judged(sim, 5.0)
    assert any(
        "tree" in note for note in (*judgement.notes, str(judgement.problem.parameters["read_as"]))
    )
    direct = sim.copy()
    direct.gravity = "basic"
    assert judgement.own["error"] != pytest.approx(judged(direct, 5.0).own["error"], rel=0.1)
    assert judgement.own_errors["error"].iloc[-1] == pytest.approx(
        error_by_rebound(sim, 500), rel=1e-6
    )


def kepler_16() -> Any:
    sim = simulation(
        {"m": 0.69, "name": "A"},
        {"m": 0.2, "a": 0.224, "e": 0.16, "name": "B"},
        {"m": 3e-4, "a": 0.705, "name": "b"},
        integrator="whfast",
        dt=0.02,
        t=2455212.12316,
    )
    sim.move_to_com()
    return sim


@pytest.mark.slow(beside="test_moons_are_no_encounters_and_set_the_pace")
def test_a_companion_star_has_no_encounters_and_dates_keep_their_digits() -> None:
    judgement = judged(kepler_16(), 60.0, 1e-12)
    assert len(judgement.encounters) == 0
    assert not any("encounter" in sentence for sentence in sentences(judgement))
    problem, engine_sim = read(kepler_16(), -1)
    full_judgement = judge(Model(problem, engine_sim), 60.0, 1e-8)
    for sentence in sentences(full_judgement):
        assert "e+06" not in sentence
    assert any("24552" in sentence for sentence in sentences(full_judgement))


@pytest.mark.slow(beside="test_a_source_of_truth_that_is_wrong_is_seen")
def test_what_does_not_agree_is_not_said_to() -> None:
    """galvi's opinion, of eight steps a revolution, is off by hundreds at e = 0.99."""
    judgement = judged(simulation(STAR, {"m": 3e-6, "e": 0.99, "a": 1.0}), 60.0, 1e-6)
    opinion = next(agreement for agreement in judgement.agreements if agreement.source.is_galvi)
    truth = truth_sentence(judgement)
    claim, agreed = truth.split("It agrees with ", 1)
    assert opinion.largest > 1.0 and agreed.startswith("REBOUND") and "galvi" not in agreed
    assert claim.endswith("runs of galvi are never the truth. ")
    stopped = next(
        agreement for agreement in judgement.agreements if agreement.source.engine == "SciPy"
    )
    assert not stopped.stopped or "up to t = " in truth
    disagreeing = replace(
        judgement.agreements[0], distances=np.full_like(judgement.agreements[0].distances, 8.5e-4)
    )
    parted = replace(judgement, agreements=(disagreeing,), error=1e-6)
    assert "REBOUND IAS15 differs from it by up to 8.50·10⁻⁴" in truth_sentence(
        parted
    ) and "Smaller errors cannot be measured" in truth_sentence(parted)
    assert not any("Nothing that was tried" in sentence for sentence in sentences(parted))


def truth_sentence(judgement: Judgement) -> str:
    return next(
        sentence for sentence in sentences(judgement) if sentence.startswith("The truth is")
    )


@pytest.mark.parametrize(
    ("options", "label_words"),
    [
        (
            {"coordinates": "democraticheliocentric", "corrector": 0},
            ("coordinates democraticheliocentric", "dt = 0.05"),
        ),
        (
            {"coordinates": "jacobi", "corrector": 17, "kernel": "LAZY"},
            ("corrector 17", "kernel lazy"),
        ),
    ],
)
def test_labels_name_what_is_not_usual(
    options: dict[str, Any], label_words: tuple[str, ...]
) -> None:
    sim = star_last()
    for name, value in options.items():
        setattr(sim.integrator, name, value)
    label = own_setting(bodies, Model(*read(sim, -1)), {}).label.lower()
    assert all(word in label for word in label_words)


@pytest.mark.slow(beside="test_a_run_backwards_is_judged_backwards")
def test_a_distance_at_which_the_users_run_ends_is_named() -> None:
    sim = simulation(
        STAR,
        {"m": 1e-3, "a": 1.0},
        {"m": 0.0, "x": 10.0, "vx": 2.0},
        N_active=2,
        integrator="whfast",
        dt=0.05,
        exit_max_distance=50.0,
    )
    (note,) = [text for text in judged(sim, 40.0, 1e-3).notes if "exit_max_distance" in text]
    assert "exit_max_distance = 50 is ignored here: your own run ends there at about t = 2" in note
    sim.exit_max_distance = 1e3
    assert any("never reaches it" in note for note in judged(sim, 40.0, 1e-3).notes)


@pytest.mark.slow(beside="test_another_own_integrator_than_that_of_the_simulation")
def test_where_a_truth_takes_long_something_is_said_first(monkeypatch: pytest.MonkeyPatch) -> None:
    problem, engine_sim = read(star_last(), -1)
    messages: list[str] = []
    judge(Model(problem, engine_sim), 100.0, 1e-3, report=messages.append, quick=True)
    assert not any("First answer" in message for message in messages)
    monkeypatch.setattr("benchmarks.applications.judging.judgement.EARLY_SECONDS", 0.0)
    messages.clear()
    judge(Model(problem, engine_sim), 100.0, 1e-3, report=messages.append, quick=True)
    first = next(
        k
        for k, message in enumerate(messages)
        if message.startswith("First answer: after 2 of 100 ")
    )
    assert first < next(k for k, message in enumerate(messages) if message.startswith("truth: "))


@pytest.mark.slow(beside="test_another_own_integrator_than_that_of_the_simulation")
def test_the_own_error_is_that_against_the_closed_form():
    judgement = judge(planet(), duration=10 * YEAR, error=1e-3)
    assert judgement.duration == pytest.approx(10 * YEAR)  # a whole number of its steps
    assert len(judgement.own_errors) == 2001  # each of its steps
    exact = KEPLER.run(planet(), judgement.duration, {"samples": 2000})
    leapfrog_run = bodies.INTEGRATORS["leapfrog"].run(
        planet(), judgement.duration, {"step": YEAR / 200}
    )
    leapfrog_error = np.linalg.norm(leapfrog_run.q - exact.q, axis=-1).max()
    assert judgement.own["error"] == pytest.approx(leapfrog_error, rel=1e-9)
    assert (
        not judgement.passed
        and judgement.truth_agreement < 1e-10
        and math.isinf(judgement.trusted_until)
    )
    assert judgement.parts["largest_error"].iloc[1] == judgement.own["error"]
    # A leapfrog is ahead of or behind its planet by what its error is along the orbit.
    assert 0.5 < abs(judgement.parts["phase_error"].iloc[1]) / leapfrog_error < 2.0


@pytest.mark.slow(beside="test_coarser_steps_are_tried_while_they_reach_the_error")
def test_a_truth_is_trusted_at_whole_revolutions_and_no_error_is_the_own_one():
    # At whole revolutions each state is nearly the first one.
    ias15_judgement = judge(planet(integrator="ias15"), duration=100 * YEAR, quick=True)
    assert math.isinf(ias15_judgement.trusted_until) and bodies.size(
        ias15_judgement.truth
    ) == pytest.approx(0.8)
    without_error = judge(planets(), duration=40_000.0)
    assert without_error.error == without_error.own["error"] and without_error.passed


def test_a_run_that_chooses_its_steps_is_also_taken_to_its_end_without_stops():
    """A moonlet far from the Sun: IAS15's own steps are too long for it, those that end at the
    times of comparison are not. 2.36 km are known from steps of 1/40 of its revolution."""
    sim = rebound.Simulation()
    sim.units = ("AU", "days", "Msun")
    sim.add(m=1.0)
    sim.add(m=3.003e-6, a=1.0)
    sim.add(m=2.7e-19, a=1.3, e=0.3, f=1.0, inc=0.05)
    sim.add(m=2.2e-21, a=1.19 / 149597870.7, e=0.03, primary=sim.particles[2])
    judgement = judge(Model(galvi.from_rebound(sim), sim), 20.0, 1e-10, quick=True)
    assert judgement.own["last_error"] < 1e-12 and not judgement.passed
    assert (
        judgement.own["unstopped_error"]
        == judgement.own["error"]
        == pytest.approx(1.58e-8, rel=0.1)
    )
    assert "without stops at these times" in sentences(judgement)[1]
    assert not math.isnan(judgement.table["error"].iloc[0]) and judgement.table["reached"].iloc[0]


def test_a_source_of_truth_that_is_wrong_is_seen():
    """Planted: a loose tolerance for the second source."""
    problem, span = planets(), 40_000.0
    truth = IAS15.run(problem, span, {"samples": 40})
    loose = Source("loose", "REBOUND", IAS15, {"adaptive_mode": "GLOBAL", "epsilon": 1e-1})
    reliable = sources(problem, span)[1]
    silent = lambda sentence: None  # noqa: E731
    bad, good = (
        agreements(truth, [source], bodies.errors, 10, silent)[0] for source in (loose, reliable)
    )
    assert good.largest < 1e-10 < 1e-9 < bad.largest
    assert good.t[0] == problem.t0 and good.t[-1] == span
    run, stopped = in_pieces(reliable, problem, np.linspace(0.0, span, 11)[1:])
    assert not stopped
    assert np.array_equal(run.q[0], problem.q0) and len(run.t) == 11


def test_encounters_are_found_and_timed():
    """Two planets on the same circle in opposite directions meet twice in a period."""
    q = np.array([[0, 0, 0], [1, 0, 0], [-1.005, 0, 0], [0, 3, 0]], dtype=float)
    v = np.array([[0, 0, 0], [0, 1, 0], [0, 1.005**-0.5, 0], [-(3**-0.5), 0, 0]], dtype=float)
    meeting = galvi.NBody([1.0, 1e-6, 1e-6, 0.0])
    problem = Problem(meeting, q, v, parameters={"integrator": "ias15"})
    judgement = judge(problem, duration=YEAR)
    encounters = judgement.encounters
    assert len(encounters) == 2 and set(encounters["bodies"]) == {"1 and 2"}
    assert np.allclose(np.sort(encounters["time"]), [0.25 * YEAR, 0.75 * YEAR], atol=0.02)
    assert np.all(encounters["hill_radii"] < bodies.ENCOUNTER_HILL_RADII)
    text = " ".join(sentences(judgement))
    for word in (
        "There are 2 close encounters",
        "IAS15",
        "TRACE",
        "fixed step",
        "are not: one that",
    ):
        assert word in text
    assert "misses" not in text and "outputs" not in encounters
    assert "encounter" not in " ".join(sentences(judge(planet(), duration=YEAR, quick=True)))


@pytest.mark.slow(beside="test_moons_are_no_encounters_and_set_the_pace")
def test_encounters_between_two_outputs_of_an_archive_are_counted():
    """The planets of the test above are near each other for 0.02 of a year at 0.25 and 0.75."""
    q = np.array([[0, 0, 0], [1, 0, 0], [-1.005, 0, 0]], dtype=float)
    v = np.array([[0, 0, 0], [0, 1, 0], [0, 1.005**-0.5, 0]], dtype=float)
    masses = galvi.NBody([1.0, 1e-6, 1e-6])
    for output_interval, outputs in (
        (0.25 * YEAR, [1, 1]),
        (0.4 * YEAR, [0, 0]),
        (0.75 * YEAR, [0, 1]),
    ):
        parameters = {"integrator": "ias15", "output_every": output_interval}
        truth = IAS15.run(Problem(masses, q, v, parameters=parameters), YEAR, {"samples": 400})
        encounters = bodies.encounters(truth).sort_values("time")
        assert encounters["outputs"].tolist() == outputs
    text = " ".join(sentences(judge(truth.problem, duration=YEAR, quick=True)))
    assert "misses 1 of 2 encounters: no state of it falls into them" in text


@pytest.mark.slow(beside="test_every_row_has_a_status_and_what_reaches_the_error_a_spread")
def test_a_clock_reaches_an_error_through_close_passages_and_the_cheapest_is_recommended():
    eccentric = planet(0.99, integrator="ias15")
    bound = Problem(
        galvi.NBody([1.0, 1e-3]), eccentric.q0, eccentric.v0, parameters=eccentric.parameters
    )
    judgement = judge(bound, duration=3.3 * YEAR, error=1e-7, quick=True)
    table, best = judgement.table, judgement.recommended
    clocks = table[table["integrator"].str.startswith("galvi clock")]
    assert {"galvi clock, Gauss 8", "galvi clock, Gauss 16"} == set(
        clocks.loc[clocks["reached"], "integrator"]
    )
    assert clocks["setting"].str.startswith("in tau, step").all()
    assert best is not None and best["error"] <= 1e-7
    assert best["seconds"] == table.loc[table["reached"], "seconds"].min()


def test_neighbouring_starts_part_linearly_on_an_orbit_and_faster_in_chaos(monkeypatch):
    problem, span = planet(), 40 * YEAR
    source, truth = sources(problem, span)[0], IAS15.run(problem, span, {"samples": 40})
    grown = neighbours.deviations(bodies, source, truth, 1e-9)
    assert 30.0 < grown[40] / grown[1] < 60.0
    # From starts closer than can be told apart it is in proportion: a millionth from 1e-15.
    ends, later = (
        neighbours.horizons(bodies, source, truth, fraction * grown.max())["until"]
        for fraction in (2e-6, 0.9e-6)
    )
    assert ends.iloc[1] <= 1.01 * YEAR and math.isnan(ends.iloc[-1])
    assert later.iloc[-1] > 30 * YEAR
    # Where the measured runs have parted, no horizon is longer for closer starts.
    monkeypatch.setattr(neighbours, "deviations", lambda *_: np.linspace(0.0, 1.5, 41))
    ends = neighbours.horizons(bodies, source, truth, 1e-2)["until"]
    assert ends.iloc[-1] == ends.iloc[-2] <= 1.01 * YEAR
    monkeypatch.undo()
    wild = IAS15.run(burrau(), 62.0, {"samples": 40})
    chaos = neighbours.deviations(bodies, sources(burrau(), 62.0)[0], wild, 1e-12)
    assert chaos.max() / 1e-12 > 1e4 * grown.max() / 1e-9


@pytest.mark.slow(beside="test_a_source_of_truth_that_is_wrong_is_seen")
def test_a_source_that_stops_does_not_end_the_judgement():
    problem = Problem(burrau().system, burrau().q0, burrau().v0, parameters={"integrator": "ias15"})
    judgement = judge(problem, duration=2.5, error=1e-6)
    assert judgement.passed and judgement.truth_agreement < 1e-6
    assert all(np.all(np.isfinite(agreement.distances)) for agreement in judgement.agreements)
    assert min(agreement.t[-1] for agreement in judgement.agreements) < 2.5 and math.isinf(
        judgement.trusted_until
    )


def test_moons_are_no_encounters_and_set_the_pace():
    q = np.array([[0, 0, 0], [1, 0, 0], [1.0026, 0, 0]], dtype=float)
    v = np.array([[0, 0, 0], [0, 1, 0], [0, 1.0 + (3e-6 / 0.0026) ** 0.5, 0]], dtype=float)
    moon = Problem(galvi.NBody([1.0, 3e-6, 3e-8]), q, v, parameters={"integrator": "ias15"})
    assert bodies.shortest_period(moon) == pytest.approx(
        2 * math.pi * (0.0026**3 / 3e-6) ** 0.5, rel=0.05
    )
    assert len(bodies.encounters(IAS15.run(moon, 3.0, {"samples": 600}))) == 0
    # States much farther apart than a revolution.
    sparse = IAS15.run(planets(), 1e6, {"samples": 50})
    assert len(bodies.encounters(sparse)) == 0


def test_the_options_of_the_own_integrator_are_kept():
    sim = simulation(STAR, {"m": 1e-3, "a": 1.0}, integrator="whfast", dt=0.1)
    sim.integrator.corrector, sim.integrator.safe_mode = 17, 0
    setting = own_setting(bodies, Model(galvi.from_rebound(sim)), {})
    assert (
        setting.step == 0.1
        and setting.options["corrector"] == 17
        and setting.options["safe_mode"] == 0
    )
    leapfrog_setting = own_setting(
        bodies, Model(galvi.from_rebound(sim)), {"integrator": "leapfrog"}
    )
    assert "corrector" not in leapfrog_setting.options


@pytest.mark.parametrize(
    ("model", "options", "message"),
    [
        (planets(), {"own": {"integrator": "wfast"}}, "own integrator must be one of"),
        (planets(), {"own": {"integrator": "saba", "dt": None}}, "saba takes equal steps"),
        (
            Model(*read(simulation(STAR, STAR | {"x": 1.0}, integrator="none"), -1)),
            {},
            r"model's own integrator .* --own integrator=ias15",
        ),
        (galvi.problems.pendulum_3d(), {}, "judge takes a model of point masses"),
        (planets(), {"duration": 0.0}, "duration must not be 0"),
        (planets(), {"duration": -1.0}, r"own dt must be at most the duration 1; received 200"),
        (planets(), {"own": {"dt": 0.0}}, "own dt must not be 0"),
        (planets(), {"error": 0.0}, "error must be"),
    ],
)
def test_what_cannot_be_judged_is_refused_with_what_to_do(model, options, message):
    with pytest.raises(ValueError, match=message):
        judge(model, **options)


SPAN = 4.0 * YEAR
ROOMY = Limits(1.0, 5.0, 10.0, 1.0)


def orbit(**overrides: Any) -> Problem:
    """A star and a massless planet, whose motion has a closed form."""
    q, v = np.zeros((2, 3)), np.zeros((2, 3))
    q[1, 0], v[1, 1] = 1.0, 1.1
    parameters = {"integrator": "leapfrog", "dt": YEAR / 100, **overrides}
    return Problem(galvi.NBody([1.0, 0.0]), q, v, parameters=parameters)


@dataclass(frozen=True, eq=False)
class Slow:
    """REBOUND's leapfrog after `setup` seconds; `labels_run` collects the labels of its runs."""

    setup: float = 0.0
    label: str = ""
    labels_run: list[str] = field(default_factory=list)
    name: str = "slow leapfrog"
    order: int = 2
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        return True

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        time.sleep(self.setup)
        self.labels_run.append(self.label)
        return LEAPFROG.run(problem, duration, setting)


def search(error: float) -> Search:
    truth = KEPLER.run(orbit(), SPAN, {"samples": 100})
    return Search(cast(Kind, bodies), SPAN, truth, error)


def leapfrog(steps: int, contender: Any = LEAPFROG) -> Candidate:
    return Candidate("leapfrog", contender, {}, steps)


@pytest.mark.parametrize("pause", [0.0, 0.04])  # in the third call, as of a busy machine
@pytest.mark.parametrize(("setup", "step"), [(0.06, 1e-6), (0.0, 1e-3), (0.5, 1e-3), (1e-4, 1e-5)])
def test_the_time_of_a_run_is_foreseen_without_its_set_up_in_every_step(
    monkeypatch: pytest.MonkeyPatch, setup: float, step: float, pause: float
) -> None:
    """On a clock that only the calls advance."""
    clock_time, calls = [0.0], [0]
    monkeypatch.setattr(clock.time, "perf_counter", lambda: clock_time[0])

    def run(count: int) -> None:
        calls[0] += 1
        clock_time[0] += setup + count * step + (pause if calls[0] == 3 else 0.0)

    total_steps, enough = 10_000, 1.0
    exact_seconds = setup + total_steps * step
    expected_seconds = clock.expected(run, total_steps, enough)
    assert (
        expected_seconds == pytest.approx(exact_seconds, rel=1e-9)
        or exact_seconds <= expected_seconds <= enough
    )


def test_a_long_set_up_keeps_no_integrator_from_being_tried() -> None:
    """Two steps take 0.03 s, so that 20,000 would take 300 s if all steps were like these."""
    rows = search(1e-4).rows_of([leapfrog(20_000, Slow(0.03))], limit=2.0)
    assert rows[0].reached and rows[0].error < 1e-4


def test_an_integrator_is_tried_with_finer_steps_until_its_time_is_over() -> None:
    """Even where another reaches the error in a microsecond."""
    tight_search = search(1e-5)
    users_row = ScanRow("mine", "dt = 1", error=1e-6, seconds=1e-6)
    table, _ = scan(
        tight_search.kind,
        [[leapfrog(100)]],
        SPAN,
        tight_search.truth,
        1e-5,
        print,
        ROOMY,
        users_row,
    )
    rows = table[table["integrator"] == "leapfrog"]
    assert rows["reached"].any() and len(rows) > 3
    assert table.iloc[0]["integrator"] == "mine"


def test_what_does_not_reach_the_error_says_how_fine_it_was_tried() -> None:
    rows = search(1e-15).rows_of([leapfrog(100)], limit=0.2)
    last = rows[-1]
    assert len(rows) > 2 and not any(row.reached for row in rows)
    prefix = f"not reached with the finest setting tried, {last.setting}, error {last.error:.2g}: "
    assert last.status.startswith(prefix) and len(last.status) > len(prefix)
    assert all(row.status for row in rows)
    best = ScanRow("one", "dt = 2", rows[0].candidate, error=0.1, status="missed")
    worse = replace(best, setting="dt = 1", error=0.2)
    failed = replace(best, setting="dt = 1", error=math.nan, status="It failed.")
    for finest, word in ((worse, "error 0.2"), (failed, "failed")):
        statuses = [row.status for row in explained([best, finest], "why")]
        assert statuses[0] == f"not reached with the finest setting tried, dt = 1, {word}: why"
        assert statuses[1] == ("It failed." if finest is failed else statuses[0])
    steps = [row.candidate.count(100) for row in rows if row.candidate is not None]
    assert steps == sorted(steps)


def test_coarser_steps_are_tried_while_they_reach_the_error() -> None:
    rows = search(1e-2).rows_of([leapfrog(20_000)], limit=5.0)
    assert rows[0].reached and not rows[-1].reached and all(row.reached for row in rows[:-1])
    steps = [row.candidate.count(100) for row in rows if row.candidate is not None]
    assert steps == sorted(steps, reverse=True) and len(steps) > 2


def test_fewer_steps_than_states_are_compared_at_some_of_the_states() -> None:
    coarse = leapfrog(30)
    assert (coarse.states(100), coarse.count(100)) == (25, 50)
    assert leapfrog(100).states(100) == 100 and leapfrog(7).states(100) == 100
    run = coarse.run(orbit(), SPAN, 100)
    assert len(run.t) == 26 and np.allclose(run.t, search(1.0).truth.t[::4])


def test_times_are_taken_in_turns_and_have_a_spread() -> None:
    labels_run: list[str] = []
    pair = [leapfrog(100, Slow(0.0, label, labels_run)) for label in "ab"]
    times = clock.race([*pair, leapfrog(100)], [1e-3, 1e-3, 1e3], orbit(), SPAN, 100, 1.0)
    assert (
        "".join(labels_run).replace("ab", "") == "" and len(labels_run) >= 2 * clock.FEWEST_TIMINGS
    )
    assert times[0].size == times[1].size >= clock.FEWEST_TIMINGS and times[2].size == 0
    middle, low, high = clock.quartiles(np.array([5.0, 1.0, 2.0, 4.0, 3.0]))
    assert (low, middle, high) == (2.0, 3.0, 4.0)


@pytest.fixture(scope="module")
def judgement() -> Judgement:
    return judge(orbit(), duration=SPAN, error=0.5, quick=True)


def test_the_own_run_is_a_row_and_larger_steps_than_its_own_are_tried(judgement: Judgement) -> None:
    own_rows = judgement.table[judgement.table["integrator"] == f"REBOUND leapfrog{OWN_SUFFIX}"]
    steps = own_rows["setting"].str.removeprefix("dt = ").astype(float)
    own_row = own_rows[own_rows["setting"] == judgement.own["setting"]].iloc[0]
    assert steps.max() > 1.5 * YEAR / 100 and own_row["reached"] and judgement.passed
    assert (
        own_row["error"] == judgement.own["error"]
        and own_row["seconds"] == judgement.own["seconds"]
    )
    reached = judgement.table[judgement.table["reached"]]
    best = judgement.recommended
    assert best is not None and best["reached"] and best["error"] <= judgement.error
    assert best["seconds"] == reached["seconds"].min()
    assert (
        judgement.table.loc[~judgement.table["reached"], "error"].dropna() > judgement.error
    ).all()


def test_where_the_own_run_is_the_cheapest_that_is_said(judgement: Judgement) -> None:
    is_own = judgement.table["setting"] == judgement.own["setting"]
    table = judgement.table.assign(
        seconds=np.where(is_own, 1e-9, 1.0), seconds_low=1.0, seconds_high=1.0
    )
    table = table.sort_values(["reached", "seconds"], ascending=[False, True])
    texts = sentences(replace(judgement, table=table))
    assert any("your own run reaches an error of 0.500" in text for text in texts)
    assert not any("The cheapest that reaches" in text for text in texts)
    rivals = judgement.table[~is_own & judgement.table["reached"]].iloc[:2]
    rivals = rivals.assign(seconds=[1.0, 2.0], seconds_low=[0.9, 1.1], seconds_high=[1.2, 2.5])
    slow, alike = ({"seconds": 3.0, "seconds_low": low, "seconds_high": 4.0} for low in (2.9, 1.0))
    for times, phrase in (
        (slow, ", 2.4 to 4.4 times as fast as your run."),
        (alike, "within quartiles no faster than your run."),
    ):
        retimed = replace(judgement, table=rivals, own={**judgement.own, **times})
        (text,) = [
            sentence for sentence in sentences(retimed) if "The cheapest that reaches" in sentence
        ]
        assert phrase in text and "As fast, within quartiles: " in text
    hasty = {**judgement.own, "seconds": 0.5, "seconds_low": 0.4, "seconds_high": 0.6}
    assert not any("your run." in text for text in sentences(replace(retimed, own=hasty))[2:])


def test_every_row_has_a_status_and_what_reaches_the_error_a_spread(judgement: Judgement) -> None:
    assert (judgement.table["status"] != "").all()
    reached = judgement.table[judgement.table["reached"]].dropna(subset="seconds_low")
    assert f"REBOUND leapfrog{OWN_SUFFIX}" in set(reached["integrator"])
    assert (reached["seconds_low"] <= reached["seconds"]).all()
    assert (reached["seconds"] <= reached["seconds_high"]).all()
    assert "(quartiles " in sentences(judgement)[0]


def test_errors_are_given_at_the_end_too_and_with_the_number_of_times(judgement: Judgement) -> None:
    assert judgement.own["last_error"] == judgement.own_errors["error"].iloc[-1]
    phrase = f"at the end (measured at {len(judgement.own_errors) - 1} times, not between them;"
    assert phrase in sentences(judgement)[0]
    measured = judgement.table.dropna(subset="error")
    assert (measured["last_error"] <= measured["error"]).all() and measured[
        "last_error"
    ].notna().all()
    assert f"at the {judgement.samples} times compared" in page_html(judgement, "planet", {})


@pytest.mark.slow(beside="test_errors_are_given_at_the_end_too_and_with_the_number_of_times")
def test_units_that_are_not_set_are_those_of_the_simulation(judgement: Judgement) -> None:
    units_note = "in the units of the simulation, in which G = 1"
    assert any(units_note in note for note in judgement.notes)
    sim = pytest.importorskip("rebound").Simulation()
    sim.add(m=1.0)
    sim.add(a=1.0)
    setting = UserSetting("", LEAPFROG, {}, 0.1)
    model = Model(galvi.from_rebound(sim))
    assert bodies.unit(model.problem, "length") == " units of length"
    assert units_note in bodies.notes(model, setting, judgement.truth)[0]
    assert " units of length over 25.1 units of time" in sentences(judgement)[0]
    page = page_html(judgement, "planet", {})
    assert "in units of length" in page and "dt in units of time" in page
    named = replace(orbit(), units="length au, time yr, mass msun")
    assert bodies.unit(named, "time") == " yr" and bodies.unit(orbit(), "time") == " units of time"
    assert not judge(named, duration=SPAN, error=0.5, quick=True).notes


def trial(steps: int, **fields: Any) -> ScanRow:
    return ScanRow("leapfrog", "", leapfrog(steps), 1e-9, 1e-9, wall=1e-3, **fields)


def test_where_newtons_method_does_steps_more_of_them_are_tried() -> None:
    """More steps may take less time; where no step needs it, the search ends."""
    error_search = search(1e-6)
    hard = trial(100, reached=True, hard=True)
    candidate, _ = error_search._next([hard], [], 10.0)
    assert candidate is not None and candidate.steps == 200
    easy = trial(200, reached=True)
    assert error_search._next([trial(50), hard, easy], [], 10.0) == (None, "")


def test_a_stop_that_no_step_cures_ends_a_search() -> None:
    error_search, rows = search(1e-6), [trial(100, stopped=0.5), trial(200, stopped=0.51)]
    candidate, reason = error_search._next(rows, [], 10.0)
    assert (
        candidate is None and reason == "a force reaches its limit at t = 0.51, whatever the step"
    )
    candidate, _ = error_search._next([*rows, trial(400, stopped=1.0)], [], 10.0)
    assert candidate is not None
