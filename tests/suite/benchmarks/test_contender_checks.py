"""`verify` of users' contenders: correct ones pass, and each planted fault is caught."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest

import galvi
from benchmarks.applications.external import long_runs
from benchmarks.applications.external.check_problems import CHECK_PROBLEMS
from benchmarks.applications.external.check_runs import GROWTH, Runs
from benchmarks.applications.external.checks import (
    LARGEST_ERROR,
    MEMORY_LEFT,
    ClaimRows,
    contender_checks,
)
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.applications.external.loading import ContenderError, metadata
from benchmarks.applications.external.reversed_runs import REVERSED
from benchmarks.applications.external.worker import memory_growth
from benchmarks.store.tables import table_of
from references.scipy.ivp import DOP853, TIGHT
from tests.suite.benchmarks.contenders_at_hand import (
    BROKEN,
    ORBIT,
    SWING,
    Altered,
    Bare,
    Choosy,
    Failing,
    FineFirst,
    Gauss,
    Inside,
    OneSided,
    Raising,
    Single,
    Stepped,
    Still,
    Unseen,
    Unsure,
    WithoutLongRuns,
    WithoutSteps,
    aliased,
    altered,
    between,
    checked,
    erratic,
    heavy,
    mirrored,
    swapped_start,
    unseeded,
)
from tests.suite.benchmarks.correct_contenders import (
    FOUR,
    METHODS,
    SETTINGS,
    SIX,
    Adaptive,
    Compiled,
)

PROBLEMS = {check.problem.name: check for check in CHECK_PROBLEMS}
DRIVEN = PROBLEMS["driven oscillator"]
SHORT = replace(ORBIT, long=20.3)
STALE = 3000  # steps after which some integrators become wrong


def only_row(rows: Any, start: str) -> Any:
    """The only row whose quantity begins with `start`."""
    (row,) = (row for row in rows if row.quantity.startswith(start))
    return row


def with_parts(contender: Any, **parts: Any) -> Any:
    """The contender, with these attributes replaced."""
    vars(contender).update(parts)
    return contender


@pytest.mark.slow(beside="test_an_order_is_looked_for_at_longer_steps_than_it_offers")
def test_a_sound_contender_is_as_expected_and_what_it_does_not_say_is_told():
    rows, differing, external = checked(Gauss(), *CHECK_PROBLEMS)
    assert differing == [] and external.faults == []
    assert {row.setup.partition(";")[0] for row in rows if "T =" in row.setup} == {
        check.problem.name for check in CHECK_PROBLEMS
    }
    orders = [row for row in rows if row.quantity.startswith("order in the step")]
    assert len(orders) == sum(check.ordered <= Gauss.order for check in CHECK_PROBLEMS)
    assert sum(row.verdict == "attained" for row in orders) >= 7  # of 8
    assert {row.verdict for row in rows if row.quantity.startswith("error at step")} == {"finding"}
    assert {row.verdict for row in rows if "relative change" in row.quantity} == {"holds"}


WRONG_CONTENDERS = {  # contender: (beginnings of the quantities that show it, words of a reason)
    Still(): (["error at its finest over the way from the start"], "Furthest from the truth"),
    Altered(mirrored): (
        ["runs and answers that failed"],
        "Its first p must be the problem's start",
    ),
    Altered(heavy): (["error at its finest over that at its coarsest"], "What becomes no better"),
    Altered(swapped_start): (
        ["runs and answers that failed"],
        "Its first q must be the problem's start",
    ),
    Altered(aliased): (["runs and answers that failed"], "Its first q must be the problem's start"),
    Altered(between): (["error at its finest over the way from the start"], "its configuration"),
    Single(): (["error at its finest over that at its coarsest"], "It offers one setting"),
    Altered(erratic): (["order in the step"], "follow no power of the step"),
    FineFirst(): (["runs and answers that failed"], "must go from coarse to fine"),
    Unsure(): (["runs and answers that failed"], "OSError: who knows"),
    Bare(): (["runs and answers that failed"], "one at least"),
    **{
        broken(): (
            ["runs and answers that failed", "error", "relative change of energy"],
            reason,
        )
        for broken, reason in BROKEN.items()
    },
}


@pytest.mark.parametrize("wrong", WRONG_CONTENDERS, ids=lambda contender: contender.name)
def test_what_is_wrong_is_red_with_the_reason(wrong):
    quantities, reason = WRONG_CONTENDERS[wrong]
    rows, differing, external = checked(wrong, SHORT)
    first = f"{quantities[0]}, {ORBIT.problem.name}"
    caught = only_row(rows, first)
    assert caught in differing and reason in caught.reason
    assert {row.quantity.partition(",")[0].partition(" at step")[0] for row in differing} >= {
        *quantities
    }
    if first.startswith("runs") and external.faults:
        assert any(reason in fault for fault in external.faults)


SINGLE_FAULTS = {  # (contender, problem, the quantities that show its fault, words of a reason)
    "another force": (
        with_parts(Stepped(), order=None, conserves={}, strength=1.001),
        ORBIT,
        {"error at its finest over that at its coarsest"},
        "",
    ),
    "no seed": (
        Altered(unseeded),
        ORBIT,
        {"difference of two equal runs", "difference of equal runs of two processes"},
        "it is not deterministic",
    ),
    "an energy beyond its bound": (
        with_parts(Gauss(), conserves={"energy": 1e-30}, order=None),
        replace(PROBLEMS["henon-heiles"], long=10.3),
        {"relative change of energy", "relative change of energy in its longest run"},
        "",
    ),
    "nothing that it supports": (Choosy(), ORBIT, {"problems that it supports"}, ""),
}


@pytest.mark.parametrize("fault", SINGLE_FAULTS)
def test_a_fault_is_seen_in_its_rows_and_in_no_other(fault):
    contender, problem, names, reason = SINGLE_FAULTS[fault]
    _, differing, _ = checked(contender, problem)
    assert {row.quantity.partition(",")[0] for row in differing} == names
    assert all(reason in row.reason for row in differing)


def test_what_it_conserves_has_to_be_looked_at_somewhere():
    _, (caught,), _ = checked(Unseen(), replace(ORBIT, long=20.3), replace(SWING, long=20.3))
    assert caught.quantity.startswith("problems where its angular momentum") and not caught.measured


class Moody(Gauss):
    """Its first run and every second one after it fail early."""

    count = 0

    def run(self, problem, duration, setting):
        run = super().run(problem, duration, setting)
        self.count += 1
        if self.count % 2:
            return run
        early = {"t": run.t[:2], "q": run.q[:2], "p": run.p[:2]}
        return altered(run, **early, success=False, status="Tired.")


def test_a_second_run_that_fails_is_no_exception():
    differing = checked(Moody(), ORBIT)[1]
    assert any(row.quantity.startswith("difference of two") for row in differing)


def test_a_body_at_rest_is_measured_by_the_way_of_the_system():
    masses, q = [1.0, 1.0, 1e-3], np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 0.0]])
    v = np.array([[0.0, 0.6], [0.0, -0.6], [0.0, 0.0]])
    middle = galvi.Problem(galvi.NBody(masses), q, v, name="a body between two")
    swing = SWING.problem
    hanging = replace(swing, q0=0.0 * swing.q0, v0=0.0 * swing.v0)
    for problem, strength, verdict in (
        (middle, 1.0, "holds"),
        (middle, 1.3, "contradicted"),
        (hanging, 1.0, "holds"),
    ):
        contender = with_parts(Stepped(), strength=strength, conserves={}, order=None)
        check = replace(ORBIT, problem=problem, truth=DOP853, setting=TIGHT, conserved=())
        external = Inside.of(contender)
        rows = ClaimRows("A", external, (check,)).errors(
            check, table_of(Runs(external).errors(check))
        )
        assert [row.verdict for row in rows if "over the way" in row.quantity] == [verdict]
        assert not any("failed" in row.reason for row in rows)


@pytest.mark.slow(beside="test_a_fault_is_seen_in_its_rows_and_in_no_other")
def test_an_error_beyond_the_one_that_it_claims_is_caught():
    contender = Stepped()
    for factor, caught in ((1.0, 0), (0.01, 2)):
        contender.claimed_error = lambda problem, duration, setting, factor=factor: (
            factor * 20.0 * setting["step"] ** 2
        )
        rows, differing, _ = checked(contender, ORBIT)
        assert len(differing) == caught
        claims = [row for row in rows if row.quantity.startswith("error at step")]
        assert all(row.bound.startswith("at most ") for row in claims) and len(claims) == 2


def test_failed_runs_all_count_and_are_the_reason_why_no_order_is_seen_and_not_round_off():
    rows, _, external = checked(Failing())
    assert rows[0].measured == 4 and len(external.faults) == 1  # 2 settings, order, long
    rows, _, _ = checked(Raising())
    assert not any("round-off" in row.reason for row in rows)
    order = only_row(rows, "order in the step")
    assert order.reason == "It raised RuntimeError: no, thanks."
    row = only_row(rows, "problems where its order is seen")
    assert "no run came to its end" in row.reason and "no, thanks." in row.reason


@pytest.mark.parametrize("name", ["henon-heiles", "double pendulum"])
def test_the_energies_of_grounds_are_those_of_galvi(name):
    run = Gauss().run(PROBLEMS[name].problem, 1.0, {"step": 0.05, "save_every": 1})
    energies = PROBLEMS[name].energy(run.problem, run.q, run.p)
    assert np.allclose(energies, galvi.energy(run), rtol=1e-13, atol=1e-14)


@pytest.mark.slow(beside="test_an_order_is_looked_for_at_longer_steps_than_it_offers")
def test_a_high_order_without_settings_is_seen_at_fewer_steps():
    class Eighth(Gauss):
        name, order, conserves = "eighth", 8, {}
        method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))

        def __getattribute__(self, name):
            if name == "settings":
                raise AttributeError(name)
            return super().__getattribute__(name)

    rows, differing, _ = checked(Eighth(), ORBIT)
    order = only_row(rows, "order in the step")
    assert differing == [] and order.measured == pytest.approx(8.0, abs=0.4)
    assert checked(Eighth(), *CHECK_PROBLEMS)[1] == []


class Short(Gauss):
    """Its steps are so short that its errors are those of rounding."""

    conserves: ClassVar[dict[str, float]] = {}

    def settings(self, problem, duration):
        return [{"step": duration / n, "save_every": n} for n in (2000, 4000)]


class Nervous(Short):
    """It refuses longer steps than it offers."""

    def run(self, problem, duration, setting):
        if setting["step"] > duration / 1999:
            raise ValueError("too long a step")
        return super().run(problem, duration, setting)


def test_an_order_is_looked_for_at_longer_steps_than_it_offers():
    rows, differing, external = checked(Short(), replace(SWING, long=1.0))
    order = only_row(rows, "order in the step")
    assert order.verdict == "attained" and differing == [] and external.faults == []


@pytest.mark.parametrize(
    ("kind", "why"), [(Nervous, "let it run at longer steps"), (WithoutSteps, "with a `step`")]
)
def test_an_order_that_is_not_seen_is_no_failure_and_says_what_to_do(kind, why):
    rows, differing, external = checked(kind(), replace(SWING, long=1.0))
    assert differing == [] and external.faults == []
    row = only_row(rows, "problems where its order is seen")
    assert row.verdict == row.expected == "not run" and why in row.reason


def test_a_long_run_that_fails_is_named_by_its_duration_and_is_no_reason_of_an_order_unseen():
    rows, _, external = checked(WithoutLongRuns(), replace(SWING, long=6.5))
    row = only_row(rows, "problems where its order is seen")
    assert "with a `step`" in row.reason
    (fault,) = external.faults
    assert ", T = 6.5, " in fault and fault.endswith("It raised RuntimeError: too long.")


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"order": "two"}, "order must be a positive number; received 'two'"),
        ({"order": math.nan}, "order must be a positive number"),
        ({"conserves": {"enrgy": 1e-3}}, "mapping of 'energy' or 'angular momentum'"),
        ({"conserves": {"energy": 0.0}}, "a positive number; received"),
        ({"conserves": ("energy",)}, "must be a mapping"),
        ({"symmetric": 1}, "must be True or False; received 1"),
    ],
)
def test_what_a_contender_says_of_itself_is_examined_before_anything_is_run(parts, message):
    contender = SimpleNamespace(name="x", **parts)
    with pytest.raises(ContenderError, match=message):
        metadata(contender)
    assert metadata(SimpleNamespace(name="x")) == ("x", None, {}, False)


def test_checks_have_names_of_their_own():
    externals = [ExternalIntegrator("m:A", name=name) for name in ("My one", "my one!", "мой")]
    assert [claim.id for claim in contender_checks(externals)] == [
        "A-my-one",
        "A-my-one-too",
        "A-contender",
    ]


# ---------------------------------------------------------------- settings and times


class Remembering(Gauss):
    """It computes each run once, and then returns the same one."""

    name = "remembering"

    def __init__(self) -> None:
        self.known: dict[Any, galvi.Trajectory] = {}

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        key = (problem.name, duration, *setting.items())
        if key not in self.known:
            self.known[key] = super().run(problem, duration, setting)
        return self.known[key]


def test_what_it_returned_before_has_no_time():
    external = Inside.of(Remembering())
    call = external.timed(ORBIT.problem, 5.0, {"step": 0.5, "save_every": 10})
    assert call().success and np.isnan(call.seconds(3))
    assert "had returned before" in call.failure
    correct = Inside.of(Gauss()).timed(ORBIT.problem, 5.0, {"step": 0.5, "save_every": 10})
    assert correct().success and correct.seconds(3) > 0.0 and not correct.failure
    late = Inside.of(Altered(mirrored)).timed(ORBIT.problem, 5.0, {"step": 0.5, "save_every": 10})
    assert np.isnan(late.seconds(3)) and "Its first p" in late.failure


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"samples": 10**14}, "10,000,000 states at most; received"),
        ({"step": 1e-320}, "10,000,000,000 steps at most; received a step of 1e-320"),
        ({"step": 1e-8, "save_every": 1}, "states at most"),
    ],
)
def test_a_setting_that_asks_for_too_much_is_refused_and_a_run_with_it_fails(setting, message):
    greedy = Gauss()
    greedy.settings = lambda problem, duration: [setting]
    external = Inside.of(greedy)
    assert external.settings(ORBIT.problem, 5.0, 100) == [] and message in external.faults[0]
    for beyond in (10**14, 10**400):  # a MemoryError, an OverflowError
        assert len(external.run(ORBIT.problem, 5.0, {"samples": beyond}).t) == 2


# ---------------------------------------------------------------- orders and late faults


@pytest.mark.slow(beside="test_the_order_of_a_correct_method_is_seen_at_any_steps")
@pytest.mark.parametrize("step_counts", SETTINGS.values(), ids=SETTINGS)
@pytest.mark.parametrize("method", METHODS)
def test_a_correct_method_raises_no_alarm(method, step_counts):
    rows, differing, external = checked(
        Compiled(method, step_counts=step_counts, **METHODS[method]), *CHECK_PROBLEMS
    )
    assert differing == [] and external.faults == []
    row = only_row(rows, "problems where its order is seen")
    assert row.verdict == "holds"


@pytest.mark.slow(beside="test_an_order_that_is_not_seen_is_no_failure_and_says_what_to_do")
@pytest.mark.parametrize("order", [8, None])
@pytest.mark.parametrize("shift", [-1, 0, 1])
def test_a_correct_adaptive_method_raises_no_alarm(order, shift):
    adaptive = Adaptive()
    adaptive.order, adaptive.tolerances = order, tuple(k + shift for k in Adaptive.tolerances)
    rows, differing, external = checked(adaptive, *CHECK_PROBLEMS)
    assert differing == [] and external.faults == []
    verdicts = [row.verdict for row in rows if row.quantity == "problems where its order is seen"]
    assert verdicts == ([] if order is None else ["not run"])


@pytest.mark.slow_cases("10 times coarser")
@pytest.mark.parametrize("step_counts", SETTINGS.values(), ids=SETTINGS)
def test_the_order_of_a_correct_method_is_seen_at_any_steps(step_counts):
    rows, differing, _ = checked(
        Compiled("Yoshida 6", step_counts=step_counts, **METHODS["Yoshida 6"]), SHORT
    )
    order = only_row(rows, "order in the step")
    assert differing == [] and order.measured == pytest.approx(6.0, abs=0.3)


def composition(outside: tuple[float, ...]) -> tuple[float, ...]:
    """Symmetric weights whose sum is 1."""
    return (*outside, 1.0 - 2.0 * sum(outside), *outside[::-1])


@pytest.mark.parametrize(
    ("order", "weights", "steps"),
    [
        (6, FOUR, "10 times finer"),
        (6, composition((SIX[0] + 1e-7, *SIX[1:])), "of the page"),
        (4, composition(SIX), "10 times coarser"),
        (2, composition(SIX), "of the page"),
        (8, composition(SIX), "10 times finer"),
        (8, composition(SIX), "10 times coarser"),
        (3, [1.0], "10 times finer"),
        (1, [1.0], "10 times coarser"),
    ],
)
def test_another_order_than_declared_is_seen_at_any_steps(order, weights, steps):
    wrong = Compiled("wrong", order, True, SETTINGS[steps], weights)
    differing = checked(wrong, SHORT)[1]
    assert any(row.quantity.startswith("order in the step") for row in differing)


class InSingle(Stepped):
    """It computes in single precision."""

    conserves: ClassVar[dict[str, float]] = {}

    def pull(self, problem, q, t):
        return super().pull(problem, q.astype(float), t).astype(np.float32)

    def advanced(self, problem, q, v, t, h):
        q, v = q.astype(np.float32), v.astype(np.float32)
        return super().advanced(problem, q, v, t, np.float32(h))


@pytest.mark.parametrize(
    ("declared", "step_counts"),
    [*((order, (25, 100, 400, 1600)) for order in (1, 2, 3)), (2, (250, 1000)), (3, (250, 1000))],
)
def test_the_order_of_a_method_in_single_precision_is_seen_where_its_errors_fall(
    declared, step_counts, monkeypatch
):
    monkeypatch.setattr(long_runs, "LONGEST_RUN_STEPS", 1000)
    single = with_parts(InSingle(), order=declared, step_counts=step_counts)
    rows, differing, _ = checked(single, replace(SWING, long=5.0))
    order = only_row(rows, "order in the step")
    assert order.measured == pytest.approx(2.0, abs=0.15)
    differing = [row for row in differing if "finest over that" not in row.quantity]
    assert differing == ([] if declared == 2 else [order])


class Clocked(Stepped):
    """Leapfrog with a changed time in the force, or a reversed direction of time."""

    name, order = "clocked", None
    conserves: ClassVar[dict[str, float]] = {}

    def __init__(self, clock=lambda t, t0: t, sense=1.0):
        self.clock, self.sense = clock, sense

    def pull(self, problem, q, t):
        return super().pull(problem, q, self.clock(t, problem.t0))

    def advanced(self, problem, q, v, t, h):
        start = t + 0.5 * h - 0.5 * self.sense * h
        return super().advanced(problem, q, v, start, self.sense * h)


def test_a_wrong_time_and_a_reversed_one_are_seen(monkeypatch):
    monkeypatch.setattr(long_runs, "LONGEST_RUN_STEPS", 4000)
    short = replace(DRIVEN, long=5.0)
    assert checked(Clocked(), short)[1] == []
    wrong = [
        Clocked(lambda t, t0: -t),
        Clocked(lambda t, t0: 0.0),
        Clocked(lambda t, t0: t - t0),
        Clocked(lambda t, t0: t + 1.0),
        Clocked(lambda t, t0: 2.0 * t0 - t),
    ]
    for contender in wrong:
        rows = {row.quantity: row for row in checked(contender, short)[1]}
        assert rows[f"error at its finest over the way from the start, {DRIVEN.problem.name}"]
    for check in CHECK_PROBLEMS:
        if check.problem.name.startswith(("harmonic", "planar pendulum", "driven")):
            rows = checked(Clocked(sense=-1.0), replace(check, long=5.0))[1]
            assert any("over the way" in row.quantity for row in rows), check.problem.name


class LateClock(Clocked):
    """Its time is wrong from step STALE of each run on."""

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        late = problem.t0 + STALE * setting["step"]
        self.clock = lambda t, t0: t + 1.0 if t > late else t
        return super().run(problem, duration, setting)


def test_a_clock_that_goes_wrong_after_many_steps_is_seen(monkeypatch):
    monkeypatch.setattr(long_runs, "LONGEST_RUN_STEPS", 40_000)
    (row,) = long_runs.cut_run(Inside.of(LateClock()), DRIVEN)
    assert row["steps"] == 8000 and row["value"] > LARGEST_ERROR
    symmetric = [
        Compiled(name, step_counts=(100,), **METHODS[name]) for name in ("leapfrog", "Yoshida 6")
    ]
    for contender in (*symmetric, Clocked(), Adaptive()):
        external = Inside.of(contender)
        (row,) = long_runs.cut_run(external, DRIVEN)
        assert row["value"] < 1e-6 and external.faults == []  # 3e-9 of Adaptive


class Late(Compiled):
    """Correct up to step STALE only."""

    def __init__(self, factor: float) -> None:
        super().__init__("late", step_counts=(100, 400, 1600), **METHODS["leapfrog"])
        self.factor = factor

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        run = super().run(problem, duration, setting)
        late = np.arange(len(run.t)) * setting["save_every"] > STALE
        wrong = np.where(late, self.factor, 1.0)[:, None]
        return replace(run, q=run.q * wrong)


@pytest.mark.parametrize(
    ("factor", "name"),
    [(np.nan, "runs and answers that failed"), (1.01, "relative change of angular momentum")],
)
def test_what_goes_wrong_after_many_steps_only_is_seen(factor, name):
    assert checked(Late(1.0), SHORT)[1] == []
    differing = checked(Late(factor), SHORT)[1]
    assert any(row.quantity.startswith(name) for row in differing)


def test_the_longest_run_is_no_longer_than_the_time_limit_allows():
    rows, differing, _ = checked(Late(1.0), SHORT)
    row = only_row(rows, "steps of its longest run")
    assert differing == [] and 90_000 < row.measured < 110_000


# ---------------------------------------------------------------- runs back, and memory


def turned_back(contender: Any, *check_problems: Any) -> list[Any]:
    """The contender's rows on runs back, for each problem that it supports."""
    contender.symmetric = True
    external = Inside.of(contender)
    judge = ClaimRows("A", external, check_problems)
    rows = []
    for problem in check_problems:
        if external.supports(problem.problem):
            rows += judge.reversed(problem, table_of(Runs(external).reversed(problem)))
    return rows


@pytest.mark.parametrize("method", METHODS)
def test_compositions_and_gauss_return_to_their_start_and_runge_and_kutta_do_not(method):
    contender = Compiled(method, step_counts=(100, 400, 1600), **METHODS[method])
    rows = turned_back(contender, *CHECK_PROBLEMS)
    assert len(rows) >= 7
    expected = "contradicted" if method == "Runge-Kutta 4" else "holds"
    assert {row.verdict for row in rows} == {expected}, rows


class Midpoint(Gauss):
    """Symmetric on rotations too, with rotation vectors from the start of a step."""

    name, order = "midpoint", 2
    method = galvi.Galerkin(galvi.Polynomials(1), galvi.gauss(1), galvi.Exponential())


def test_rotations_and_lagrangians_return_where_the_method_is_symmetric_on_them():
    on_groups = [case for case in CHECK_PROBLEMS if case.problem.q0.shape != case.problem.v0.shape]
    rows = [
        *turned_back(Midpoint(), *on_groups),
        *turned_back(Gauss(), PROBLEMS["double pendulum"]),
    ]
    assert len(rows) == 3 and {row.verdict for row in rows} == {"holds"}
    # Gauss's stages in the chart of a step's start are not symmetric.
    assert {row.verdict for row in turned_back(Gauss(), *on_groups)} == {"contradicted"}


class OneWay(Gauss):
    """It cannot run backwards."""

    name = "one way"

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        if duration < 0.0:
            raise ValueError("the duration must be positive")
        return super().run(problem, duration, setting)


def test_a_method_that_is_not_symmetric_is_caught_where_it_says_so_and_nowhere_else():
    (row,) = turned_back(OneSided(), ORBIT)
    assert row.verdict == "contradicted" and row.measured > 1e-4
    assert row.quantity == f"{REVERSED}, {ORBIT.problem.name}" and "symmetric" in row.reason
    (row,) = turned_back(OneWay(), ORBIT)
    assert row.verdict == "contradicted" and row.measured is None
    assert row.reason == "It raised ValueError: the duration must be positive."
    rows, differing, external = checked(OneWay(), SHORT)
    assert differing == [] and external.faults == []
    assert not any(row.quantity.startswith(REVERSED) for row in rows)


def test_what_chooses_its_steps_is_not_run_back():
    (row,) = turned_back(WithoutSteps(), ORBIT)
    assert row.verdict == row.expected == "not run" and "settings with a `step`" in row.reason


def from_zero(contender_class: type[Gauss]) -> Any:
    """A contender that supports only problems with t0 = 0."""

    class FromZero(contender_class):
        def supports(self, problem):
            return problem.t0 == 0.0

    return FromZero()


def test_what_only_starts_at_time_zero_is_run_back_unless_time_matters():
    (row,) = turned_back(from_zero(OneSided), ORBIT)
    assert row.verdict == "contradicted" and row.measured > 1e-4
    (row,) = turned_back(from_zero(Gauss), ORBIT)
    assert row.verdict == "holds"
    driven = replace(DRIVEN, problem=replace(galvi.problems.driven_oscillator(), t0=0.0))
    (row,) = turned_back(from_zero(Gauss), driven)
    assert row.verdict == row.expected == "not run" and "t = 5" in row.reason
    external = Inside.of(from_zero(Gauss))
    rows = table_of(Runs(external).restarted(driven))
    (row,) = ClaimRows("A", external, (driven,)).restarted(driven, rows)
    assert row.verdict == row.expected == "not run" and row.reason.startswith("It does not support")


LEAK = 40_000_000  # bytes: more than the C library takes from what was freed before


class Keeping(Gauss):
    """It keeps an array of `size` bytes after each run."""

    name = "keeping"

    def __init__(self, size: int) -> None:
        self.size, self.kept = size, []

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        self.kept.append(np.ones(self.size // 8))
        return super().run(problem, duration, setting)


def growth(contender):
    """The row on the memory that a contender's runs keep."""
    external = Inside.of(contender)
    external.watched = True
    (row,) = ClaimRows("A", external, (ORBIT,)).memory(
        ORBIT, table_of(Runs(external).memory(ORBIT))
    )
    return row


def test_memory_that_each_run_keeps_is_caught_and_what_is_taken_once_is_not(monkeypatch):
    monkeypatch.setattr("benchmarks.applications.external.worker.MOST_RUNS_A_ROUND", 1)
    steady, leaking = growth(Keeping(0)), growth(Keeping(LEAK))
    assert steady.verdict == "holds" and steady.measured < MEMORY_LEFT
    assert leaking.verdict == "contradicted" and leaking.measured > MEMORY_LEFT
    assert steady.quantity == f"{GROWTH}, MB, {ORBIT.problem.name}"


def test_a_run_that_is_long_is_not_repeated_for_its_memory(monkeypatch):
    monkeypatch.setattr("benchmarks.applications.external.worker.SLOW_RUN_SECONDS", 0.0)
    assert np.isnan(memory_growth(Gauss(), ORBIT.problem, 5.0, {"step": 0.5, "save_every": 10}))
    row = growth(Gauss())
    assert row.verdict == row.expected == "not run" and "too long" in row.reason
