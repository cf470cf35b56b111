"""REBOUND's other integrators: that options arrive, orders hold, and limits are sentences."""

import sys

import numpy as np
import pytest

import galvi

pytest.importorskip("rebound")

from references.closed_forms.kepler import KEPLER
from references.rebound import bulirsch_stoer, leapfrog, saba, whfast, whfast512
from references.rebound.bulirsch_stoer import BULIRSCH_STOER
from references.rebound.ias15 import IAS15
from references.rebound.leapfrog import LEAPFROG
from references.rebound.mercurius import MERCURIUS
from references.rebound.saba import SABA
from references.rebound.trace import TRACE
from references.rebound.whfast import WHFAST
from references.rebound.whfast512 import WHFAST512
from references.stored.planets import STORED_TRUTH

PLANETS = galvi.problems.solar_system(pluto=False)
SPAN = 730.5  # days, kept in the stored truth
TRUTH = STORED_TRUTH.run(PLANETS, SPAN, {})
needs_avx512 = pytest.mark.skipif(bool(WHFAST512.missing), reason=WHFAST512.missing or "present")


def error(contender, problem=PLANETS, duration=SPAN, truth=TRUTH, **setting):
    run = contender.run(problem, duration, setting)
    assert run.success, run.status
    return float(np.abs(run.q[-1] - truth.q[-1]).max())


def slope(steps, errors):
    return np.polyfit(np.log(steps), np.log(errors), 1)[0]


@pytest.mark.parametrize("kind", saba.TYPES)
def test_every_type_of_saba_reaches_the_engine(kind):
    run = SABA.run(PLANETS, SPAN, {"step": SPAN / 365, "type": kind, "safe_mode": 0})
    plain = {"1": 1e-6, "CM_1": 1e-6, "CL_1": 1e-6}  # 4e-8; others 7e-14 to 5e-12
    assert np.abs(run.q[-1] - TRUTH.q[-1]).max() < plain.get(kind, 2e-10)
    assert f"type={kind}" in run.method and "rebound" in run.method


def test_types_of_saba_differ_and_the_default_is_rebounds():
    ends = {
        kind: SABA.run(PLANETS, SPAN, {"step": SPAN / 73, "type": kind}).q[-1].tobytes()
        for kind in saba.TYPES
    }
    assert len(set(ends.values())) == len(saba.TYPES)
    bare = SABA.run(PLANETS, SPAN, {"step": SPAN / 73}).q[-1]
    assert bare.tobytes() == ends[saba.DEFAULT["type"]]


def test_saba_at_its_best_is_better_than_whfast_at_the_same_step():
    step = SPAN / 146
    best = error(SABA, step=step, **saba.BEST)
    assert best < 1e-9 < error(WHFAST, step=step, **whfast.DEFAULT)  # 7e-14, 2e-7


@pytest.mark.parametrize("contender", [MERCURIUS, TRACE])
def test_hybrids_are_of_order_two_without_encounters(contender):
    counts = np.array([146, 292, 584])
    errors = [error(contender, step=SPAN / n) for n in counts]
    assert abs(slope(SPAN / counts, errors) - 2.0) < 0.05


def test_hybrids_survive_encounters_that_whfast_does_not():
    planets = galvi.problems.outer_solar_system()
    masses = np.append(planets.system.masses[0], 50.0 * planets.system.masses[1:])
    heavy = galvi.Problem(galvi.NBody(masses), planets.q0, planets.v0)
    span, left = 365.25 * 600, {}
    for contender in (WHFAST, MERCURIUS, TRACE):
        run = contender.run(heavy, span, {"step": span / 21_915, "save_every": 219})
        energy = galvi.energy(run)
        left[contender.name] = np.max(np.abs(energy / energy[0] - 1.0))
    # 1.9, 5e-3, 6e-5
    assert left["REBOUND TRACE"] < 1e-3 < 0.1 < left["REBOUND WHFast"]
    assert left["REBOUND MERCURIUS"] < 0.05


@pytest.mark.parametrize(
    ("contender", "option"),
    [(MERCURIUS, {"r_crit_hill": 8.0}), (TRACE, {"peri_mode": "FULL_IAS15"})],
)
def test_options_of_hybrids_reach_the_engine(contender, option):
    planets = galvi.problems.outer_solar_system()
    masses = np.append(planets.system.masses[0], 50.0 * planets.system.masses[1:])
    heavy = galvi.Problem(galvi.NBody(masses), planets.q0, planets.v0)
    setting = {"step": 30.0, "save_every": 1000}
    ends = [contender.run(heavy, 30_000.0, {**setting, **more}).q[-1] for more in ({}, option)]
    assert ends[0].tobytes() != ends[1].tobytes()


@pytest.mark.parametrize("order", [2, 4, 6, 8])
def test_leapfrog_has_the_order_asked_for(order):
    orbit = galvi.problems.kepler(0.3)
    exact = KEPLER.run(orbit, 6.0, {})
    counts = np.array([20, 40, 60]) * (1 if order == 8 else 4)
    errors = [error(LEAPFROG, orbit, 6.0, exact, step=6.0 / n, order=order) for n in counts]
    assert abs(slope(6.0 / counts, errors) - order) < 0.6


def test_leapfrog_at_its_best():
    assert error(LEAPFROG, step=SPAN / 1461, **leapfrog.BEST) < 2e-11  # 3e-13
    with pytest.raises(ValueError, match=r"REBOUND refuses.*order"):
        LEAPFROG.run(PLANETS, SPAN, {"step": SPAN / 100, "order": 3})


def test_bulirsch_stoer_follows_its_tolerance():
    loose = error(BULIRSCH_STOER)
    assert 1e-9 < loose < 1e-5  # 2e-7
    assert error(BULIRSCH_STOER, **bulirsch_stoer.BEST) < 1e-10  # 7e-12
    assert error(BULIRSCH_STOER, tolerance=1e-13) == error(BULIRSCH_STOER, **bulirsch_stoer.BEST)
    run = BULIRSCH_STOER.run(PLANETS, SPAN, {"max_dt": 5.0})
    assert run.counts["steps"] > SPAN / 5.0 and "eps_rel=1e-08" in run.method
    with pytest.raises(ValueError, match="eps_abs must be positive"):
        BULIRSCH_STOER.run(PLANETS, SPAN, {"eps_abs": 0.0})


@pytest.mark.parametrize("nudge", [0.0, 1e-8])
def test_bulirsch_stoer_does_not_pass_a_collision_off_as_a_result(nudge):
    q0, v0 = [[-0.5, 0.0], [0.5, 0.0]], [[0.0, 0.0], [0.0, nudge]]
    apart = galvi.Problem(galvi.NBody([1.0, 1.0]), q0, v0)
    run = BULIRSCH_STOER.run(apart, 2.0, {"samples": 8})
    assert not run.success and run.failed_step == 4 and np.all(np.isnan(run.q[4:]))


@pytest.mark.parametrize("mode", ["PRS23", "GLOBAL", "INDIVIDUAL", "AARSETH85"])
def test_ias15_finds_the_truth_by_every_step_criterion(mode):
    assert error(IAS15, adaptive_mode=mode) < 2e-13  # 2e-14


@needs_avx512
def test_whfast512_agrees_with_whfast_and_is_its_own_code():
    step = SPAN / 365
    plain = WHFAST.run(PLANETS, SPAN, {"step": step, "corrector": 17, "safe_mode": 0})
    wide = WHFAST512.run(PLANETS, SPAN, {"step": step, **whfast512.BEST})
    np.testing.assert_allclose(wide.q[-1], plain.q[-1], rtol=0, atol=1e-10)
    assert not np.array_equal(wide.q[-1], plain.q[-1])
    assert error(WHFAST512, step=step, **whfast512.BEST) < 1e-10  # 5e-12
    assert error(WHFAST512, step=step, **whfast512.DEFAULT) > 1e-8  # 4e-8


@needs_avx512
def test_whfast512_runs_backwards_and_is_read_on_the_way():
    step = SPAN / 365
    often = WHFAST512.run(PLANETS, SPAN, {"step": step, "save_every": 73, **whfast512.BEST})
    once = WHFAST512.run(PLANETS, SPAN, {"step": step, "save_every": 365, **whfast512.BEST})
    assert often.q.shape[0] == 6 and often.counts["steps"] == 365
    np.testing.assert_allclose(often.q[-1], once.q[-1], rtol=0, atol=1e-12)
    v = once.p[-1] / PLANETS.system.masses[:, None]
    turned = galvi.Problem(PLANETS.system, once.q[-1], v)
    back = WHFAST512.run(turned, -SPAN, {"step": -step, "save_every": 365, **whfast512.BEST})
    np.testing.assert_allclose(back.q[-1], PLANETS.q0, rtol=0, atol=1e-9)


@needs_avx512
def test_whfast512_takes_any_gravitational_constant_and_leaves_the_arithmetic_alone():
    problem = galvi.problems.applegate()
    truth = STORED_TRUTH.run(problem, 100.0, {})
    assert error(WHFAST512, problem, 100.0, truth, step=0.5, **whfast512.BEST) < 5e-6  # 8e-7
    assert sys.float_info.min / 2.0 > 0.0  # subnormal numbers are numbers still


def test_whfast512_wants_a_dominant_body_and_at_most_eight_more():
    assert WHFAST512.supports(PLANETS)
    assert not WHFAST512.supports(galvi.problems.solar_system())
    assert not WHFAST512.supports(galvi.problems.kepler())
    pair = galvi.Problem(galvi.NBody([1.0, 1.0]), [[0.0, 0], [1, 0]], [[0.0, 0], [0, 1]])
    assert not WHFAST512.supports(pair)


@needs_avx512
def test_whfast512_refuses_correctors_it_does_not_have():
    with pytest.raises(ValueError, match="corrector must be 0 or 17; received 11"):
        WHFAST512.run(PLANETS, SPAN, {"step": SPAN / 365, "corrector": 11})


def test_without_avx512_there_is_a_sentence(monkeypatch):
    monkeypatch.setattr("rebound.avx512_available", False)
    assert "no AVX-512" in WHFAST512.missing
    with pytest.raises(ModuleNotFoundError, match="REBOUND WHFast512 cannot run: this CPU"):
        WHFAST512.run(PLANETS, SPAN, {"step": SPAN / 365})
