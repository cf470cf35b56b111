"""Engines, problems, spaces, rules and options in one table whose cells agree with their oracles.

A row is a problem with the engine that runs it and its oracle, see `tests.agreement.row`; a
column is a method, or an option of a run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from galvi.charts import CHARTS
from galvi.lanes import vectors
from galvi.run.in_lanes import lagrangian
from tests.agreement import frames_and_clocks, on_groups, on_vector_spaces, point_masses
from tests.agreement.left_to_newton import LEFT_TO_NEWTON
from tests.agreement.row import (
    ROUND_OFF,
    Cell,
    Row,
    check,
    excessive_gaps,
    gaps,
    in_short_steps,
    relative_gap,
)
from tests.properties.ensemble_cases import starts
from tests.properties.lagrangians import opaque

pytestmark = pytest.mark.skipif(
    not galvi.FAST, reason="with GALVI_FAST=0 only the general kernel runs"
)
ROWS = on_vector_spaces.ROWS | on_groups.ROWS | point_masses.ROWS | frames_and_clocks.ROWS
KERNEL_ROWS = (  # rows of every engine; those of other rows take long to compile
    "Kepler",
    "planets and massless bodies",
    "SymPy: elastic pendulum",
    "spherical pendulum",
    "frame: Kepler, even",
    "frame: harmonic",
    "clock: three bodies",
    "clock: Kepler, Sundman",
)
STANDARD_DEGREES = {"lanes": 5, "frame": 16, "clock": 8}


def standard(name: str) -> Cell:
    """The cell of a row with the degree of its engine, or 16 where the oracle takes short steps."""
    row = ROWS[name]
    return row.by_gauss(16 if row.oracle is in_short_steps else STANDARD_DEGREES[row.engine])


# ---------------------------------------------------------------- every row

DEGREES_AND_POINTS = {  # degree and points that take different code or tables in an engine
    "lanes": ((5, 5), (4, 6), (9, 9)),
    "frame": ((16, 16), (20, 20)),
    "clock": ((8, 8), (5, 5)),
}


def cells() -> Iterator[Any]:
    for name, row in ROWS.items():
        in_time = row.engine == "clock" and row.oracle is in_short_steps
        pairs = DEGREES_AND_POINTS["frame" if in_time else row.engine]
        for degree, points in pairs if name in KERNEL_ROWS else pairs[:1]:
            marks = [pytest.mark.slow] * row.slow
            yield pytest.param(name, degree, points, marks=marks)


@pytest.mark.parametrize(("name", "degree", "points"), list(cells()))
def test_every_problem_agrees(name: str, degree: int, points: int) -> None:
    check(ROWS[name].by_gauss(degree, points))


# ---------------------------------------------------------------- every method

SQUARE_ROWS = (
    "Kepler",
    "double pendulum",
    "planets and massless bodies",
    "spherical pendulum",
    "clock: three bodies",
)


@pytest.mark.parametrize(
    ("name", "stages"),
    [
        (name, stages)
        for k, name in enumerate(SQUARE_ROWS)
        for stages in range(1, 25)
        if stages in (1, 8, 9, 24) or stages % len(SQUARE_ROWS) == k
    ],
)
def test_every_number_of_stages_agrees(name: str, stages: int) -> None:
    row = ROWS[name]
    check(replace(row, step=row.step * min(1.0, 0.3 * stages)).by_gauss(stages))


PIECES = galvi.composite(galvi.gauss(4), 2)
METHODS = (
    (galvi.Polynomials(1), galvi.lobatto(2)),
    (galvi.Polynomials(3), galvi.lobatto(4)),
    (galvi.Polynomials(5), galvi.lobatto(7)),
    (galvi.Polynomials(4), galvi.radau(5)),
    (galvi.Polynomials(6), galvi.clenshaw_curtis(9)),
    (galvi.Polynomials(3), galvi.newton_cotes(5)),
    (galvi.Polynomials(5), galvi.gauss(6)),
    (galvi.Polynomials(4), galvi.gauss(10)),
    (galvi.PolynomialFourier(1, 2), galvi.gauss(16)),
    (galvi.PiecewisePolynomials(3, 2), PIECES),
    (galvi.PiecewiseHermite(2), PIECES),
)
METHOD_ROWS = (
    "Kepler",
    "V: driven, masses",
    "SymPy: elastic pendulum",
    "SymPy: relativistic",
    "SymPy: driven",
    "planets and massless bodies",
    "spherical pendulum",
    "flying body",
    "clock: Kepler, Sundman",
)


@pytest.mark.parametrize(
    ("name", "method"),
    [
        pytest.param(name, method, id=f"{name}, {method[0]}, {method[1].name}")
        for i, name in enumerate(METHOD_ROWS)
        for j, method in enumerate(METHODS)
        if name in ("Kepler", "SymPy: elastic pendulum") or (i + j) % 3 == 0
    ],
)
def test_every_space_and_rule_agrees(name: str, method: Any) -> None:
    check(ROWS[name].by_method(*method))


@pytest.mark.parametrize(("degrees", "points"), [((6, 4), 6), ((2, 7), 9), ((8, 3), 8)])
@pytest.mark.parametrize("name", ["V: compiled", "SymPy: elastic pendulum", "SymPy: driven"])
def test_a_degree_for_each_component_agrees(name: str, degrees: Any, points: int) -> None:
    check(ROWS[name].by_method(galvi.ComponentPolynomials(degrees), galvi.gauss(points)))


AT_REST = [name for name in ROWS if name.startswith(("free from", "falling from"))]
MOVING = ("free body", "spherical pendulum")
CHART_PAIRS = ((1, 1), (2, 3), (4, 4), (5, 6), (8, 8))  # degree and points


def chart_cases() -> Iterator[Any]:
    for i, name in enumerate((*AT_REST, *MOVING)):
        for j, chart in enumerate(CHARTS):
            pairs = CHART_PAIRS if name in MOVING else [CHART_PAIRS[(i + j) % len(CHART_PAIRS)]]
            yield from ((name, chart, *pair) for pair in pairs)


@pytest.mark.parametrize(("name", "chart", "degree", "points"), list(chart_cases()))
def test_every_chart_agrees(name: str, chart: Any, degree: int, points: int) -> None:
    row = ROWS[name]
    check(
        replace(row, step=row.step * min(1.0, 0.5 * degree)).by_gauss(degree, points, chart=chart)
    )


# ---------------------------------------------------------------- every option


def same_bits(run: Any, full: Any, rows: Any = slice(None)) -> None:
    """Assert that a run has exactly the states of the given rows of another."""
    for part in ("q", "p", "t"):
        np.testing.assert_array_equal(getattr(run, part), getattr(full, part)[rows])


def agrees(cell: Cell, **options: Any) -> galvi.Trajectory:
    """The run with options, asserted to agree with the oracle with the same options."""
    run = cell.run(**options)
    assert run.success and run.engine == cell.row.engine, run.status
    assert excessive_gaps(run, cell.reference(**options), cell.row) == {}
    return run


def from_later(cell: Cell) -> None:
    check(cell.with_problem(replace(cell.problem, t0=cell.problem.t0 + 2.5)))


def thinned(cell: Cell) -> None:
    nine = replace(cell, row=replace(cell.row, steps=9))
    full = nine.run()
    times = np.linspace(*full.t[[0, -1]], 11)
    for k, curves in ((3, None), (3, True), (1, False)):
        run = nine.run(save_every=k, curves=curves)
        same_bits(run, full, slice(None, None, k))
        assert (run.curves is not None) is (curves is True)
        assert np.array_equal(run(times), full(times))
        assert np.array_equal(run.velocity(times), full.velocity(times))


def coarse(cell: Cell) -> None:
    run, fine = cell.run(tolerance=1e-8), cell.run()
    assert run.success and run.counts["iterations"] < fine.counts["iterations"]
    assert gaps(run, fine)["q"] * ROUND_OFF < 1e-6


def with_more_points(cell: Cell) -> Iterator[Cell]:
    """The cell, and in lanes also one with more points than coefficients."""
    yield cell
    if cell.row.engine == "lanes":
        yield cell.row.by_gauss(4, 6)


def resumed(cell: Cell) -> None:
    for variant in with_more_points(cell):
        full = agrees(variant)
        part = galvi.integrate(variant.problem, variant.method, variant.step, 4)
        same_bits(galvi.resume(part, len(full.t) - 5), full, slice(4, None))


def for_a_duration(cell: Cell) -> None:
    full = cell.run()
    length = abs(full.t[-1] - full.t[0])
    same_bits(replace(cell, row=replace(cell.row, steps=None, duration=length)).run(), full)


def by_fixed_point(cell: Cell) -> None:
    same_bits(cell.run(solver="fixed_point"), cell.run())


def among_many(cell: Cell) -> None:
    full = cell.run()
    problems = [cell.problem] * 3
    runs = galvi.integrate_many(problems, cell.method, cell.step, len(full.t) - 1, threads=2)
    for run in runs:
        same_bits(run, full)


EVENT_GAP_BOUND = 1e5  # bound on gaps at events in units of ROUND_OFF, 2e-11


def crossing(cell: Cell, **options: Any) -> galvi.Event:
    """An event where the configuration's first entry passes its value at 0.41 of the run."""
    run = cell.run()
    level = float(np.ravel(run(run.t[0] + 0.41 * (run.t[-1] - run.t[0])))[0])
    return galvi.Event(lambda q, v, t: np.ravel(q)[0] - level, **options)


def with_events(cell: Cell) -> None:
    """Events that only report, that end the run, and that change its velocity."""
    full = cell.run()
    for options in ({}, {"terminal": True}, {"action": lambda q, v, t: (q, 0.99 * v)}):
        event = crossing(cell, **options)
        run, reference = cell.run(events=event), cell.reference(events=event)
        assert run.success and len(run.events) == len(reference.events) > 0
        assert (run.outcome.end is galvi.End.STOPPED_BY_EVENT) is ("terminal" in options)
        assert relative_gap(run.events.t, reference.events.t) < EVENT_GAP_BOUND
        assert relative_gap(run.q[-1], reference.q[-1]) < EVENT_GAP_BOUND
        assert relative_gap(run.t[-1], reference.t[-1]) < EVENT_GAP_BOUND
        if not options:
            same_bits(run, full)
    assert relative_gap(run.q[-1], full.q[-1]) > 1e6


MEMBERS = 11


def perturbed(problem: galvi.Problem, seed: int) -> galvi.Problem:
    """The problem from another start, which differs by about a hundredth."""
    if isinstance(getattr(problem.system, "group", galvi.Rn(1)), galvi.Rn):
        random = np.random.default_rng(seed)
        states = problem.q0, problem.v0
        return problem.with_initial_state(
            *(x * (1.0 + random.uniform(-0.01, 0.01, x.shape)) for x in states)
        )
    q, v = starts(problem, 1, 0.01, seed)
    return problem.with_initial_state(q[0], v[0])


def members_agree(cell: Cell) -> None:
    """Members with steps of two sizes agree; the first has the same bits in an ensemble of one."""
    problem, steps = cell.problem, cell.row.steps
    cells = [cell, *(cell.with_problem(perturbed(problem, seed)) for seed in range(1, MEMBERS))]
    q, v = (np.array([getattr(member.problem, x) for member in cells]) for x in ("q0", "v0"))
    sizes = cell.step * np.where(np.arange(MEMBERS) < 7, 1.0, 0.5)
    ensemble, single = (
        galvi.integrate_ensemble(problem, q[:n], v[:n], cell.method, sizes[:n], steps)
        for n in (MEMBERS, 1)
    )
    assert ensemble.success.all(), ensemble.status
    run_singly = cell.row.engine == "frame" or getattr(problem.system, "forces", ())
    assert run_singly or not any(outcome.notes for outcome in ensemble.outcomes.values())
    for index in (0, 7):  # one member of either step size
        reference = replace(cells[index], step=float(sizes[index])).reference()
        for k, final in enumerate((reference.q[-1], reference.p[-1])):
            assert (
                relative_gap(np.asarray(ensemble[k])[index], final) < 4.0 * cell.row.bounds["qp"[k]]
            )
            assert np.array_equal(np.asarray(ensemble[k])[0], np.asarray(single[k])[0])


def members(cell: Cell) -> None:
    for variant in with_more_points(cell):
        members_agree(variant)


# Degree and points: registers of four lanes (AVX2) leave fewer lanes idle than those of eight.
FOURS = ((3, 4), (10, 10))
COUNTED_STEPS = 200  # steps of the runs whose passes are compared


def in_fours(cell: Cell) -> None:
    """The run agrees where registers have four lanes, in about as many passes."""
    for degree, points in FOURS:
        variant = cell.row.by_gauss(degree, points)
        longer = replace(variant, row=replace(variant.row, steps=COUNTED_STEPS))
        eights = longer.run(curves=False)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(vectors, "AVX512", False)
            check(variant)
            fours = longer.run(curves=False)
        assert fours.counts["iterations"] == pytest.approx(eights.counts["iterations"], rel=0.05)


OPTIONS: dict[str, Callable[[Cell], None]] = {
    function.__name__: function
    for function in (
        from_later,
        thinned,
        coarse,
        resumed,
        for_a_duration,
        by_fixed_point,
        among_many,
        with_events,
        members,
        in_fours,
    )
}


INAPPLICABLE = {"lanes": (), "frame": ("in_fours",), "clock": ("in_fours", "for_a_duration")}


def options() -> Iterator[tuple[str, str]]:
    """Rows with each option that applies: only lanes run in fours, and rows of their own run in a
    clock for a duration."""
    yield "forces: tides", "members"  # lanes leave such members to single runs
    for name in KERNEL_ROWS:
        for option in OPTIONS:
            if option not in INAPPLICABLE[ROWS[name].engine]:
                yield name, option


@pytest.mark.parametrize(("name", "option"), list(options()))
def test_every_option_agrees(name: str, option: str) -> None:
    OPTIONS[option](standard(name))


@pytest.mark.parametrize(
    ("name", "space", "rule"),
    [
        ("V: compiled", *METHODS[1]),
        ("V: compiled", galvi.ComponentPolynomials((3, 5)), galvi.gauss(6)),
        pytest.param("flying body", *METHODS[-1], marks=pytest.mark.slow),
    ],
)
def test_members_agree_by_other_spaces_and_rules(name: str, space: Any, rule: Any) -> None:
    members_agree(ROWS[name].by_method(space, rule))


# ---------------------------------------------------------------- drawn cells

UNSTABLE = ("grain of 10 um", "grain of 50 um")  # in reversed time
ROBUST = [name for name in ROWS if not name.startswith((*UNSTABLE, "frame: the Moon"))]


def check_drawn(
    name: str,
    degree: int,
    extra_points: int,
    step_fraction: float,
    reverse: bool,
    seed: int,
    chart: Any,
    assertion: Callable[[Cell], None] = check,
) -> None:
    row = ROWS[name]
    moving = {} if row.moving else {"chart": chart}
    if row.engine != "lanes":  # some engines take only as many points as coefficients
        degree, extra_points = max(degree, 16 if row.oracle is in_short_steps else 5), 0
    cell = replace(row, step=step_fraction * row.step).by_gauss(
        degree, degree + extra_points, **moving
    )
    cell = cell.with_problem(perturbed(row.problem, seed))
    assertion = assertion if row.duration is None else check
    assertion(cell.backwards() if reverse else cell)


CELL_STRATEGIES = {
    "step_fraction": st.floats(0.2, 1.0),
    "reverse": st.booleans(),
    "seed": st.integers(0, 9999),
    "chart": st.sampled_from(CHARTS),
}


@given(
    name=st.sampled_from([name for name in ROBUST if not ROWS[name].slow]),
    degree=st.integers(2, 6),
    extra_points=st.integers(0, 2),
    **CELL_STRATEGIES,
)
@settings(max_examples=60)
def test_drawn_cells_agree(**parameters: Any) -> None:
    check_drawn(**parameters)


@pytest.mark.slow(beside="test_drawn_cells_agree")
@given(
    name=st.sampled_from(ROBUST),
    degree=st.integers(2, 24),
    extra_points=st.integers(0, 12),
    assertion=st.sampled_from((check, thinned, resumed, members_agree)),
    **CELL_STRATEGIES,
)
@settings(max_examples=150)
def test_many_drawn_cells_agree(**parameters: Any) -> None:
    check_drawn(**parameters)


@given(
    potential=st.sampled_from(sorted(on_vector_spaces.POTENTIALS)),
    masses=st.sampled_from(sorted(on_vector_spaces.MASSES)),
    size=st.integers(0, 3),
    seed=st.integers(0, 999),
    degree=st.sampled_from((1, 2, 5, 8, 9)),
    extra_points=st.sampled_from((0, 1, 3)),
    reverse=st.booleans(),
)
@settings(max_examples=10)
def test_a_built_in_potential_with_any_masses_agrees(
    potential: str, masses: str, size: int, seed: int, degree: int, extra_points: int, reverse: bool
) -> None:
    make = partial(on_vector_spaces.in_potential, potential, masses, size, seed)
    cell = Row(make, 0.05).by_gauss(degree, degree + extra_points)
    check(cell.backwards() if reverse else cell)


# ---------------------------------------------------------------- the general kernel


FUNCTION_FIELDS = ("function", "slopes", "potential", "gradient", "force")


def is_of_user(value: Any) -> bool:
    """Whether the value is a Python or Numba function and not an object of galvi."""
    return type(value).__name__ == "function" or hasattr(value, "py_func")


def untraceable(problem: galvi.Problem) -> galvi.Problem:
    """The problem with its user's functions wrapped so that tracing refuses them."""
    system: Any = problem.system
    functions = {name: getattr(system, name, None) for name in FUNCTION_FIELDS}
    wrapped = {name: opaque(value) for name, value in functions.items() if is_of_user(value)}
    return replace(problem, system=replace(system, check=False, **wrapped))


UNTRACED_ROWS = [name for name in ROWS if name.startswith(("V: ", "L: ", "body: ", "force: "))]
# units of ROUND_OFF, 2e-10: the derivatives are differences of function values
DIFFERENCED_GAP_BOUND = 2.0**20


@pytest.mark.slow_cases(
    but=[
        "V: compiled",
        "V: Python",
        "L: slopes of Python",
        "L: braked",
        "force: a chain",
        "body: a compiled gradient",
    ]
)
@pytest.mark.parametrize("name", UNTRACED_ROWS)
def test_functions_that_cannot_be_traced_agree_with_those_that_can(name: str) -> None:
    """The general kernel iterates by fixed points if forces depend on positions, else by Newton."""
    row = replace(ROWS[name], steps=2)
    traced, untraced = (
        row.by_gauss(2).run(),
        row.by_gauss(2).with_problem(untraceable(row.problem)).run(),
    )
    assert traced.success and untraced.success, (traced.status, untraced.status)
    assert (traced.engine, untraced.engine) == ("lanes", "general")
    assert traced.problem.system.untraced == "" != untraced.problem.system.untraced
    assert "potential_evaluations" not in traced.counts
    for part in ("q", "p", "v"):
        assert relative_gap(getattr(untraced, part), getattr(traced, part)) < DIFFERENCED_GAP_BOUND
    np.testing.assert_allclose(galvi.energy(untraced), galvi.energy(traced), rtol=0.0, atol=5e-10)


@pytest.mark.parametrize(
    ("make", "method", "step", "steps", "counted"), LEFT_TO_NEWTON.values(), ids=LEFT_TO_NEWTON
)
def test_what_iteration_does_not_solve_is_left_to_newtons_method_and_agrees(
    make: Any, method: galvi.Galerkin, step: float, steps: int, counted: bool
) -> None:
    problem = make()
    run, reference = (
        galvi.integrate(problem, method, step, steps, solver=solver)
        for solver in ("auto", "newton")
    )
    assert run.failed_step is None and run.counts["linear_solves"] > 0
    assert "newton_steps" not in reference.counts
    by_newton = run.counts.get("newton_steps", 0)
    assert (0 < by_newton <= steps) is counted
    for part in ("q", "p", "v"):
        # 130 at most, in units of ROUND_OFF
        assert relative_gap(getattr(run, part), getattr(reference, part)) < 500.0


# ---------------------------------------------------------------- planted faults

FAULT_FACTOR = 1.0 + 1e-9


def off_by_a_billionth(problem: galvi.Problem, field: str) -> galvi.Problem:
    """The problem with the first nonzero entry of a field of its system times FAULT_FACTOR."""
    values = np.array(getattr(problem.system, field), dtype=float)
    values.flat[np.flatnonzero(values)[0]] *= FAULT_FACTOR
    return replace(problem, system=replace(problem.system, **{field: values}))


def with_wrong_link(problem: galvi.Problem) -> galvi.Problem:
    chain = problem.system.function
    wrong = replace(chain, masses=chain.masses * np.array([1.0, FAULT_FACTOR]))
    return replace(problem, system=replace(problem.system, function=wrong))


FAULTS: dict[str, Callable[[galvi.Problem], galvi.Problem]] = {
    "double pendulum": with_wrong_link,
    "grain of 400 um, C = 0.44": lambda problem: galvi.problems.brownout(400e-6 * FAULT_FACTOR),
    "spherical pendulum": partial(off_by_a_billionth, field="inertia"),
    **{
        name: partial(off_by_a_billionth, field="masses")
        for name in (
            "planets and massless bodies",
            "frame: Kepler, even",
            "clock: three bodies",
            "time: three bodies",
        )
    },
    **{
        name: partial(off_by_a_billionth, field="mass")
        for name in ("Kepler", "frame: harmonic", "clock: Kepler, Sundman")
    },
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_coefficient_that_is_off_by_a_billionth_is_seen(name: str) -> None:
    cell = standard(name)
    faulty = cell.with_problem(FAULTS[name](cell.problem))
    assert excessive_gaps(cell.run(), cell.reference(), cell.row) == {}
    assert {"q", "p"} <= excessive_gaps(faulty.run(), cell.reference(), cell.row).keys()


@pytest.mark.parametrize("power", point_masses.POWERS)
def test_the_force_of_every_power_is_felt(power: float) -> None:
    cell = standard(f"force by r^{power}")
    problem = cell.problem
    without = cell.with_problem(replace(problem, system=replace(problem.system, forces=())))
    assert "q" in excessive_gaps(without.run(), cell.reference(), cell.row)


POSITION_TABLES, VELOCITY_TABLES = ("A", "beta", "b", "C"), ("b", "integral", "projection")
TABLES = {
    "Kepler": POSITION_TABLES,
    "V: driven, masses": POSITION_TABLES,
    "planets and massless bodies": POSITION_TABLES,
    "SymPy: elastic pendulum": VELOCITY_TABLES,
    "double pendulum": VELOCITY_TABLES,
    "spherical pendulum": VELOCITY_TABLES,
    "body in the plane": VELOCITY_TABLES,
    "forces: tides": VELOCITY_TABLES,
}


def with_wrong_entry(method: galvi.Galerkin, array: str) -> galvi.Galerkin:
    """The same method with one entry of an array of its table times FAULT_FACTOR."""
    rule = replace(method.rule, name=f"{method.rule.name}, wrong {array}")
    wrong = replace(method, rule=rule)
    values = getattr(method.table, array).copy()
    values[(1,) * values.ndim] *= FAULT_FACTOR
    vars(wrong)["table"] = replace(method.table, **{array: values})
    return wrong


@pytest.mark.parametrize(
    ("name", "array"), [(name, array) for name, arrays in TABLES.items() for array in arrays]
)
def test_an_entry_of_a_table_that_is_off_by_a_billionth_is_seen(name: str, array: str) -> None:
    cell = standard(name)
    faulty = replace(cell, method=with_wrong_entry(cell.method, array))
    assert excessive_gaps(faulty.run(), cell.reference(), cell.row) != {}


def test_a_space_of_slopes_that_is_off_by_a_billionth_is_seen() -> None:
    """Slopes outside the space enter only where there are more points than coefficients."""
    cell = ROWS["SymPy: elastic pendulum"].by_gauss(4, 6)
    faulty = replace(cell, method=with_wrong_entry(cell.method, "slope"))
    assert excessive_gaps(faulty.run(), cell.reference(), cell.row) != {}


def test_a_slip_of_one_lane_in_the_tables_for_fours_is_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tables_on_space = lagrangian.tables_on_space

    def slipped(table: Any, degrees: Any, form: Any) -> Any:
        arrays = tables_on_space(table, degrees, form)
        return arrays._replace(tables=np.roll(arrays.tables, form.lanes == 4, axis=1))

    monkeypatch.setattr(lagrangian, "tables_on_space", slipped)
    with pytest.raises(AssertionError):
        in_fours(standard("double pendulum"))
