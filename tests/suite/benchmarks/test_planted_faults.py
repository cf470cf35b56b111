"""Claims catch wrong methods, motions and measurements that need more than one value to plant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pandas import DataFrame

import galvi
from benchmarks.applications.brownout import cloud as model
from benchmarks.applications.brownout.cloud import DIAMETERS, REYNOLDS_DRAG
from benchmarks.applications.brownout.flights import FAILED, Flights
from benchmarks.applications.brownout.step_errors import COMPARED_STEPS, UNSOLVED
from benchmarks.checks.bounds import CONTRADICTED, FINDING, HOLDS, NOT_RUN
from benchmarks.checks.faults import Fault, heavier, of_motion, reversed_clock
from benchmarks.claims.lie_groups import l13_momentum_across_charts as l13
from benchmarks.claims.lie_groups import l14_other_charts_and_groups as l14
from benchmarks.claims.lie_groups import l16_symplecticity as l16
from benchmarks.claims.lie_groups import l18_formulas_of_the_cayley_chart as l18
from benchmarks.claims.lie_groups import printed_formulas
from benchmarks.claims.lie_groups.printed_formulas import BodySteps
from benchmarks.claims.vector_spaces import v15_noether_quantities as v15
from benchmarks.claims.vector_spaces import v25_brownout_cloud as v25
from benchmarks.claims.vector_spaces import v29_moving_frames as v29
from benchmarks.claims.vector_spaces import v30_solution_map as v30
from benchmarks.claims.vector_spaces.brownout_particle import ACROSS, AWAY, DURATION, problem_of
from benchmarks.measures.refinement import collocation
from benchmarks.measures.symplectic_form import canonical_defect, form_defect, map_derivative
from benchmarks.test_problems import hung_body, joined_pendulums
from benchmarks.test_problems.coupled import Coupled, cross
from benchmarks.test_problems.hung_body import HUNG_BODY
from benchmarks.test_problems.joined_pendulums import JOINED_PENDULUMS
from galvi import Problem
from galvi.kernels.forces.rotor_wind import decay, rotor_wind
from references.textbook import galerkin as textbook
from tests.suite.benchmarks.planted_tables import CLAIM, contradicted, rows
from tests.suite.benchmarks.quick_studies import quick

IN_COLUMNS = pytest.mark.slow(beside="test_claims.py::test_a_planted_fault_is_caught")
FOLLOW = model.follow


@pytest.mark.parametrize("change", [reversed_clock, heavier])
def test_invariants_alone_do_not_see_a_wrong_motion(change: Any) -> None:
    assert [row.verdict for row in rows(CLAIM["V8"], of_motion(change))] == [HOLDS, HOLDS]


# --- Vector spaces


def slowest(start: str) -> float:
    """The smallest speed relative to the wind along the motion [m/s]."""
    problem: Any = problem_of(start)
    four = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(5))
    run = galvi.integrate(problem, four, DURATION[start] / 64, 64)
    v = problem.system.velocity(run.p)
    w = [a - rotor_wind(q, decay(t)) for a, q, t in zip(v, run.q, run.t, strict=True)]
    return float(np.min(np.linalg.norm(w, axis=1)))


def test_the_brownout_particles_starts_are_what_their_words_say() -> None:
    setup = {row.quantity: row.setup for row in CLAIM["V23"].check(DataFrame())}
    assert slowest(AWAY) > 3.0 and "|w| > 3 m/s" in setup[f"order, N = 1, {AWAY}"]  # 3.16
    assert slowest(ACROSS) < 0.1  # 0.015


def test_steps_that_fail_below_a_bound_are_not_left_out() -> None:
    """Where one eigenvalue is missing, the least one is not known."""

    def failing(integrate: Any) -> Any:
        return lambda problem, method, h, steps: (
            integrate(problem, method, h, steps) if h > 1.0 else SimpleNamespace(success=False)
        )

    claim_rows = rows(CLAIM["V13"], Fault(wrong={"galvi.integrate": failing}))
    lost = {row.quantity for row in claim_rows if row.verdict == NOT_RUN}
    for name in ("oscillator", "quartic potential"):
        assert f"least eigenvalue over all steps below the bound, {name}" in lost
        assert f"second variation over H (2.22), least below the coercive bound, {name}" in lost


@IN_COLUMNS
def test_components_that_share_a_space_after_all_are_caught() -> None:
    """Their angular momentum is then conserved: no order is left to be found."""

    def make(space: Any, rule: Any) -> galvi.Galerkin:
        shared = galvi.Polynomials(max(space.degrees)) if hasattr(space, "degrees") else space
        return galvi.Galerkin(shared, rule)

    start = "order of the change of angular"
    orders = [row.verdict for row in rows(CLAIM["V15"], make) if row.quantity.startswith(start)]
    assert len(orders) == len(v15.MIXED) and FINDING not in orders


@IN_COLUMNS
def test_a_grain_that_was_not_solved_is_counted_and_its_run_not_compared(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def one_fails(*arguments: Any, **options: Any) -> Flights:
        run = FOLLOW(*arguments, **options)
        if round(6.0 / arguments[6]) != 192:
            return run
        status, q = run.status.copy(), run.q.copy()
        status[3], q[3] = FAILED, np.nan
        return replace(run, status=status, q=q)

    monkeypatch.setattr(v25, "QUICK_SAMPLED", 100)
    monkeypatch.setattr(model, "follow", one_fails)
    for name in ("paths", "balances", "places"):
        monkeypatch.setattr(v25, name, lambda *_: [])
    claim_rows = rows(CLAIM["V25"])
    counted = next(row for row in claim_rows if row.quantity == f"{UNSOLVED}, all runs compared")
    of_runs = sum(192 in several for several in COMPARED_STEPS.values())
    assert counted.verdict == CONTRADICTED
    assert counted.measured is not None and counted.measured >= of_runs * len(DIAMETERS)
    limit = next(row for row in claim_rows if "upper limit" in row.quantity)
    assert limit.verdict == NOT_RUN


@IN_COLUMNS
def test_without_a_rising_wind_no_grain_gets_above_the_bound() -> None:
    """Thrown upwards in still air: the row on the highest position rules this out."""
    cloud = model.Cloud(DIAMETERS[-1], REYNOLDS_DRAG, np.arange(500))
    law, rates = cloud.rates
    run = FOLLOW(
        collocation(galvi.Galerkin, 2),
        *cloud.starts(),
        np.tile(rates, (500, 1)),
        law,
        1 / 64,
        6.0,
        gravity=9.80665,
        saves=24,
        wind="def wind(q, decay):\n    return 0.0, 0.0, 0.0\n",
    )
    assert np.nanmax(run.places[:, :, 2]) < v25.thrown()
    table = quick(CLAIM["V25"])
    table.loc[table["quantity"] == v25.HIGHEST, "value"] = np.nanmax(run.places[:, :, 2])
    verdicts = {row.quantity: row.verdict for row in CLAIM["V25"].check(table)}
    assert verdicts[v25.HIGHEST] == CONTRADICTED


def test_nodes_that_follow_the_start_are_not_held() -> None:
    """Their defect in V29 is no round-off, and shrinks with the error of the step."""
    problem, chart, longest, _ = v29.FRAMES["Kepler frame, moved nodes"]
    method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3), chart)
    long, short = (
        canonical_defect(map_derivative(problem, method, h)) for h in (longest, longest / 2)
    )
    assert long > 1e-11 and 2.0**5 < long / short < 2.0**8  # 6e-10, and 82


def test_theorem_2_is_not_accused_of_a_step_that_it_excludes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(v30, "opposed", lambda power: (0.5, 1.0, 1.01, 0.0))
    numbers = v30.of_general_spaces()
    assert isinstance(numbers["least singular value of the equations (8), over the largest"], str)


# --- Lie groups


def hung_without_a_torque(R: Any, translation: Any) -> Any:
    torques, moved = hung_body.pull(R, translation)
    return 0.0 * torques, moved


def joined_to_the_first_alone(R: Any, translation: Any) -> Any:
    torques, moved = joined_pendulums.pull(R, translation)
    weight = cross(joined_pendulums.CENTRES[1], joined_pendulums.WEIGHTS[1] @ R[1])
    return np.array([torques[0], weight]), moved


def changed(coupled: Coupled, change: Callable[..., dict[str, Any]]) -> Coupled:
    """The motion with fields of its equations changed, functions of (q, mu)."""
    motion = coupled.motion
    return replace(coupled, motion=lambda q, mu: replace(motion(q, mu), **change(q, mu)))


@pytest.mark.parametrize("coupled", [HUNG_BODY, JOINED_PENDULUMS], ids=["hung", "joined"])
def test_a_coupled_motion_by_newton_and_euler_is_that_of_galvi(coupled: Coupled) -> None:
    problem = coupled.problem()
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    run = galvi.integrate(problem, method, 0.1, 5)
    q, p = coupled.flow(problem.q0, problem.p0, 0.5)
    np.testing.assert_allclose(run.q[-1], q, atol=1e-12)
    np.testing.assert_allclose(run.p[-1], p, atol=1e-12)


# Motions of L14 that lack a coupling: of forces, or of the momentum about the frame with that
# about the centre.
UNCOUPLED = {
    "torque": ("SE(3)", changed(HUNG_BODY, lambda q, mu: {"pull": hung_without_a_torque})),
    "momentum": ("SE(3)", changed(HUNG_BODY, lambda q, mu: {"momenta": mu[None, :3]})),
    "one side": (
        "SO(3) x SO(3)",
        changed(JOINED_PENDULUMS, lambda q, mu: {"pull": joined_to_the_first_alone}),
    ),
}


@pytest.mark.parametrize("dropped", UNCOUPLED)
def test_a_coupling_that_is_dropped_spoils_every_order_of_its_motion(dropped: str) -> None:
    motion, wrong = UNCOUPLED[dropped]
    problem = wrong.problem()
    q, p = wrong.flow(problem.q0, problem.p0, l14.DURATION)

    def ends(flown: Problem, *_: Any) -> Any:
        """The final state of the uncoupled motion; other motions fail."""
        is_uncoupled = flown.name == problem.name
        return SimpleNamespace(
            q=q[None],
            p=p[None] * (1.0 if is_uncoupled else np.nan),
            success=is_uncoupled,
            status="",
            counts={"force_evaluations": 0},
        )

    assert contradicted(CLAIM["L14"], Fault(wrong={"galvi.integrate": lambda _: ends})) == {
        f"order of the {l14.QUANTITY}, {motion}, {chart.name} chart, n = {n}"
        for chart, ns in l14.NS[motion].items()
        for n in ns
    }


def test_a_flow_without_a_coupling_is_not_symplectic() -> None:
    """2e-15 was measured with all couplings, and 1e-2 without one."""
    defect, *broken = (
        l16.defect(partial(coupled.flow, duration=l16.STEP), coupled.problem())
        for coupled in (HUNG_BODY, *(wrong for _, wrong in UNCOUPLED.values()))
    )
    assert defect < 1e-12 and min(broken) > 1e-4


def test_momenta_at_a_base_that_stays_are_caught() -> None:
    """Each momentum is given at the other end of its step."""

    def held(momenta_of: Any) -> Any:
        def momenta(run: Any, *arguments: Any) -> Any:
            turns = np.einsum("kij,kil->kjl", run.q[1:], run.q[:-1])
            before, after = momenta_of(run, *arguments)
            return np.einsum("kij,kj->ki", turns, before), np.einsum("kji,kj->ki", turns, after)

        return momenta

    quantities = contradicted(CLAIM["L13"], Fault(wrong={f"{l13.__name__}.discrete_momenta": held}))
    of_curves = {row.quantity for row in CLAIM["L13"].check(DataFrame()) if "L_d" in row.quantity}
    assert quantities == of_curves and len(quantities) == 8


@pytest.mark.parametrize(("held", "low", "high"), [(False, 0.0, 1e-12), (True, 1e-6, 1.0)])
def test_a_step_with_a_fixed_base_is_not_symplectic(held: bool, low: float, high: float) -> None:
    """A free body by H's equations (3.51); 2e-14 and 1.7e-4 were measured."""
    problem, steps = galvi.problems.free_rigid_body(), BodySteps(4, 4, 0.4, printed=held)
    assert np.array_equal(np.diag(problem.system.inertia), printed_formulas.MOMENTS)

    def step(g: Any, mu: Any) -> tuple[Any, Any]:
        x = steps.step(mu, np.zeros(3))
        return g @ textbook.cayley(x[-1]), steps.after(x, steps.stage_sums(x))

    assert low <= form_defect(step, galvi.SO3(), problem.q0, problem.p0) <= high


def test_formulas_that_are_right_are_not_accused(monkeypatch: pytest.MonkeyPatch) -> None:
    def moving(body: BodySteps, x: Any, sums: Any, p: Any, first: Any) -> Any:
        """The mismatch of momenta with the base moved, whatever the argument `first`."""
        return p - textbook.cayley(x[-1]) @ body.after(x, sums)

    monkeypatch.setattr(printed_formulas, "J_D", 0.5 * printed_formulas.J_D)
    monkeypatch.setattr(printed_formulas, "AS_PRINTED", printed_formulas.IN_ORDER)
    monkeypatch.setattr(printed_formulas, "MISPRINTED_INDEX", 1)
    monkeypatch.setattr(BodySteps, "matched", moving)
    for name, value in {"SCALES": (10.0,), "STEPS": 1, "STATES": 10, "BODY_STEPS": 1}.items():
        monkeypatch.setattr(l18, name, value)
    accused = [row for row in rows(CLAIM["L18"]) if row.expected == "contradicted"]
    assert len(accused) == 8 and {row.verdict for row in accused} == {HOLDS}
