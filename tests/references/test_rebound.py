"""REBOUND's integrators as references: errors, orders, options, refusals and native builds."""

from __future__ import annotations

import signal
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import galvi

pytest.importorskip("rebound")

from references.closed_forms.kepler import KEPLER
from references.rebound import bulirsch_stoer, leapfrog, native, saba, whfast, whfast512
from references.rebound.bulirsch_stoer import BULIRSCH_STOER
from references.rebound.ias15 import IAS15
from references.rebound.leapfrog import LEAPFROG
from references.rebound.mercurius import MERCURIUS
from references.rebound.saba import SABA
from references.rebound.simulation import version
from references.rebound.trace import TRACE
from references.rebound.whfast import WHFAST
from references.rebound.whfast512 import WHFAST512
from references.stored.planets import STORED_TRUTH

SOLAR = galvi.problems.solar_system()
PLANETS = galvi.problems.solar_system(pluto=False)
SPAN = 730.5  # days; the stored truth has states at this time
TRUTH = STORED_TRUTH.run(PLANETS, SPAN, {})
FIVE_DAYS, TWO_DAYS = SPAN / 146, SPAN / 365  # steps, in days
ORBIT = galvi.problems.kepler(0.3)
needs_avx512 = pytest.mark.skipif(bool(WHFAST512.missing), reason=WHFAST512.missing or "present")


def error(contender, problem=PLANETS, duration=SPAN, truth=TRUTH, **setting):
    run = contender.run(problem, duration, setting)
    assert run.success, run.status
    return float(np.abs(run.q[-1] - truth.q[-1]).max())


def heavy():
    """The outer planets, 50 times as heavy, so that they have close encounters."""
    planets = galvi.problems.outer_solar_system()
    masses = np.append(planets.system.masses[0], 50.0 * planets.system.masses[1:])
    return galvi.Problem(galvi.NBody(masses), planets.q0, planets.v0)


LARGER_BOUNDS = {"1": 1e-6, "CM_1": 1e-6, "CL_1": 1e-6}  # by type; 4e-8, other types 7e-14 to 5e-12
ERROR_BOUNDS = [  # contender, setting, bounds on the error; measured errors in comments
    *((SABA, {"step": TWO_DAYS, "type": saba_type, "safe_mode": 0}, 0.0,
       LARGER_BOUNDS.get(saba_type, 2e-10))
      for saba_type in saba.TYPES),
    *((IAS15, {"adaptive_mode": mode}, 0.0, 2e-13)  # 2e-14
      for mode in ("PRS23", "GLOBAL", "INDIVIDUAL", "AARSETH85")),
    (SABA, {"step": FIVE_DAYS, **saba.BEST}, 0.0, 1e-9),  # 7e-14
    (WHFAST, {"step": FIVE_DAYS, **whfast.DEFAULT}, 1e-9, 1e-6),  # 2e-7
    (WHFAST, {"step": TWO_DAYS, **whfast.BEST}, 0.0, 1e-10),
    (LEAPFROG, {"step": SPAN / 1461, **leapfrog.BEST}, 0.0, 2e-11),  # 3e-13
    (BULIRSCH_STOER, {}, 1e-9, 1e-5),  # 2e-7
    (BULIRSCH_STOER, bulirsch_stoer.BEST, 0.0, 1e-10),  # 7e-12
    pytest.param(WHFAST512, {"step": TWO_DAYS, **whfast512.BEST}, 0.0, 1e-10,  # 5e-12
                 marks=needs_avx512),
    pytest.param(WHFAST512, {"step": TWO_DAYS, **whfast512.DEFAULT}, 1e-8, 1e-6,  # 4e-8
                 marks=needs_avx512),
]  # fmt: skip


@pytest.mark.parametrize(("contender", "setting", "lower", "upper"), ERROR_BOUNDS)
def test_the_stored_planets_are_found_with_errors_of_the_method(contender, setting, lower, upper):
    assert lower <= error(contender, **setting) < upper
    method = contender.run(PLANETS, SPAN, setting).method
    assert "rebound" in method and all(f"{key}={setting[key]}" in method for key in setting)


def test_ias15_keeps_the_energy_to_round_off():
    energy = galvi.energy(IAS15.run(SOLAR, 10_000.0, {"samples": 10}))
    assert np.abs(energy / energy[0] - 1.0).max() < 1e-14  # 2e-15


ORDERS = [  # contender, setting, order, bound on its deviation, numbers of steps
    (WHFAST, whfast.DEFAULT, 2, 0.1, (91, 182, 365)),
    (MERCURIUS, {}, 2, 0.05, (146, 292, 584)),
    (TRACE, {}, 2, 0.05, (146, 292, 584)),
    *((LEAPFROG, {"order": order}, order, 0.6, (80, 160, 240)) for order in (2, 4, 6)),
    (LEAPFROG, {"order": 8}, 8, 0.6, (20, 40, 60)),
]


@pytest.mark.parametrize(("contender", "setting", "order", "deviation", "counts"), ORDERS)
def test_the_order_is_what_is_claimed(contender, setting, order, deviation, counts):
    problem, span = (ORBIT, 6.0) if contender is LEAPFROG else (PLANETS, SPAN)
    truth = KEPLER.run(ORBIT, span, {}) if contender is LEAPFROG else TRUTH
    steps = span / np.array(counts)
    errors = [error(contender, problem, span, truth, step=h, **setting) for h in steps]
    assert abs(np.polyfit(np.log(steps), np.log(errors), 1)[0] - order) < deviation


OPTIONS = [  # contender, problem, setting, option by which the run differs
    *(
        (WHFAST, PLANETS, {"step": 5 * TWO_DAYS}, option)
        for option in (
            {"corrector": 11},
            {"corrector2": 1, "corrector": 17},
            {"kernel": "MODIFIEDKICK"},
            {"kernel": "COMPOSITION"},
            {"coordinates": "DEMOCRATICHELIOCENTRIC"},
            {"coordinates": "WHDS"},
            {"coordinates": "BARYCENTRIC"},
            {"safe_mode": 0, "keep_unsynchronized": 1},
        )
    ),
    (MERCURIUS, heavy(), {"step": 30.0}, {"r_crit_hill": 8.0}),
    (TRACE, heavy(), {"step": 30.0}, {"peri_mode": "FULL_IAS15"}),
]


@pytest.mark.parametrize(("contender", "problem", "setting", "option"), OPTIONS)
def test_every_option_reaches_the_engine(contender, problem, setting, option):
    span = SPAN if problem is PLANETS else 30_000.0
    plain, changed = (
        contender.run(problem, span, {**setting, "save_every": 10**6, **extra})
        for extra in ({}, option)
    )
    assert changed.success and f"{list(option)[-1]}=" in changed.method
    assert not np.array_equal(plain.q[-1], changed.q[-1])


def test_types_of_saba_differ_and_the_default_is_rebounds():
    ends = {
        saba_type: SABA.run(PLANETS, SPAN, {"step": SPAN / 73, "type": saba_type}).q[-1].tobytes()
        for saba_type in saba.TYPES
    }
    assert len(set(ends.values())) == len(saba.TYPES)
    bare = SABA.run(PLANETS, SPAN, {"step": SPAN / 73}).q[-1]
    assert bare.tobytes() == ends[saba.DEFAULT["type"]]


@pytest.mark.parametrize(
    ("contender", "setting", "complaint"),
    [
        (WHFAST, {"kernel": "LAZ"}, "kernel cannot be 'LAZ'.*MODIFIEDKICK"),
        (WHFAST, {"corrector": "high"}, "corrector cannot be 'high'"),
        (WHFAST, {"corrector": 4}, "REBOUND refuses.*0, 3, 5, 7, 11, 17"),
        (WHFAST, {"kernel": "LAZY", "coordinates": "WHDS"}, "REBOUND refuses.*Jacobi"),
        (LEAPFROG, {"order": 3}, "REBOUND refuses.*order"),
        pytest.param(
            WHFAST512,
            {"corrector": 11},
            "corrector must be 0 or 17; received 11",
            marks=needs_avx512,
        ),
    ],
)
def test_options_that_do_not_exist_or_go_together_are_refused(contender, setting, complaint):
    with pytest.raises(ValueError, match=complaint):
        contender.run(PLANETS, SPAN, {"step": TWO_DAYS, **setting})


def test_bulirsch_stoer_follows_its_tolerance_and_its_longest_step():
    assert error(BULIRSCH_STOER, tolerance=1e-13) == error(BULIRSCH_STOER, **bulirsch_stoer.BEST)
    run = BULIRSCH_STOER.run(PLANETS, SPAN, {"max_dt": 5.0})
    assert run.counts["steps"] > SPAN / 5.0 and "eps_rel=1e-08" in run.method
    with pytest.raises(ValueError, match="eps_abs must be positive"):
        BULIRSCH_STOER.run(PLANETS, SPAN, {"eps_abs": 0.0})


@pytest.mark.parametrize(
    ("contender", "best", "tolerance"),
    [
        (WHFAST, whfast.BEST, 1e-11),  # 7e-13
        pytest.param(WHFAST512, whfast512.BEST, 1e-12, marks=needs_avx512),
    ],
)
def test_a_run_ends_the_same_whether_or_not_it_is_read_on_the_way_and_goes_back(
    contender, best, tolerance
):
    often, once = (
        contender.run(PLANETS, SPAN, {"step": TWO_DAYS, "save_every": save_every, **best})
        for save_every in (73, 365)
    )
    assert np.array_equal(often.t, np.arange(6) * 73 * TWO_DAYS) and often.counts["steps"] == 365
    np.testing.assert_allclose(often.q[-1], once.q[-1], rtol=0, atol=tolerance)
    v = once.p[-1] / PLANETS.system.masses[:, None]
    return_start = galvi.Problem(PLANETS.system, once.q[-1], v)
    return_run = contender.run(return_start, -SPAN, {"step": -TWO_DAYS, "save_every": 365, **best})
    np.testing.assert_allclose(return_run.q[-1], PLANETS.q0, rtol=0, atol=1e-9)


MASSLESS = galvi.Problem(  # the massless body stands before the last, which has a mass
    galvi.NBody([1.0, 0.0, 1e-3]),
    [[0.0, 0.0], [1.6, 0.0], [0.0, 1.0]],
    [[0.0, 0.0], [0.0, 0.8], [-1.0, 0.0]],
)


@pytest.mark.parametrize(
    ("contender", "problem", "setting", "order"),
    [
        (IAS15, SOLAR, {}, [3, 1, 0, 5, 2, 4, 6, 7, 8, 9]),
        (WHFAST, SOLAR, {"step": 2.0, **whfast.BEST}, [3, 1, 0, 5, 2, 4, 6, 7, 8, 9]),
        (IAS15, MASSLESS, {}, [0, 2, 1]),
    ],
)
def test_the_order_of_the_bodies_does_not_matter(contender, problem, setting, order):
    masses, q, v = problem.system.masses, problem.q0, problem.v0
    shuffled = galvi.Problem(galvi.NBody(masses[order]), q[order], v[order])
    span = 3.0 if problem is MASSLESS else 200.0
    shuffled_run, run = (contender.run(start, span, setting) for start in (shuffled, problem))
    tolerances = {"rtol": 0.0, "atol": 1e-12} if problem is MASSLESS else {"atol": 1e-11}
    np.testing.assert_allclose(shuffled_run.q[-1], run.q[-1][order], **tolerances)
    assert abs(run.q[-1, 0] - problem.q0[0]).max() > 1e-6  # the others pull


def test_hybrids_survive_encounters_that_whfast_does_not():
    span, energy_errors = 365.25 * 600, {}
    for contender in (WHFAST, MERCURIUS, TRACE):
        energy = galvi.energy(
            contender.run(heavy(), span, {"step": span / 21_915, "save_every": 219})
        )
        energy_errors[contender.name] = np.max(np.abs(energy / energy[0] - 1.0))
    # 1.9, 5e-3, 6e-5
    assert energy_errors["REBOUND TRACE"] < 1e-3 < 0.1 < energy_errors["REBOUND WHFast"]
    assert energy_errors["REBOUND MERCURIUS"] < 0.05


def test_the_engines_warnings_are_in_the_status():
    run = WHFAST.run(SOLAR, 4000.0, {"step": 1000.0})
    assert "REBOUND warned: " in run.status and "orbital period" in run.status


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_reaches_the_program_after_a_run_too():
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    IAS15.run(SOLAR, 10.0, {})
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
        time.sleep(1.0)


@needs_avx512
def test_whfast512_is_code_of_its_own_for_any_gravitational_constant_and_leaves_the_arithmetic():
    plain = WHFAST.run(PLANETS, SPAN, {"step": TWO_DAYS, "corrector": 17, "safe_mode": 0})
    with_options = WHFAST512.run(PLANETS, SPAN, {"step": TWO_DAYS, **whfast512.BEST})
    np.testing.assert_allclose(with_options.q[-1], plain.q[-1], rtol=0, atol=1e-10)
    assert not np.array_equal(with_options.q[-1], plain.q[-1])
    problem = galvi.problems.applegate()
    truth = STORED_TRUTH.run(problem, 100.0, {})
    assert error(WHFAST512, problem, 100.0, truth, step=0.5, **whfast512.BEST) < 5e-6  # 8e-7
    assert sys.float_info.min / 2.0 > 0.0  # subnormal numbers are numbers still


def test_whfast512_wants_a_dominant_body_and_at_most_eight_more_and_avx512(monkeypatch):
    pair = galvi.Problem(galvi.NBody([1.0, 1.0]), [[0.0, 0], [1, 0]], [[0.0, 0], [0, 1]])
    problems = (PLANETS, SOLAR, galvi.problems.kepler(), pair)
    supported = [WHFAST512.supports(problem) for problem in problems]
    assert supported == [True, False, False, False]
    monkeypatch.setattr("rebound.avx512_available", False)
    assert "no AVX-512" in WHFAST512.missing
    with pytest.raises(ModuleNotFoundError, match="REBOUND WHFast512 cannot run: this CPU"):
        WHFAST512.run(PLANETS, SPAN, {"step": TWO_DAYS})


STAND_IN = (
    "__version__ = '{}'\nclass Simulation:\n    def __init__(self): raise OSError('the other')\n"
)


@pytest.fixture
def build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A function that writes a stand-in rebound of a version, whose simulations raise OSError."""

    def make(number: str) -> None:
        (tmp_path / "rebound").mkdir(exist_ok=True)
        (tmp_path / "rebound" / "__init__.py").write_text(STAND_IN.format(number))

    monkeypatch.setattr(native, "FOLDER", tmp_path)
    yield make
    native._modules.cache_clear()


def test_a_build_that_is_missing_or_does_not_fit_is_a_sentence(build) -> None:
    assert "make native" in native.missing()
    build("0.1")
    assert native.missing().startswith("rebound 0.1 is built for this processor, beside")


def test_a_build_takes_the_place_of_the_module_for_a_run_which_it_gives_back_even_after_a_fault(
    build,
) -> None:
    import rebound

    build(rebound.__version__)
    assert native.missing() == "" and native.Native(WHFAST).name == "REBOUND WHFast, native"
    problem, setting = galvi.problems.outer_solar_system(), {"step": 100.0, "save_every": 5}
    with pytest.raises(OSError, match="the other"):
        native.Native(WHFAST).run(problem, 500.0, setting)
    assert sys.modules["rebound"] is rebound and version().startswith("rebound")
    assert WHFAST.run(problem, 500.0, setting).success
