"""What every frame does: runs, curves, orders, symplecticity, refusals; and planted faults."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.measures.symplectic_form import WEIGHTS, canonical_defect
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
    """The problem with forces beside gravity."""
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


def truth(problem: galvi.Problem, duration: float) -> Any:
    """The run of the general method with 16 stages, in small steps."""
    fine = galvi.Galerkin(galvi.Polynomials(16), galvi.gauss(16))
    steps = max(1, round(abs(duration) / 0.2))
    return galvi.integrate(problem, fine, duration / steps, steps)


def distance(run: Any, other: Any) -> float:
    gaps = (run.q[-1] - other.q[-1], run.p[-1] - other.p[-1])
    return max(float(np.max(np.abs(gap))) for gap in gaps)


def order_of(case: str, s: int, steps: tuple[float, ...], duration: float = 4.8) -> float:
    """The slope of the errors at the end."""
    problem, frame, _ = CASES[case]
    true = truth(problem, duration)
    errors = [
        distance(galvi.integrate(problem, method(frame, s), h, duration=duration), true)
        for h in steps
    ]
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


def defect(problem: galvi.Problem, used: galvi.Galerkin, step: float) -> float:
    """That of DF^T J DF = J for F: (q0, p0) -> (q1, p1) of two steps, by central differences."""
    d, shape, system = problem.q0.size, problem.q0.shape, problem.system
    start = np.concatenate([problem.q0.ravel(), problem.p0.ravel()])
    nudges = np.repeat([2.0**-9, 2.0**-9 * float(np.max(np.abs(problem.p0)) or 1.0)], d)
    DF = np.zeros((2 * d, 2 * d))
    for column, nudge in enumerate(nudges):
        for k, weight in enumerate(WEIGHTS, start=1):
            for sign in (1.0, -1.0):
                moved = start.copy()
                moved[column] += sign * k * nudge
                q, p = moved[:d].reshape(shape), moved[d:].reshape(shape)
                near = galvi.Problem(system, q, system.velocity(p), problem.t0)
                run = galvi.integrate(near, used, step, 2)
                end = np.concatenate([run.q[-1].ravel(), run.p[-1].ravel()])
                DF[:, column] += sign * weight * end / nudge
    scale = np.repeat([1.0, float(np.max(np.abs(problem.p0)) or 1.0)], d)
    return canonical_defect(DF * scale / scale[:, None])


def test_every_frame_has_a_case_and_is_exported_and_stored() -> None:
    assert {type(frame) for frame in FRAMES} == {type(frame) for _, frame, _ in CASES.values()}
    for frame in FRAMES:
        assert getattr(galvi, type(frame).__name__) is type(frame)
        assert repr(method(frame, 4)) == (
            f"Galerkin(Polynomials(degree=4), Rule('Gauss 4'), {frame!r})"
        )


@pytest.mark.parametrize(
    ("case", "s", "steps"),
    [
        ("harmonic", 1, (0.1, 0.075, 0.05)),
        ("harmonic", 2, (0.3, 0.24, 0.2)),
        ("harmonic", 3, (0.6, 0.48, 0.4)),
        ("Kepler, even", 1, (0.08, 0.06, 0.04)),
        ("Kepler, even", 2, (0.2, 0.16, 0.12)),
        ("Kepler, even", 3, (0.24, 0.2, 0.16)),
        ("Kepler, hierarchy", 2, (0.12, 0.1, 0.08)),
        ("Kepler, even, forces", 2, (0.2, 0.16, 0.12)),
        ("Kepler, even, two", 2, (0.3, 0.24, 0.2)),
        ("Kepler, hierarchy, forces", 2, (0.12, 0.1, 0.08)),
        ("Kepler", 2, (0.2, 0.16, 0.12)),
        ("Kepler", 3, (0.24, 0.2, 0.16)),
    ],
)
def test_the_order_is_twice_the_number_of_stages(
    case: str, s: int, steps: tuple[float, ...]
) -> None:
    assert method(CASES[case][1], s).order == 2 * s
    assert abs(order_of(case, s, steps) - 2 * s) < 0.35


@pytest.mark.slow_cases(but=["Kepler, even, two"])
@each_case
def test_two_steps_are_symplectic_and_a_wrong_table_is_not(
    case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, frame, h = CASES[case]
    clock = kepler_frame._clock(frame._found(problem), h) if "K" in case else None
    if clock is not None:  # nodes depend on the start, which differences move
        monkeypatch.setattr(kepler_frame, "_clock", lambda found, step: clock)
    assert defect(problem, method(frame, 3), h) < 1e-12  # 1e-13
    sound = kernel.tables_of

    def wrong(*given: Any) -> Any:
        tables = sound(*given)
        tables[0][0] *= 2.0
        return tables

    monkeypatch.setattr(kernel, "tables_of", wrong)
    clear()
    assert defect(problem, method(frame, 3), h) > 1e-8  # 1e-7, of the square of what is left
    clear()


@pytest.mark.slow_cases(but=["harmonic"])
@each_case
def test_the_derivative_of_a_step_is_exact_and_symplectic(
    case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against central differences of order six with the same nodes; a wrong force is seen."""
    problem, frame, h = CASES[case]
    used, d, shape = method(frame, 3), problem.q0.size, problem.q0.shape
    exact = galvi.step_derivative(problem, used, h)
    assert galvi.symplecticity_defect(problem, used, h) < 1e-14  # 1e-16
    if "K" in case:
        clock = kepler_frame._clock(frame._found(problem), h)
        monkeypatch.setattr(kepler_frame, "_clock", lambda found, step: clock)

    def end(x: Any) -> Any:
        start = galvi.Problem(
            problem.system, x[:d].reshape(shape), x[d:].reshape(shape), problem.t0
        )
        run = galvi.integrate(start, used, h, 1)
        return np.concatenate([run.q[-1].ravel(), run.v[-1].ravel()])

    begin, differences = np.concatenate([problem.q0.ravel(), problem.v0.ravel()]), []
    for unit in np.eye(2 * d) * 2.0**-10:
        sides = [end(begin + k * unit) - end(begin - k * unit) for k in (1, 2, 3)]
        differences.append(np.dot([0.75, -0.15, 1.0 / 60.0], sides) * 2.0**10)
    assert np.max(np.abs(np.array(differences).T - exact)) < 1e-11  # 1e-12
    if "K" in case:
        sound = kepler_frame.pulled_back
        monkeypatch.setattr(
            kepler_frame, "pulled_back", lambda mu, *given: sound(mu * (1.0 + 1e-3), *given)
        )
        assert galvi.symplecticity_defect(problem, used, h) > 1e-11  # 4e-10


@each_case
def test_the_nodes_of_a_step_are_where_its_curve_has_them(case: str) -> None:
    problem, frame, h = CASES[case]
    path = galvi.integrate(problem, method(frame, 5), h, 4).curves.path
    c = galvi.gauss(5).nodes
    for number in (0, 3):
        times, weights = path.times(number, c)
        found, slopes = path.node(np.full(5, number), times / h + 0.5)
        assert np.allclose(found, c, rtol=0.0, atol=1e-13)
        assert np.allclose(slopes * weights, h, rtol=1e-12)


@each_case
def test_steps_forwards_and_backwards_cancel_where_nodes_are_the_same(case: str) -> None:
    problem, frame, h = CASES[case]
    there = galvi.integrate(problem, method(frame, 3), h, 6)
    v = problem.system.velocity(there.p[-1])
    turned = galvi.Problem(problem.system, there.q[-1], v, float(there.t[-1]))
    back = galvi.integrate(turned, method(frame, 3), -h, 6)
    error = float(np.max(np.abs(back.q[-1] - problem.q0)))
    forwards = distance(there, truth(problem, 6 * h))
    assert forwards > 1e-6
    if case == "Kepler":  # its nodes follow the orbit at each start
        assert error < forwards
    else:
        assert error < 1e-13  # 2e-14


@each_case
def test_a_frame_can_be_saved_continued_and_thinned_to_the_bit(case: str, tmp_path: Path) -> None:
    problem, frame, h = CASES[case]
    used = method(frame, 4)
    whole = galvi.integrate(problem, used, h, 30)
    part = galvi.integrate(problem, used, h, 13)
    galvi.save(part, tmp_path / "run.npz")
    loaded = galvi.load(tmp_path / "run.npz")
    times = np.linspace(part.t[0], part.t[-1], 17)
    assert np.array_equal(loaded(times), part(times)) and loaded.method == used
    rest = galvi.resume(loaded, 17)
    assert np.array_equal(rest.q, whole.q[13:]) and np.array_equal(rest.p, whole.p[13:])
    later = np.linspace(rest.t[0] + 0.1, rest.t[-1], 11)
    assert np.allclose(rest(later), whole(later), rtol=0.0, atol=1e-13)  # t - t0 is rounded
    for name in ("bases", "coefficients"):
        assert np.array_equal(getattr(rest.curves, name), getattr(whole.curves, name)[13:])
    thin = galvi.integrate(problem, used, h, 30, save_every=7)
    assert np.array_equal(thin.q[:-1], whole.q[::7]) and np.array_equal(thin.q[-1], whole.q[-1])


@each_case
def test_more_passes_than_needed_change_nothing_and_fewer_do(case: str) -> None:
    problem, frame, h = CASES[case]
    runs = {
        passes: galvi.integrate(problem, method(replace(frame, passes=passes), 6), h, 20)
        for passes in (2, None, 30)
    }
    assert distance(runs[None], runs[30]) < 1e-13
    assert distance(runs[2], runs[30]) > 1e-12
    assert runs[2].counts["iterations"] <= 2 * 20 < runs[None].counts["iterations"]
    loose = galvi.integrate(problem, method(frame, 6), h, 20, tolerance=1e-8)
    assert loose.counts["iterations"] < runs[None].counts["iterations"]
    assert distance(loose, runs[30]) < 1e-6


@each_case
def test_sixteen_stages_begin_at_eight_and_end_the_same(
    case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, frame, h = CASES[case]
    run = galvi.integrate(problem, method(frame, 16), h, 5)
    sound = kernel._coarse
    monkeypatch.setattr(kernel, "_coarse", lambda s: (np.zeros((0, 16)), *sound(s)[1:]))
    clear()
    whole = galvi.integrate(problem, method(frame, 16), h, 5)
    clear()
    assert distance(run, whole) < 1e-13
    passes = [one.counts["iterations"] for one in (run, whole)]
    assert whole.counts["force_evaluations"] == 16 * passes[1]
    assert run.counts["force_evaluations"] == 16 * passes[0] - 8 * 5


@each_case
def test_theory_says_what_holds_in_a_frame(case: str) -> None:
    problem, frame, h = CASES[case]
    used = method(frame, 3)
    said = used.theory(problem, step=h)
    assert said.order == used.order == 6 and "symplectic" in said.frame
    assert said.symmetric is (None if case == "Kepler" else True)
    assert said.fixed_point_step is None and said.exists is None and "inertial" in said.no_bounds
    assert said.name == used.name == f"Gauss collocation, 3 stages, in the {frame.name}"
    assert said.frame in str(said) and used.theory().frame == said.frame
    assert not galvi.theory(galvi.Polynomials(3), galvi.gauss(3)).frame


@pytest.mark.parametrize("row", [0, 1])
def test_a_wrong_weight_or_node_is_seen_by_the_order(
    row: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The planted faults of the orders, at the sizes of a rounding to single precision."""
    sound = kernel.tables_of

    def wrong(*given: Any) -> Any:
        tables = sound(*given)
        tables[1 + row][0] *= 1.0 + 1e-4
        return tables

    monkeypatch.setattr(kernel, "tables_of", wrong)
    clear()
    assert abs(order_of("Kepler, even", 3, (0.24, 0.2, 0.16)) - 6) > 0.35
    clear()


def clear() -> None:
    """Forget what was measured with other tables."""
    passes.checks_of.cache_clear()


@pytest.mark.parametrize(("bound", "pairs"), [(0.44, 0), (0.46, 1)])
def test_a_body_turns_far_where_half_a_step_is_more_than_two_thirds_of_a_radian(bound, pairs):
    """On a circle of mean motion 1, beta X^2 of half a step is its square."""
    system = galvi.NBody([1.0, 1e-12])
    problem = galvi.Problem(system, [[0.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]])
    motion = galvi.KeplerFrame().motion(
        problem, 2.0 * np.sqrt(bound), galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8)).table.c
    )
    assert motion.numbers[1] == pairs
