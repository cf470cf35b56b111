"""The claims about groups catch a wrong table, a wrong motion, and momenta that are not matched."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.checks.bounds import HOLDS
from benchmarks.checks.claim import Claim
from benchmarks.claims.lie_groups import l01_methods_without_a_group as l01
from benchmarks.claims.lie_groups import l10_equivariant_interpolation as l10
from benchmarks.claims.lie_groups import l12_cayley_conditioning as l12
from benchmarks.claims.lie_groups import l13_momentum_across_charts as l13
from benchmarks.claims.lie_groups import l16_symplecticity as l16
from benchmarks.claims.lie_groups.l01_methods_without_a_group import EULER, GALERKIN, ODE45
from benchmarks.claims.lie_groups.l02_free_body_convergence_in_n import L2
from benchmarks.claims.lie_groups.l03_free_body_order import L3
from benchmarks.claims.lie_groups.l04_free_body_energy import L4
from benchmarks.claims.lie_groups.l05_momentum_spheres import L5
from benchmarks.measures.symplectic_form import form_defect
from galvi import Problem
from galvi.charts import CHARTS
from galvi.charts.maps import coordinates, place
from galvi.groups import GROUPS
from references.scipy.ivp import TIGHT
from references.scipy.rigid_ivp import RIGID_DOP853
from tests.benchmarks.bodies_by_hand import Run, by_hand, runge_kutta
from tests.benchmarks.planted_tables import contradicted, faulty, reversed_clock, rows


@pytest.mark.parametrize(
    ("claim", "make", "quantity"),
    [
        (L2, faulty(b=1.0 + 1e-9), "one-step error, n = 12, Cayley chart"),
        (L2, faulty(integral=1.0 + 1e-4), "base of the one-step error, exponential chart"),
        (L2, faulty(integral=1.0 + 1e-4), "base of the curve error, Cayley chart"),
        (L3, faulty(b=1.0 + 1e-4), "order of the one-step error, n = 5"),
        (L3, faulty(integral=1.0 + 1e-4), "order from both sides, n = 4"),
        (L4, faulty(integral=1.0 + 1e-4), "order of the largest energy error, n = 8"),
        (L5, faulty(b=1.0 + 1e-9), "largest distance to the exact y"),
        (l13.L13, faulty(b=1.0 + 1e-9), f"largest error of {l13.SECOND}"),
    ],
)
def test_a_table_that_is_slightly_wrong_is_caught(claim: Claim, make: Any, quantity: str) -> None:
    assert quantity in contradicted(claim, make)


@pytest.mark.parametrize("array", ["psi", "slope"])
def test_a_wrong_table_of_the_general_kernel_is_caught(
    array: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lanes take these functions at the points from the table's integrals."""
    integrate = galvi.integrate
    monkeypatch.setattr(
        galvi, "integrate", lambda *given, **how: integrate(*given, **{**how, "solver": "newton"})
    )
    found = contradicted(L3, faulty(**{array: 1.0 + 1e-4}))
    assert "order from both sides, n = 4" in found


def other_body(problem: Problem) -> Problem:
    """One moment larger by a millionth."""
    system: Any = problem.system
    moments = system.inertia * np.diag([1.0, 1.0, 1.0 + 1e-6])
    return Problem(galvi.RigidBody(moments, system.potential), problem.q0, problem.v0, problem.t0)


@pytest.mark.parametrize("claim", [L2, L3, L5], ids=["L2", "L3", "L5"])
@pytest.mark.parametrize("change", [reversed_clock, other_body])
def test_a_wrong_motion_is_caught_by_the_truth(
    claim: Claim, change: Callable[[Problem], Problem], monkeypatch: pytest.MonkeyPatch
) -> None:
    sound = galvi.integrate
    monkeypatch.setattr(
        galvi, "integrate", lambda problem, *rest, **more: sound(change(problem), *rest, **more)
    )
    assert contradicted(claim) != set()


def test_methods_that_stay_are_not_said_to_leave(monkeypatch: pytest.MonkeyPatch) -> None:
    exact = (RIGID_DOP853, {"samples": 50, **TIGHT})

    def momentum(body: Problem, duration: float) -> tuple[Any, Any, Any]:
        run = RIGID_DOP853.run(body, 10.0, exact[1])
        return run.t, run.p, run.p

    monkeypatch.setattr(l01, "contenders", lambda: {EULER: exact, ODE45: exact})
    monkeypatch.setattr(l01, "momentum_alone", momentum)
    found = contradicted(l01.L1)
    assert {f"largest departure from SO(3), {label}" for label in (EULER, ODE45)} <= found
    on_sphere = {f"largest {l01.SPHERE}, {label}" for label in (EULER, *l01.MOMENTUM)}
    changed = {f"largest {l01.ENERGY}, {label}" for label in (EULER, *l01.MOMENTUM)}
    assert on_sphere | changed <= found
    assert not any(GALERKIN in quantity for quantity in found)


def test_a_method_that_leaves_is_not_said_to_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(galvi, "integrate", runge_kutta)
    assert len([quantity for quantity in contradicted(l01.L1) if GALERKIN in quantity]) == 2


def test_a_chart_that_stays_at_the_identity_is_not_equivariant(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def at_the_identity(chart: Any, group: Any, points: Any, t: Any) -> Any:
        """Phi(sum_i Phi^-1(g_i) phi_i(t))."""
        unit = group.multiply(points[0], group.inverse(points[0]))
        return sound(chart, group, np.array([unit, *points[1:]]), t)

    sound = l10.interpolated
    monkeypatch.setattr(l10, "interpolated", at_the_identity)
    found = contradicted(l10.L10)
    curved = {
        f"largest defect {l10.CURVE}, {group}, {chart}"
        for group in ("SO3", "SE3", "SO3 x R1 x SO2")
        for chart in ("Cayley", "Exponential")
    }
    assert curved <= found


def test_a_chart_that_is_no_inverse_misses_the_points(monkeypatch: pytest.MonkeyPatch) -> None:
    def wrong(*arguments: Any) -> Any:
        return coordinates(*arguments) * (1.0 + 1e-9)

    monkeypatch.setattr(l10, "coordinates", wrong)
    caught = sum(l10.THROUGH in quantity for quantity in contradicted(l10.L10))
    assert caught == len(GROUPS) * len(CHARTS)


def test_a_chart_of_another_scale_has_another_constant(monkeypatch: pytest.MonkeyPatch) -> None:
    def wider(chart: Any, group: Any, g: Any, xi: Any) -> Any:
        return place(chart, group, g, 1.001 * xi)

    monkeypatch.setattr(l12, "place", wider)
    assert {
        "constant of the chart, angles up to 37 degrees",
        "angle up to which the constant is 2 [degrees]",
    } <= contradicted(l12.L12)


def test_a_step_that_leaves_the_chart_unseen_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(galvi, "integrate", runge_kutta)
    assert any("end otherwise" in quantity for quantity in contradicted(l12.L12))


@pytest.mark.parametrize("moving", [True, False], ids=["moving base", "fixed base"])
def test_momentum_at_a_base_point_that_stays_is_caught(
    moving: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(l13, "QUICK_STEPS", 8)

    def instead(problem: Problem, method: Any, h: float, steps: int) -> Run:
        return by_hand(problem, h, steps, moving, method.space.dimension, method.stages)

    monkeypatch.setattr(galvi, "integrate", instead)
    verdicts = {row.quantity: row.verdict for row in rows(l13.L13)}
    broken = {quantity for quantity, verdict in verdicts.items() if verdict != HOLDS}
    if moving:
        assert broken == set()
        return
    # What it says of the end of a step is right: only the start, and what follows from it, is not.
    # With a basis function more it is wrong by 5e-13 in a step, and only the sum shows it.
    right = {f"largest error of {l13.SECOND}{kernel}" for kernel in ("", l13.FAST)}
    small = {f"largest error of {name}{l13.FAST}" for name in (l13.FIRST, l13.MATCHED)}
    assert set(verdicts) - right - small <= broken <= set(verdicts) - right


def test_a_method_that_is_not_symplectic_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    on_rotations = {k: v for k, v in l16.PROBLEMS.items() if k.endswith(" on SO(3)")}
    monkeypatch.setattr(l16, "PROBLEMS", on_rotations)
    monkeypatch.setattr(galvi, "integrate", runge_kutta)
    assert len(contradicted(l16.L16)) == len(on_rotations) * len(CHARTS)


@pytest.mark.parametrize(("moving", "low", "high"), [(True, 0.0, 1e-12), (False, 1e-6, 1.0)])
def test_a_step_with_a_fixed_base_is_not_symplectic(moving: bool, low: float, high: float) -> None:
    """2e-14 and 1.7e-4 were measured."""
    problem = galvi.problems.free_rigid_body()

    def step(g: Any, mu: Any) -> tuple[Any, Any]:
        there = Problem(problem.system, g, problem.system.velocity(mu))
        run = by_hand(there, 0.4, 1, moving, n=4, stages=4)
        return run.q[-1], run.p[-1]

    assert low <= form_defect(step, galvi.SO3(), problem.q0, problem.p0) <= high


def test_the_form_is_that_of_galvi_and_the_method_by_hand_is_too() -> None:
    """Two implementations of each, written apart."""
    method = galvi.Galerkin(galvi.Polynomials(7), galvi.gauss(8))
    problem = galvi.problems.free_rigid_body()
    mine, run = by_hand(problem, 0.5, 8, True), galvi.integrate(problem, method, 0.5, 8)
    assert np.allclose(mine.q, run.q, atol=1e-13)  # 3e-15 was measured
    assert np.allclose(mine.p, run.p, atol=1e-13)  # 1e-14
    for label, make in l16.PROBLEMS.items():
        problem = make()
        step = l16.step_of(l16.starts_of(problem.system), method)
        group: Any = problem.system.group  # type: ignore[attr-defined]
        found = form_defect(step, group, problem.q0, problem.p0)
        assert found < 1e-12, label
        assert galvi.symplecticity_defect(problem, method, l16.STEP) < 1e-12, label
