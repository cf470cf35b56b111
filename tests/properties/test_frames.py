"""Every frame: orders, symplecticity, files, passes and theory, with planted faults."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import galvi
from galvi.frames import FRAMES, kepler_frame
from galvi.run.in_frame import kernel, passes

CHAIN = galvi.problems.fermi_pasta_ulam_tsingou(masses=4, alpha=0.4, beta=0.3)
MASSES = np.array([0.02, 1.0, 0.03])  # the star is not the first body
THREE = galvi.Problem(
    galvi.NBody(MASSES, G=1.3),
    [[1.0, 0.1], [0.0, 0.0], [-0.2, 2.3]],
    [[0.1, 1.1], [0.01, -0.02], [-0.75, 0.0]],
    t0=0.3,
    name="three bodies",
)
PAIRS = ((0, 2), (3, 1))
TWO_BY_TWO = galvi.Problem(  # two pairs about each other, the bodies of both far apart in order
    galvi.NBody([0.5, 0.3, 0.4, 0.2]),
    [[-0.27, -0.02], [3.96, 0.4], [0.33, 0.03], [4.06, -0.1]],
    [[-0.04, -0.7], [-0.36, 0.42], [0.06, 0.45], [0.59, 0.32]],
    t0=-0.2,
    name="two pairs",
)


def forced(problem: galvi.Problem, *forces: Any) -> galvi.Problem:
    """The problem with ``forces`` in addition to gravity."""
    system = galvi.NBody(problem.system.masses, problem.system.G, forces)
    return galvi.Problem(system, problem.q0, problem.v0, problem.t0)


OBLATE = forced(THREE, galvi.Oblateness(1, 0.1, 0.4), galvi.PowerLaw(2, 1e-4, 1.0))
OBLATE_PAIRS = forced(
    TWO_BY_TWO, galvi.PowerLaw(3, -1e-3, -2.5), galvi.Oblateness(2, 0.02, 0.2, J4=-0.03)
)
TWO = forced(
    galvi.Problem(galvi.NBody([0.7, 0.3]), [[-0.3, 0.0], [0.7, 0.1]], [[0.0, -0.3], [0.0, 0.7]]),
    galvi.Relativity(5.0, 1, form="potential"),
)
CASES: dict[str, tuple[galvi.Problem, Any, float]] = {
    "harmonic": (CHAIN, galvi.HarmonicFrame(), 0.8),
    "Kepler": (THREE, galvi.KeplerFrame(), 0.8),
    "Kepler, even": (THREE, galvi.KeplerFrame(even=True), 0.8),
    "Kepler, hierarchy": (TWO_BY_TWO, galvi.KeplerFrame(even=True, hierarchy=PAIRS), 0.6),
    "Kepler, even, forces": (OBLATE, galvi.KeplerFrame(even=True), 0.8),
    "Kepler, even, two": (TWO, galvi.KeplerFrame(even=True), 1.0),
    "Kepler, hierarchy, forces": (OBLATE_PAIRS, galvi.KeplerFrame(even=True, hierarchy=PAIRS), 0.5),
}
each_case = pytest.mark.parametrize("case", CASES)


def method(frame: Any, s: int) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s), chart=frame)


def distance(run: Any, reference: Any) -> float:
    gaps = (run.q[-1] - reference.q[-1], run.p[-1] - reference.p[-1])
    return max(float(np.max(np.abs(gap))) for gap in gaps)


def measured_order(case: str, s: int, steps: tuple[float, ...], duration: float = 4.8) -> float:
    """The order: the slope of the errors at the end over the steps, both as logarithms."""
    problem, frame, _ = CASES[case]
    fine = galvi.Galerkin(galvi.Polynomials(16), galvi.gauss(16))
    truth = galvi.integrate(problem, fine, duration / 24, 24)
    errors = [
        distance(galvi.integrate(problem, method(frame, s), h, duration=duration), truth)
        for h in steps
    ]
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


def test_every_frame_has_a_case_and_is_exported_and_stored() -> None:
    assert {type(frame) for frame in FRAMES} == {type(frame) for _, frame, _ in CASES.values()}
    for frame in FRAMES:
        assert getattr(galvi, type(frame).__name__) is type(frame)
        assert repr(method(frame, 4)) == (
            f"Galerkin(Polynomials(degree=4), Rule('Gauss 4'), {frame!r})"
        )


@pytest.mark.parametrize(
    ("case", "steps"),
    [
        ("harmonic", (0.3, 0.24, 0.2)),
        ("Kepler, even, two", (0.3, 0.24, 0.2)),
        ("Kepler, hierarchy, forces", (0.12, 0.1, 0.08)),
        ("Kepler", (0.2, 0.16, 0.12)),
    ],
)
def test_the_order_is_twice_the_number_of_stages(case: str, steps: tuple[float, ...]) -> None:
    assert method(CASES[case][1], 2).order == 4
    assert abs(measured_order(case, 2, steps) - 4) < 0.35


@pytest.mark.slow_cases(but=["harmonic", "Kepler, even, two"])
@each_case
def test_the_derivative_of_a_step_is_exact_and_symplectic(
    case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Compared with central differences of order six at the same nodes; a wrong force is seen."""
    problem, frame, h = CASES[case]
    frame_method, d, shape = method(frame, 3), problem.q0.size, problem.q0.shape
    exact = galvi.step_derivative(problem, frame_method, h)
    assert galvi.symplecticity_defect(problem, frame_method, h) < 1e-14  # 1e-16
    if "K" in case:
        clock = kepler_frame._clock(frame._hierarchy(problem), h)
        monkeypatch.setattr(kepler_frame, "_clock", lambda layout, step: clock)

    def end(x: Any) -> Any:
        start = problem.with_initial_state(x[:d].reshape(shape), x[d:].reshape(shape))
        run = galvi.integrate(start, frame_method, h, 1)
        return np.concatenate([run.q[-1].ravel(), run.v[-1].ravel()])

    start_state, differences = np.concatenate([problem.q0.ravel(), problem.v0.ravel()]), []
    for unit in np.eye(2 * d) * 2.0**-10:
        end_differences = [
            end(start_state + k * unit) - end(start_state - k * unit) for k in (1, 2, 3)
        ]
        differences.append(np.dot([0.75, -0.15, 1.0 / 60.0], end_differences) * 2.0**10)
    assert np.max(np.abs(np.array(differences).T - exact)) < 1e-11  # 1e-12
    if "K" in case:
        pull_back_changes = kepler_frame.pull_back_changes
        monkeypatch.setattr(
            kepler_frame,
            "pull_back_changes",
            lambda mu, *arguments: pull_back_changes(mu * (1.0 + 1e-3), *arguments),
        )
        assert galvi.symplecticity_defect(problem, frame_method, h) > 1e-11  # 4e-10


@each_case
def test_steps_forwards_and_backwards_cancel_where_nodes_are_the_same(case: str) -> None:
    """Nodes that depend on an orbit are taken from the start of each step, so that they differ."""
    problem, frame, h = CASES[case]
    error = galvi.round_trip_error(problem, method(frame, 3), h, 6)
    assert error < (1e-3 if case == "Kepler" else 1e-13)  # 2e-14


@each_case
def test_a_run_in_a_frame_can_be_saved_and_continued_to_the_bit(case: str, tmp_path: Path) -> None:
    problem, frame, h = CASES[case]
    uncut, part = (galvi.integrate(problem, method(frame, 4), h, n) for n in (30, 13))
    galvi.save(part, tmp_path / "run.npz")
    loaded = galvi.load(tmp_path / "run.npz")
    times = np.linspace(part.t[0], part.t[-1], 17)
    assert np.array_equal(loaded(times), part(times)) and loaded.method == part.method
    resumed = galvi.resume(loaded, 17)
    assert np.array_equal(resumed.q, uncut.q[13:]) and np.array_equal(resumed.p, uncut.p[13:])
    later = np.linspace(resumed.t[0] + 0.1, resumed.t[-1], 11)
    assert np.allclose(resumed(later), uncut(later), rtol=0.0, atol=1e-13)  # t - t0 is rounded


@each_case
def test_more_passes_than_needed_change_nothing_and_fewer_do(case: str) -> None:
    problem, frame, h = CASES[case]
    few, needed, many = (
        galvi.integrate(problem, method(replace(frame, passes=count), 6), h, 20)
        for count in (2, None, 30)
    )
    assert distance(needed, many) < 1e-13 and distance(few, many) > 1e-12
    assert few.counts["iterations"] <= 2 * 20 < needed.counts["iterations"]


@pytest.mark.parametrize("case", ["harmonic", "Kepler, even"])
def test_the_first_pass_of_sixteen_stages_is_at_eight(case: str) -> None:
    problem, frame, h = CASES[case]
    counts = galvi.integrate(problem, method(frame, 16), h, 5).counts
    assert counts["force_evaluations"] == 16 * counts["iterations"] - 8 * 5


@each_case
def test_theory_says_what_holds_in_a_frame(case: str) -> None:
    problem, frame, h = CASES[case]
    frame_method = method(frame, 3)
    theory = frame_method.theory(problem, step=h)
    assert theory.order == frame_method.order == 6 and "symplectic" in theory.frame
    assert theory.symmetric is (None if case == "Kepler" else True)
    assert (
        theory.fixed_point_step is None and theory.exists is None and "inertial" in theory.no_bounds
    )
    assert theory.name == frame_method.name == f"Gauss collocation, 3 stages, in the {frame.name}"
    assert theory.frame in str(theory) and frame_method.theory().frame == theory.frame
    assert not galvi.theory(galvi.Polynomials(3), galvi.gauss(3)).frame


@pytest.mark.parametrize("table", ["integral", "weights", "nodes"])
def test_a_wrong_number_of_a_table_is_seen_by_the_order(
    table: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Planted: a number of a table is wrong by 1e-4."""
    tables_of = kernel.tables_of

    def wrong(*arguments: Any) -> Any:
        tables = tables_of(*arguments)
        tables[("integral", "weights", "nodes").index(table)][0] *= 1.0 + 1e-4
        return tables

    monkeypatch.setattr(kernel, "tables_of", wrong)
    passes.checks_of.cache_clear()  # measured with the right tables
    assert abs(measured_order("Kepler, even", 3, (0.24, 0.2, 0.16)) - 6) > 0.35
    passes.checks_of.cache_clear()
