"""REBOUND driven as it should be, on the solar system, and what it does not say of itself."""

from __future__ import annotations

import signal
import time
from functools import cache

import numpy as np
import pytest

import galvi

pytest.importorskip("rebound")

from references.closed_forms.kepler import KEPLER
from references.rebound.ias15 import IAS15
from references.rebound.whfast import BEST, DEFAULT, WHFAST
from references.scipy.ivp import DOP853, TIGHT

SOLAR = galvi.problems.solar_system()


@cache
def truth():
    return IAS15.run(SOLAR, 2000.0, {})


def error(run):
    return float(np.abs(run.q[-1] - truth().q[-1]).max())


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_reaches_the_program_after_a_run_too():
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    IAS15.run(SOLAR, 10.0, {})
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
        time.sleep(1.0)


def test_ias15_keeps_the_energy_to_round_off():
    energy = galvi.energy(IAS15.run(SOLAR, 10_000.0, {"samples": 10}))
    assert np.abs(energy / energy[0] - 1.0).max() < 1e-14  # 2e-15


def test_ias15_and_dop853_find_the_same_planets():
    run = DOP853.run(SOLAR, 2000.0, TIGHT)
    assert error(run) < 2e-10  # 2e-11
    assert run.success


def test_whfast_at_its_best_is_of_higher_order_than_by_default():
    steps = np.array([8.0, 4.0, 2.0])
    by_default = [error(WHFAST.run(SOLAR, 2000.0, {"step": h, **DEFAULT})) for h in steps]
    slope = np.polyfit(np.log(steps), np.log(by_default), 1)[0]
    assert abs(slope - WHFAST.order) < 0.1
    best = WHFAST.run(SOLAR, 2000.0, {"step": 2.0, "save_every": 1000, **BEST})
    assert error(best) < 1e-10 < 1e-8 < by_default[-1]  # 2e-12, 1e-7
    assert "corrector=17" in best.method and "kernel=LAZY" in best.method


def test_whfast_reads_the_same_whether_or_not_it_is_read_on_the_way():
    often = WHFAST.run(SOLAR, 400.0, {"step": 4.0, "save_every": 10, **BEST})
    rarely = WHFAST.run(SOLAR, 400.0, {"step": 4.0, "save_every": 100, **BEST})
    assert often.q.shape[0] == 11 and rarely.q.shape[0] == 2
    np.testing.assert_allclose(often.q[-1], rarely.q[-1], atol=1e-11)  # 7e-13
    assert np.array_equal(often.t, np.arange(0.0, 401.0, 40.0))


def test_the_order_of_the_bodies_does_not_matter():
    order = np.array([3, 1, 0, 5, 2, 4, 6, 7, 8, 9])
    shuffled = galvi.Problem(
        galvi.NBody(SOLAR.system.masses[order]), SOLAR.q0[order], SOLAR.v0[order]
    )
    for contender, setting in ((IAS15, {}), (WHFAST, {"step": 2.0, **BEST})):
        there = contender.run(shuffled, 200.0, setting)
        here = contender.run(SOLAR, 200.0, setting)
        np.testing.assert_allclose(there.q[-1], here.q[-1][order], atol=1e-11)


def test_a_plane_stays_a_plane_and_a_gravitational_constant_counts():
    flat = galvi.Problem(
        galvi.NBody([1.0, 1e-3], G=4.0), [[0.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 2.0]]
    )
    for contender, setting in ((IAS15, {}), (WHFAST, {"step": 0.125, **BEST})):
        run = contender.run(flat, 3.0, setting)
        np.testing.assert_allclose(run.q[-1], KEPLER.run(flat, 3.0, {}).q[-1], atol=1e-13)


def test_every_option_of_whfast_reaches_the_engine():
    for option in (
        {"corrector": 11},
        {"corrector2": 1, "corrector": 17},
        {"kernel": "MODIFIEDKICK"},
        {"kernel": "COMPOSITION"},
        {"coordinates": "DEMOCRATICHELIOCENTRIC"},
        {"coordinates": "WHDS"},
        {"coordinates": "BARYCENTRIC"},
        {"safe_mode": 0, "keep_unsynchronized": 1},
    ):
        run = WHFAST.run(SOLAR, 400.0, {"step": 4.0, **option})
        assert run.success and f"{list(option)[-1]}=" in run.method
    plain = WHFAST.run(SOLAR, 400.0, {"step": 4.0})
    assert not np.array_equal(plain.q, WHFAST.run(SOLAR, 400.0, {"step": 4.0, "corrector": 11}).q)


@pytest.mark.parametrize(
    ("option", "complaint"),
    [
        ({"kernel": "LAZ"}, "kernel cannot be 'LAZ'.*MODIFIEDKICK"),
        ({"corrector": "high"}, "corrector cannot be 'high'"),
        ({"corrector": 4}, "REBOUND refuses.*0, 3, 5, 7, 11, 17"),
        ({"kernel": "LAZY", "coordinates": "WHDS"}, "REBOUND refuses.*Jacobi"),
    ],
)
def test_options_that_do_not_exist_or_go_together_are_refused(option, complaint):
    with pytest.raises(ValueError, match=complaint):
        WHFAST.run(SOLAR, 40.0, {"step": 4.0, **option})


def test_the_engines_warnings_are_in_the_status():
    run = WHFAST.run(SOLAR, 4000.0, {"step": 1000.0})
    assert "REBOUND warned: " in run.status and "orbital period" in run.status


@pytest.mark.parametrize("nudge", [0.0, 1e-8])
def test_ias15_does_not_pass_a_collision_off_as_a_result(nudge):
    q0, v0 = [[-0.5, 0.0], [0.5, 0.0]], [[0.0, 0.0], [0.0, nudge]]
    run = IAS15.run(galvi.Problem(galvi.NBody([1.0, 1.0]), q0, v0), 2.0, {"samples": 8})
    assert not run.success and "bodies met" in run.status
    assert run.failed_step == 4  # they meet at t = pi / 4
    assert np.all(np.isfinite(run.q[:4])) and np.all(np.isnan(run.q[4:]))


def test_a_massless_body_may_stand_before_one_that_pulls() -> None:
    """In any order the bodies move alike."""
    masses, q = np.array([1.0, 0.0, 1e-3]), np.array([[0.0, 0.0], [1.6, 0.0], [0.0, 1.0]])
    v = np.array([[0.0, 0.0], [0.0, 0.8], [-1.0, 0.0]])
    runs = [
        IAS15.run(
            galvi.Problem(galvi.NBody(masses[order]), q[order], v[order]), 3.0, {"samples": 1}
        )
        for order in ([0, 1, 2], [0, 2, 1])
    ]
    assert np.allclose(runs[0].q[-1][[0, 2, 1]], runs[1].q[-1], rtol=0.0, atol=1e-12)  # 0
    assert abs(runs[0].q[-1][0]).max() > 1e-4  # the last body pulls
