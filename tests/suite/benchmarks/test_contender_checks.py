"""`verify` of somebody else's contender: a sound one passes, and each planted fault is caught."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

import galvi
from benchmarks.applications.external.check_problems import CHECK_PROBLEMS
from benchmarks.applications.external.check_runs import Runs
from benchmarks.applications.external.checks import Judge, contender_checks
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.applications.external.loading import ContenderError, metadata
from benchmarks.store.frames import frame
from references.scipy.ivp import DOP853, TIGHT
from tests.suite.benchmarks.contenders_at_hand import (
    BROKEN,
    ORBIT,
    SWING,
    Failing,
    Gauss,
    Inside,
    Raising,
    checked,
)


class Leapfrog(Gauss):
    """Of second order; `strength` is of the force, 1 in a sound one."""

    name, order, strength = "leapfrog", 2, 1.0
    conserves = {"energy": 0.02, "angular momentum": 1e-11}  # noqa: RUF012

    def settings(self, problem, duration):
        return [{"step": duration / n, "save_every": n} for n in (250, 1000)]

    def moved(self, h, q, v, force):
        v = v + 0.5 * h * force(q)
        q = q + h * v
        return q, v + 0.5 * h * force(q)

    def run(self, problem, duration, setting):
        h, every, q, v = setting["step"], setting["save_every"], problem.q0, problem.v0
        saved = [(q, v)]
        for k in range(1, round(duration / h) + 1):
            q, v = self.moved(
                h, q, v, lambda q: self.strength * problem.system.acceleration(q, 0.0)
            )
            saved += [(q, v)] if k % every == 0 else []
        q, v = np.swapaxes(saved, 0, 1)
        t = problem.t0 + h * every * np.arange(len(q))
        return galvi.Trajectory(problem, t, q, problem.system.momentum(v), counts={"steps": k})


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


@pytest.mark.slow(
    beside="test_correct_contenders.py::test_another_order_than_declared_is_seen_at_any_steps"
)
def test_a_wrong_order_is_caught_from_both_sides():
    for order in (1, 3):
        contender = Leapfrog()
        contender.order, contender.conserves = order, {"energy": 0.02}
        _, differing, _ = checked(contender, SWING)
        (caught,) = differing
        assert caught.quantity.startswith("order in the step") and caught.verdict == "contradicted"
        assert caught.measured == pytest.approx(2.0, abs=0.02)
    contender.order = 2
    assert checked(contender, SWING)[1] == []


class Unseeded(Gauss):
    """Its ends differ from run to run by 1e-13."""

    random = np.random.default_rng(5)

    def run(self, problem, duration, setting):
        run = super().run(problem, duration, setting)
        return replace(
            run, q=run.q * (1.0 + 1e-13 * self.random.standard_normal() * (run.t > 0)[:, None])
        )


class Moody(Gauss):
    """Every second run of a step fails early."""

    count = 0

    def run(self, problem, duration, setting):
        run = super().run(problem, duration, setting)
        self.count += 1
        if self.count % 2:
            return run
        return replace(run, t=run.t[:2], q=run.q[:2], p=run.p[:2], success=False, status="Tired.")


def test_a_second_run_that_fails_is_no_exception():
    differing = checked(Moody(), ORBIT)[1]
    assert any(row.quantity.startswith("difference of two") for row in differing)


def test_noise_without_a_seed_is_called_not_deterministic():
    caught = checked(Unseeded(), ORBIT)[1]
    assert {row.quantity.partition(",")[0] for row in caught} == {
        "difference of two equal runs", "difference of equal runs of two processes"
    }  # fmt: skip
    assert all("it is not deterministic" in row.reason and row.measured < 1e-11 for row in caught)
    rows, differing, _ = checked(Gauss(), ORBIT)
    assert differing == [] and any(row.quantity.startswith("difference of two") for row in rows)


class Drifting(Leapfrog):
    """The explicit Euler method, which wins energy, and says that it does not."""

    name, order = "drifting", 1
    conserves = {"energy": 0.02}  # noqa: RUF012

    def settings(self, problem, duration):
        return [{"step": duration / n, "save_every": n} for n in (300, 1200)]

    def moved(self, h, q, v, force):
        return q + h * v, v + h * force(q)


@pytest.mark.slow(
    beside="test_correct_contenders.py::test_what_goes_wrong_after_many_steps_only_is_seen"
)
def test_a_drift_is_caught_and_the_order_of_a_method_that_drifts_is_its_own():
    short = replace(SWING, long=40.3)
    caught, longer = checked(Drifting(), short)[1]
    assert caught.quantity.startswith("relative change of energy") and caught.measured > 0.1
    assert "in its longest run" in longer.quantity and longer.measured > caught.measured
    loose = Drifting()
    loose.conserves = {"energy": 10.0}
    caught = checked(loose, short)[1][0]  # within its bound, and growing
    assert caught.bound == "at most 10, without a drift" and caught.measured < 10.0
    loose.conserves = {}
    rows, differing, _ = checked(loose, short)
    assert differing == [] and "finding" in {row.verdict for row in rows}


def test_another_force_is_caught_though_its_order_and_energy_are_not_declared():
    wrong = Leapfrog()
    wrong.order, wrong.conserves, wrong.strength = None, {}, 1.001
    _, differing, _ = checked(wrong)
    assert [row.quantity.partition(",")[0] for row in differing] == [
        "error at its finest over that at its coarsest"
    ]


def test_a_body_at_rest_is_measured_by_the_way_of_the_system():
    masses, q = [1.0, 1.0, 1e-3], np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 0.0]])
    v = np.array([[0.0, 0.6], [0.0, -0.6], [0.0, 0.0]])
    between = galvi.Problem(galvi.NBody(masses), q, v, name="a body between two")
    swing = SWING.problem
    hanging = replace(swing, q0=0.0 * swing.q0, v0=0.0 * swing.v0)
    for problem, strength, verdict in (
        (between, 1.0, "holds"), (between, 1.3, "contradicted"), (hanging, 1.0, "holds")
    ):  # fmt: skip
        contender = Leapfrog()
        contender.strength, contender.conserves, contender.order = strength, {}, None
        check = replace(ORBIT, problem=problem, truth=DOP853, setting=TIGHT, kept=())
        external = Inside.of(contender)
        rows = Judge("A", external, (check,)).errors(check, frame(Runs(external).errors(check)))
        assert [row.verdict for row in rows if "over the way" in row.quantity] == [verdict]
        assert not any("failed" in row.reason for row in rows)


@pytest.mark.slow(
    beside="test_another_force_is_caught_though_its_order_and_energy_are_not_declared"
)
def test_an_error_beyond_the_one_that_it_claims_is_caught():
    contender = Leapfrog()
    for factor, caught in ((1.0, 0), (0.01, 2)):
        contender.claimed_error = lambda problem, duration, setting, factor=factor: (
            factor * 20.0 * setting["step"] ** 2
        )
        rows, differing, _ = checked(contender, ORBIT)
        assert len(differing) == caught
        claims = [row for row in rows if row.quantity.startswith("error at step")]
        assert all(row.bound.startswith("at most ") for row in claims) and len(claims) == 2


@pytest.mark.parametrize("broken", BROKEN, ids=lambda kind: kind.__name__)
def test_what_does_not_run_as_it_should_is_red_and_named(broken):
    rows, differing, external = checked(broken())
    assert rows[0].quantity == f"runs and answers that failed, {ORBIT.problem.name}"
    assert rows[0].verdict == "contradicted" and BROKEN[broken] in rows[0].reason
    assert any(BROKEN[broken] in fault for fault in external.faults)
    assert {row.quantity.partition(",")[0].partition(" at step")[0] for row in differing} >= {
        "error", "relative change of energy"
    }  # fmt: skip


def test_failed_runs_are_the_reason_why_no_order_is_seen_and_not_round_off():
    rows, _, _ = checked(Raising())
    assert not any("round-off" in row.reason for row in rows)
    (order,) = (row for row in rows if row.quantity.startswith("order in the step"))
    assert order.reason == "It raised RuntimeError: no, thanks."
    (seen,) = (row for row in rows if row.quantity == "problems where its order is seen")
    assert "no run came to its end" in seen.reason and "no, thanks." in seen.reason


@pytest.mark.parametrize("name", ["henon-heiles", "double pendulum"])
def test_the_energies_of_grounds_are_those_of_galvi_and_are_watched(name):
    (check,) = (one for one in CHECK_PROBLEMS if one.problem.name == name)
    run = Gauss().run(check.problem, 1.0, {"step": 0.05, "save_every": 1})
    assert np.allclose(
        check.energy(run.problem, run.q, run.p), galvi.energy(run), rtol=1e-13, atol=1e-14
    )
    tight = Gauss()
    tight.conserves, tight.order = {"energy": 1e-30}, None
    _, differing, _ = checked(tight, replace(check, long=10.3))
    assert [row.quantity for row in differing] == [
        f"relative change of energy{run}, {name}" for run in ("", " in its longest run")
    ]


def test_every_run_that_fails_counts():
    rows, _, external = checked(Failing())
    assert rows[0].measured == 4 and len(external.faults) == 1  # 2 settings, order, long


@pytest.mark.slow(beside="test_an_order_is_looked_for_at_longer_steps_than_it_offers")
def test_a_high_order_without_settings_is_seen_at_fewer_steps():
    class Eighth(Gauss):
        name, order, conserves, stages = "eighth", 8, {}, 4

        def __getattribute__(self, name):
            if name == "settings":
                raise AttributeError(name)
            return super().__getattribute__(name)

        def run(self, problem, duration, setting):
            method = galvi.Galerkin(galvi.Polynomials(self.stages), galvi.gauss(self.stages))
            steps, every = round(duration / setting["step"]), setting["save_every"]
            return galvi.integrate(problem, method, setting["step"], steps, save_every=every)

    rows, differing, _ = checked(Eighth(), ORBIT)
    (order,) = (row for row in rows if row.quantity.startswith("order in the step"))
    assert differing == [] and order.measured == pytest.approx(8.0, abs=0.4)
    rows, differing, _ = checked(Eighth(), *CHECK_PROBLEMS)
    assert differing == []


def test_one_that_cannot_answer_or_supports_nothing_is_not_green():
    class Unsure(Gauss):
        def supports(self, problem):
            raise OSError("who knows")

    class Choosy(Gauss):
        def supports(self, problem):
            return False

    class Bare(Gauss):
        def settings(self, problem, duration):
            return []

    for contender, said in ((Unsure(), "OSError: who knows"), (Bare(), "one at least")):
        rows, differing, _ = checked(contender)
        assert rows[0] in differing and said in rows[0].reason
    rows, differing, _ = checked(Choosy())
    assert rows == differing and "problems that it supports" in rows[0].quantity


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


class WithoutSteps(Short):
    """It chooses its steps, and declares an order."""

    def settings(self, problem, duration):
        return [{"tolerance": 1e-6}, {"tolerance": 1e-9}]

    def run(self, problem, duration, setting):
        samples = setting["samples"]
        step = {"step": duration / samples / 40, "save_every": 40}
        return super().run(problem, duration, step)


def test_an_order_is_looked_for_at_longer_steps_than_it_offers():
    rows, differing, external = checked(Short(), replace(SWING, long=1.0))
    (order,) = (row for row in rows if row.quantity.startswith("order in the step"))
    assert order.verdict == "attained" and differing == [] and external.faults == []


@pytest.mark.parametrize(
    ("kind", "why"), [(Nervous, "let it run at longer steps"), (WithoutSteps, "with a `step`")]
)
def test_an_order_that_is_not_seen_is_no_failure_and_says_what_to_do(kind, why):
    rows, differing, external = checked(kind(), replace(SWING, long=1.0))
    assert differing == [] and external.faults == []
    (seen,) = (row for row in rows if row.quantity == "problems where its order is seen")
    assert seen.verdict == seen.expected == "not run" and why in seen.reason


class WithoutLongRuns(WithoutSteps):
    """It raises in runs longer than 5."""

    def run(self, problem, duration, setting):
        if duration > 5.0:
            raise RuntimeError("too long")
        return super().run(problem, duration, setting)


def test_a_long_run_that_fails_is_named_by_its_duration_and_is_no_reason_of_an_order_unseen():
    rows, _, external = checked(WithoutLongRuns(), replace(SWING, long=6.5))
    (seen,) = (row for row in rows if row.quantity == "problems where its order is seen")
    assert "with a `step`" in seen.reason
    (fault,) = external.faults
    assert ", T = 6.5, " in fault and fault.endswith("It raised RuntimeError: too long.")


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({"order": "two"}, "order must be a positive number; received 'two'"),
        ({"order": math.nan}, "order must be a positive number"),
        ({"conserves": {"enrgy": 1e-3}}, "mapping of 'energy' or 'angular momentum'"),
        ({"conserves": {"energy": 0.0}}, "a positive number; received"),
        ({"conserves": ("energy",)}, "must be a mapping"),
        ({"symmetric": 1}, "must be True or False; received 1"),
    ],
)
def test_what_a_contender_says_of_itself_is_examined_before_anything_is_run(parts, said):
    contender = SimpleNamespace(name="x", **parts)
    with pytest.raises(ContenderError, match=said):
        metadata(contender)
    assert metadata(SimpleNamespace(name="x")) == ("x", None, {}, False)


def test_checks_have_names_of_their_own():
    externals = [ExternalIntegrator("m:A", name=name) for name in ("My one", "my one!", "мой")]
    assert [claim.id for claim in contender_checks(externals)] == [
        "A-my-one", "A-my-one-too", "A-contender"
    ]  # fmt: skip
