"""Judging a model: what is said of its own run is true, and what is recommended is enough."""

from __future__ import annotations

import math

import numpy as np
import pytest

import galvi
from benchmarks.applications.judging import bodies, neighbours
from benchmarks.applications.judging.candidate import Model, Own, Source
from benchmarks.applications.judging.judgement import judge, own_setting
from benchmarks.applications.judging.truth import agreements, in_pieces
from galvi import Problem
from references.closed_forms.kepler import KEPLER
from references.rebound.ias15 import IAS15
from references.stored.encounters import burrau
from reports.judge.sentences import sentences

pytest.importorskip("rebound")

YEAR = 2.0 * math.pi


def planet(eccentricity: float = 0.2, **own) -> Problem:
    """A star and a massless planet, whose motion is known."""
    gap, speed = 1.0 - eccentricity, math.sqrt((1.0 + eccentricity) / (1.0 - eccentricity))
    q, v = np.zeros((2, 3)), np.zeros((2, 3))
    q[1, 0], v[1, 1] = gap, speed
    parameters = {"integrator": "leapfrog", "dt": YEAR / 200, **own}
    return Problem(galvi.NBody([1.0, 0.0]), q, v, name="planet", parameters=parameters)


def planets(**own) -> Problem:
    """Jupiter and Saturn around the Sun, nearly."""
    outer = galvi.problems.outer_solar_system()
    system = galvi.NBody(outer.system.masses[:3])
    parameters = {
        "integrator": "whfast",
        "dt": 200.0,
        "bodies": ("Sun", "Jupiter", "Saturn"),
        **own,
    }
    return Problem(system, outer.q0[:3], outer.v0[:3], parameters=parameters)


def sources(problem: Problem, span: float) -> list[Source]:
    return bodies.sources(Model(problem), span, Own("", KEPLER, {}, None))


@pytest.mark.slow(
    beside="test_own_runs.py::test_another_own_integrator_than_that_of_the_simulation"
)
def test_the_own_error_is_that_against_the_closed_form():
    found = judge(planet(), duration=10 * YEAR, error=1e-3)
    assert found.duration == pytest.approx(10 * YEAR)  # a whole number of its steps
    assert len(found.own_errors) == 2001  # each of its steps
    exact = KEPLER.run(planet(), found.duration, {"samples": 2000})
    mine = bodies.INTEGRATORS["leapfrog"].run(planet(), found.duration, {"step": YEAR / 200})
    off = np.linalg.norm(mine.q - exact.q, axis=-1).max()
    assert found.own["error"] == pytest.approx(off, rel=1e-9)
    assert not found.passed and found.truth_agreement < 1e-10 and math.isinf(found.trusted_until)
    assert found.parts["largest_error"].iloc[1] == found.own["error"]
    # A leapfrog is ahead of or behind its planet by what its error is along the orbit.
    assert 0.5 < abs(found.parts["phase_error"].iloc[1]) / off < 2.0


@pytest.mark.slow(
    beside="test_judging_scan.py::test_coarser_steps_are_tried_while_they_reach_the_error"
)
def test_what_is_recommended_reaches_the_error_and_nothing_cheaper_that_was_tried_does():
    found = judge(planets(), duration=80_000.0, error=1e-6)
    best = found.recommended
    assert best is not None and best["reached"] and best["error"] <= 1e-6
    reached = found.table[found.table["reached"]]
    assert best["seconds"] == reached["seconds"].min()
    assert (found.table.loc[~found.table["reached"], "error"].dropna() > 1e-6).all()
    tried = {"galvi degree 8, Gauss 8", "REBOUND WHFast, default", "REBOUND IAS15", "REBOUND BS"}
    assert tried <= {*found.table["integrator"]}
    # At whole revolutions, where each state is nearly the first.
    again = judge(planet(integrator="ias15"), duration=100 * YEAR, quick=True)
    assert math.isinf(again.trusted_until) and bodies.size(again.truth) == pytest.approx(0.8)
    alone = judge(planets(), duration=40_000.0)
    assert alone.error == alone.own["error"] and alone.passed


def test_a_run_that_chooses_its_steps_is_also_taken_to_its_end_without_stops():
    """A moonlet far from the Sun: IAS15's own steps are too long for it, those that end at the
    times of comparison are not. 2.36 km are known from steps of 1/40 of its revolution."""
    import rebound

    sim = rebound.Simulation()
    sim.units = ("AU", "days", "Msun")
    sim.add(m=1.0)
    sim.add(m=3.003e-6, a=1.0)
    sim.add(m=2.7e-19, a=1.3, e=0.3, f=1.0, inc=0.05)
    sim.add(m=2.2e-21, a=1.19 / 149597870.7, e=0.03, primary=sim.particles[2])
    found = judge(Model(galvi.from_rebound(sim), sim), 20.0, 1e-10, quick=True)
    assert found.own["last_error"] < 1e-12 and not found.passed
    assert found.own["unstopped_error"] == found.own["error"] == pytest.approx(1.58e-8, rel=0.1)
    assert "without stops at these times" in sentences(found)[1]
    assert not math.isnan(found.table["error"].iloc[0]) and found.table["reached"].iloc[0]


def test_a_source_of_truth_that_is_wrong_is_seen():
    """Planted: a loose tolerance for the second source."""
    problem, span = planets(), 40_000.0
    truth = IAS15.run(problem, span, {"samples": 40})
    loose = Source("loose", "REBOUND", IAS15, {"adaptive_mode": "GLOBAL", "epsilon": 1e-1})
    sound = sources(problem, span)[1]
    silent = lambda sentence: None  # noqa: E731
    bad, good = (agreements(truth, [one], bodies.errors, 10, silent)[0] for one in (loose, sound))
    assert good.largest < 1e-10 < 1e-9 < bad.largest
    assert good.t[0] == problem.t0 and good.t[-1] == span
    whole, stopped = in_pieces(sound, problem, np.linspace(0.0, span, 11)[1:])
    assert not stopped
    assert np.array_equal(whole.q[0], problem.q0) and len(whole.t) == 11


def test_encounters_are_found_and_timed():
    """Two planets on the same circle in opposite directions meet twice in a period."""
    q = np.array([[0, 0, 0], [1, 0, 0], [-1.005, 0, 0], [0, 3, 0]], dtype=float)
    v = np.array([[0, 0, 0], [0, 1, 0], [0, 1.005**-0.5, 0], [-(3**-0.5), 0, 0]], dtype=float)
    meeting = galvi.NBody([1.0, 1e-6, 1e-6, 0.0])
    problem = Problem(meeting, q, v, parameters={"integrator": "ias15"})
    judged = judge(problem, duration=YEAR)
    found = judged.encounters
    assert len(found) == 2 and set(found["bodies"]) == {"1 and 2"}
    assert np.allclose(np.sort(found["time"]), [0.25 * YEAR, 0.75 * YEAR], atol=0.02)
    assert np.all(found["hill_radii"] < bodies.NEAR)
    said = " ".join(sentences(judged))
    for word in (
        "There are 2 close encounters",
        "IAS15",
        "TRACE",
        "fixed step",
        "are not: one that",
    ):
        assert word in said
    assert "misses" not in said and "outputs" not in found
    assert "encounter" not in " ".join(sentences(judge(planet(), duration=YEAR, quick=True)))


@pytest.mark.slow(beside="test_moons_are_no_encounters_and_set_the_pace")
def test_encounters_between_two_outputs_of_an_archive_are_counted():
    """The planets of the test above are near each other for 0.02 of a year at 0.25 and 0.75."""
    q = np.array([[0, 0, 0], [1, 0, 0], [-1.005, 0, 0]], dtype=float)
    v = np.array([[0, 0, 0], [0, 1, 0], [0, 1.005**-0.5, 0]], dtype=float)
    masses = galvi.NBody([1.0, 1e-6, 1e-6])
    for every, outputs in ((0.25 * YEAR, [1, 1]), (0.4 * YEAR, [0, 0]), (0.75 * YEAR, [0, 1])):
        known = {"integrator": "ias15", "output_every": every}
        truth = IAS15.run(Problem(masses, q, v, parameters=known), YEAR, {"samples": 400})
        found = bodies.encounters(truth).sort_values("time")
        assert found["outputs"].tolist() == outputs
    said = " ".join(sentences(judge(truth.problem, duration=YEAR, quick=True)))
    assert "misses 1 of 2 encounters: no state of it falls into them" in said


@pytest.mark.slow(
    beside="test_judging_scan.py::test_every_row_has_a_status_and_what_reaches_the_error_a_spread"
)
def test_a_clock_reaches_an_error_through_close_passages_and_the_cheapest_is_recommended():
    eccentric = planet(0.99, integrator="ias15")
    bound = Problem(galvi.NBody([1.0, 1e-3]), eccentric.q0, eccentric.v0,
                    parameters=eccentric.parameters)  # fmt: skip
    judged = judge(bound, duration=3.3 * YEAR, error=1e-7, quick=True)
    table, best = judged.table, judged.recommended
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
    grown = neighbours.apart(bodies, source, truth, 1e-9)
    assert 30.0 < grown[40] / grown[1] < 60.0
    # From starts closer than can be told apart it is in proportion: a millionth from 1e-15.
    ends, later = (neighbours.horizons(bodies, source, truth, share * grown.max())["until"]
                   for share in (2e-6, 0.9e-6))  # fmt: skip
    assert ends.iloc[1] <= 1.01 * YEAR and math.isnan(ends.iloc[-1])
    assert later.iloc[-1] > 30 * YEAR
    # Where the runs that are measured have parted, closer starts are not said to stay together.
    monkeypatch.setattr(neighbours, "apart", lambda *given: np.linspace(0.0, 1.5, 41))
    ends = neighbours.horizons(bodies, source, truth, 1e-2)["until"]
    assert ends.iloc[-1] == ends.iloc[-2] <= 1.01 * YEAR
    monkeypatch.undo()
    wild = IAS15.run(burrau(), 62.0, {"samples": 40})
    chaos = neighbours.apart(bodies, sources(burrau(), 62.0)[0], wild, 1e-12)
    assert chaos.max() / 1e-12 > 1e4 * grown.max() / 1e-9


@pytest.mark.slow(beside="test_a_source_of_truth_that_is_wrong_is_seen")
def test_a_source_that_stops_does_not_end_the_judgement():
    problem = Problem(burrau().system, burrau().q0, burrau().v0, parameters={"integrator": "ias15"})
    found = judge(problem, duration=2.5, error=1e-6)
    assert found.passed and found.truth_agreement < 1e-6
    assert all(np.all(np.isfinite(one.apart)) for one in found.agreements)
    assert min(one.t[-1] for one in found.agreements) < 2.5 and math.isinf(found.trusted_until)


def test_moons_are_no_encounters_and_set_the_pace():
    q = np.array([[0, 0, 0], [1, 0, 0], [1.0026, 0, 0]], dtype=float)
    v = np.array([[0, 0, 0], [0, 1, 0], [0, 1.0 + (3e-6 / 0.0026) ** 0.5, 0]], dtype=float)
    moon = Problem(galvi.NBody([1.0, 3e-6, 3e-8]), q, v, parameters={"integrator": "ias15"})
    assert bodies.shortest_period(moon) == pytest.approx(2 * math.pi * (0.0026**3 / 3e-6) ** 0.5,
                                                         rel=0.05)  # fmt: skip
    assert len(bodies.encounters(IAS15.run(moon, 3.0, {"samples": 600}))) == 0
    far = IAS15.run(planets(), 1e6, {"samples": 50})  # states much farther apart than a revolution
    assert len(bodies.encounters(far)) == 0


def test_the_options_of_the_own_integrator_are_kept():
    rebound = pytest.importorskip("rebound")
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=1e-3, a=1.0)
    sim.integrator, sim.dt = "whfast", 0.1
    sim.integrator.corrector, sim.integrator.safe_mode = 17, 0
    own = own_setting(bodies, Model(galvi.from_rebound(sim)), {})
    assert own.step == 0.1 and own.options["corrector"] == 17 and own.options["safe_mode"] == 0
    other = own_setting(bodies, Model(galvi.from_rebound(sim)), {"integrator": "leapfrog"})
    assert "corrector" not in other.options


@pytest.mark.parametrize(
    ("own", "sentence"),
    [
        ({"integrator": "wfast"}, "own integrator must be one of"),
        ({"integrator": "saba", "dt": None}, "saba takes equal steps"),
    ],
)
def test_an_unknown_own_integrator_is_refused(own, sentence):
    with pytest.raises(ValueError, match=sentence):
        judge(planets(), own=own)


def test_other_models_are_refused():
    with pytest.raises(ValueError, match="judge takes a model of point masses"):
        judge(galvi.problems.pendulum_3d())
    with pytest.raises(ValueError, match="duration must not be 0"):
        judge(planets(), duration=0.0)
    with pytest.raises(ValueError, match=r"own dt must be at most the duration 1; received 200"):
        judge(planets(), duration=-1.0)
    with pytest.raises(ValueError, match="own dt must not be 0"):
        judge(planets(), own={"dt": 0.0})
    with pytest.raises(ValueError, match="error must be"):
        judge(planets(), error=0.0)
