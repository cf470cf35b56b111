"""One table of engines, problems, spaces, rules and options, whose cells agree with their oracles.

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
from tests.agreement.left_to_newton import LEFT
from tests.agreement.row import (
    ROUND_OFF,
    Cell,
    Row,
    check,
    gaps,
    in_short_steps,
    relative_gap,
    wide,
)
from tests.properties.ensemble_cases import starts
from tests.properties.lagrangians import opaque

pytestmark = pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
ROWS = on_vector_spaces.ROWS | on_groups.ROWS | point_masses.ROWS | frames_and_clocks.ROWS
KERNELS = (  # of each engine; the laws of others take long to compile
    "Kepler",
    "planets and massless bodies",
    "SymPy: elastic pendulum",
    "spherical pendulum",
    "frame: Kepler, even",
    "frame: harmonic",
    "clock: three bodies",
    "clock: Kepler, Sundman",
)
STANDARD = {"lanes": 5, "frame": 16, "clock": 8}


def standard(name: str) -> Cell:
    """The cell of a row by as many points as it has in one or two vectors."""
    row = ROWS[name]
    return row.by(16 if row.oracle is in_short_steps else STANDARD[row.engine])


# ---------------------------------------------------------------- every row

VECTORS = {  # degree and points of methods that take other code or other tables
    "lanes": ((5, 5), (4, 6), (9, 9)),
    "frame": ((16, 16), (20, 20)),
    "clock": ((8, 8), (5, 5)),
}


def cells() -> Iterator[Any]:
    for name, row in ROWS.items():
        in_time = row.engine == "clock" and row.oracle is in_short_steps
        pairs = VECTORS["frame" if in_time else row.engine]
        for degree, points in pairs if name in KERNELS else pairs[:1]:
            marks = [pytest.mark.slow] * row.slow
            yield pytest.param(name, degree, points, marks=marks)


@pytest.mark.parametrize(("name", "degree", "points"), list(cells()))
def test_every_problem_agrees(name: str, degree: int, points: int) -> None:
    check(ROWS[name].by(degree, points))


# ---------------------------------------------------------------- every method

SQUARE = (
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
        for k, name in enumerate(SQUARE)
        for stages in range(1, 25)
        if stages in (1, 8, 9, 24) or stages % len(SQUARE) == k
    ],
)
def test_every_number_of_stages_agrees(name: str, stages: int) -> None:
    row = ROWS[name]
    check(replace(row, step=row.step * min(1.0, 0.3 * stages)).by(stages))


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
OF_METHODS = (
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
        for i, name in enumerate(OF_METHODS)
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
IN_CHARTS = ((1, 1), (2, 3), (4, 4), (5, 6), (8, 8))  # degree and points


def in_charts() -> Iterator[Any]:
    for i, name in enumerate((*AT_REST, *MOVING)):
        for j, chart in enumerate(CHARTS):
            pairs = IN_CHARTS if name in MOVING else [IN_CHARTS[(i + j) % len(IN_CHARTS)]]
            yield from ((name, chart, *pair) for pair in pairs)


@pytest.mark.parametrize(("name", "chart", "degree", "points"), list(in_charts()))
def test_every_chart_agrees(name: str, chart: Any, degree: int, points: int) -> None:
    row = ROWS[name]
    check(replace(row, step=row.step * min(1.0, 0.5 * degree)).by(degree, points, chart=chart))


# ---------------------------------------------------------------- every option


def same_bits(run: Any, full: Any, rows: Any = slice(None)) -> None:
    """AssertionError unless a run has the states of some rows of another."""
    for part in ("q", "p", "t"):
        np.testing.assert_array_equal(getattr(run, part), getattr(full, part)[rows])


def agrees(cell: Cell, **options: Any) -> galvi.Trajectory:
    """The run with options, which has to agree with the oracle with the same ones."""
    run = cell.run(**options)
    assert run.success and run.engine == cell.row.engine, run.status
    assert wide(run, cell.truth(**options), cell.row) == {}
    return run


def from_later(cell: Cell) -> None:
    check(cell.of(replace(cell.problem, t0=cell.problem.t0 + 2.5)))


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


def in_both_ways(cell: Cell) -> Iterator[Cell]:
    """The cell, and in lanes that of more points than coefficients too."""
    yield cell
    if cell.row.engine == "lanes":
        yield cell.row.by(4, 6)


def resumed(cell: Cell) -> None:
    for variant in in_both_ways(cell):
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


AT_EVENTS = 1e5  # bound on gaps at events, 2e-11, in units of ROUND_OFF


def crossing(cell: Cell, **options: Any) -> galvi.Event:
    """An event where the first entry of a configuration passes what it is at 0.41 of the run."""
    run = cell.run()
    level = float(np.ravel(run(run.t[0] + 0.41 * (run.t[-1] - run.t[0])))[0])
    return galvi.Event(lambda q, v, t: np.ravel(q)[0] - level, **options)


def with_events(cell: Cell) -> None:
    """Found, ending the run, and changing its velocity."""
    full = cell.run()
    for options in ({}, {"terminal": True}, {"action": lambda q, v, t: (q, 0.99 * v)}):
        event = crossing(cell, **options)
        run, truth = cell.run(events=event), cell.truth(events=event)
        assert run.success and len(run.events) == len(truth.events) > 0
        assert (run.outcome.end is galvi.End.STOPPED_BY_EVENT) is ("terminal" in options)
        assert relative_gap(run.events.t, truth.events.t) < AT_EVENTS
        assert relative_gap(run.q[-1], truth.q[-1]) < AT_EVENTS
        assert relative_gap(run.t[-1], truth.t[-1]) < AT_EVENTS
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
    """Members with steps of their own: the first is the problem, and has the same bits alone."""
    problem, steps = cell.problem, cell.row.steps
    cells = [cell, *(cell.of(perturbed(problem, seed)) for seed in range(1, MEMBERS))]
    q, v = (np.array([getattr(member.problem, x) for member in cells]) for x in ("q0", "v0"))
    sizes = cell.step * np.where(np.arange(MEMBERS) < 7, 1.0, 0.5)
    many, single = (
        galvi.integrate_ensemble(problem, q[:n], v[:n], cell.method, sizes[:n], steps)
        for n in (MEMBERS, 1)
    )
    assert many.success.all(), many.status
    by_themselves = cell.row.engine == "frame" or getattr(problem.system, "forces", ())
    assert by_themselves or not any(outcome.notes for outcome in many.outcomes.values())
    for number in (0, 7):
        truth = replace(cells[number], step=float(sizes[number])).truth()
        for k, end in enumerate((truth.q[-1], truth.p[-1])):
            assert relative_gap(np.asarray(many[k])[number], end) < 4.0 * cell.row.bounds["qp"[k]]
            assert np.array_equal(np.asarray(many[k])[0], np.asarray(single[k])[0])


def members(cell: Cell) -> None:
    for variant in in_both_ways(cell):
        members_agree(variant)


# Degree and points of which AVX2's registers of four lanes leave none idle, where eight would.
FOURS = ((3, 4), (10, 10))
COUNTED = 200  # steps in which passes are counted


def in_fours(cell: Cell) -> None:
    """As on a processor whose registers have four lanes."""
    for degree, points in FOURS:
        variant = cell.row.by(degree, points)
        longer = replace(variant, row=replace(variant.row, steps=COUNTED))
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


MISSING = {"lanes": (), "frame": ("in_fours",), "clock": ("in_fours", "for_a_duration")}


def options() -> Iterator[tuple[str, str]]:
    """Rows with each option that they have: what runs in fours are lanes, and a clock's durations
    are rows of their own."""
    yield "forces: tides", "members"  # which lanes leave to single runs
    for name in KERNELS:
        for option in OPTIONS:
            if option not in MISSING[ROWS[name].engine]:
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

UNSTABLE = ("grain of 10 um", "grain of 50 um")  # backwards
ROBUST = [name for name in ROWS if not name.startswith((*UNSTABLE, "frame: the Moon"))]


def check_drawn(
    name: str,
    degree: int,
    extra_points: int,
    share: float,
    back: bool,
    seed: int,
    chart: Any,
    ask: Callable[[Cell], None] = check,
) -> None:
    row = ROWS[name]
    moving = {} if row.moving else {"chart": chart}
    if row.engine != "lanes":  # of which some take square methods alone
        degree, extra_points = max(degree, 16 if row.oracle is in_short_steps else 5), 0
    cell = replace(row, step=share * row.step).by(degree, degree + extra_points, **moving)
    cell = cell.of(perturbed(row.problem, seed))
    ask = ask if row.duration is None else check
    ask(cell.backwards() if back else cell)


OF_ANY_CELL = {
    "share": st.floats(0.2, 1.0),
    "back": st.booleans(),
    "seed": st.integers(0, 9999),
    "chart": st.sampled_from(CHARTS),
}


@given(
    name=st.sampled_from([name for name in ROBUST if not ROWS[name].slow]),
    degree=st.integers(2, 6),
    extra_points=st.integers(0, 2),
    **OF_ANY_CELL,
)
@settings(max_examples=60)
def test_drawn_cells_agree(**drawn: Any) -> None:
    check_drawn(**drawn)


@pytest.mark.slow(beside="test_drawn_cells_agree")
@given(
    name=st.sampled_from(ROBUST),
    degree=st.integers(2, 24),
    extra_points=st.integers(0, 12),
    ask=st.sampled_from((check, thinned, resumed, members_agree)),
    **OF_ANY_CELL,
)
@settings(max_examples=150)
def test_many_drawn_cells_agree(**drawn: Any) -> None:
    check_drawn(**drawn)


@given(
    potential=st.sampled_from(sorted(on_vector_spaces.POTENTIALS)),
    masses=st.sampled_from(sorted(on_vector_spaces.MASSES)),
    size=st.integers(0, 3),
    seed=st.integers(0, 999),
    degree=st.sampled_from((1, 2, 5, 8, 9)),
    extra_points=st.sampled_from((0, 1, 3)),
    back=st.booleans(),
)
@settings(max_examples=10)
def test_a_built_in_potential_with_any_masses_agrees(
    potential: str, masses: str, size: int, seed: int, degree: int, extra_points: int, back: bool
) -> None:
    make = partial(on_vector_spaces.in_potential, potential, masses, size, seed)
    cell = Row(make, 0.05).by(degree, degree + extra_points)
    check(cell.backwards() if back else cell)


# ---------------------------------------------------------------- the general kernel


FIELDS = ("function", "slopes", "potential", "gradient", "force")


def is_of_user(value: Any) -> bool:
    """Whether it is a function of Python or of Numba, and no value of galvi's."""
    return type(value).__name__ == "function" or hasattr(value, "py_func")


def called(problem: galvi.Problem) -> galvi.Problem:
    """A problem whose user's functions are wrapped so that tracing refuses them."""
    system: Any = problem.system
    functions = {name: getattr(system, name, None) for name in FIELDS}
    wrapped = {name: opaque(value) for name, value in functions.items() if is_of_user(value)}
    return replace(problem, system=replace(system, check=False, **wrapped))


CALLED = [name for name in ROWS if name.startswith(("V: ", "L: ", "body: ", "force: "))]
DIFFERENCED = 2.0**20  # units of ROUND_OFF, 2e-10: derivatives of a function that has none


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
@pytest.mark.parametrize("name", CALLED)
def test_functions_that_cannot_be_traced_agree_with_those_that_can(name: str) -> None:
    """In the general kernel: its own fixed-point iteration for forces of places, else Newton's."""
    row = replace(ROWS[name], steps=2)
    traced, blind = row.by(2).run(), row.by(2).of(called(row.problem)).run()
    assert traced.success and blind.success, (traced.status, blind.status)
    assert (traced.engine, blind.engine) == ("lanes", "general")
    assert traced.problem.system.untraced == "" != blind.problem.system.untraced
    assert "potential_evaluations" not in traced.counts
    for part in ("q", "p", "v"):
        assert relative_gap(getattr(blind, part), getattr(traced, part)) < DIFFERENCED
    np.testing.assert_allclose(galvi.energy(blind), galvi.energy(traced), rtol=0.0, atol=5e-10)


@pytest.mark.parametrize(("make", "method", "step", "steps", "counted"), LEFT.values(), ids=LEFT)
def test_what_iteration_does_not_solve_is_left_to_newtons_method_and_agrees(
    make: Any, method: galvi.Galerkin, step: float, steps: int, counted: bool
) -> None:
    problem = make()
    run, truth = (
        galvi.integrate(problem, method, step, steps, solver=solver)
        for solver in ("auto", "newton")
    )
    assert run.failed_step is None and run.counts["linear_solves"] > 0
    assert "newton_steps" not in truth.counts
    by_newton = run.counts.get("newton_steps", 0)
    assert (0 < by_newton <= steps) is counted
    for part in ("q", "p", "v"):
        assert relative_gap(getattr(run, part), getattr(truth, part)) < 500.0  # 130 of 2^-52


# ---------------------------------------------------------------- planted faults

WRONG = 1.0 + 1e-9


def off_by_a_billionth(problem: galvi.Problem, field: str) -> galvi.Problem:
    """The first entry of a field of the system that is not 0 is wrong."""
    values = np.array(getattr(problem.system, field), dtype=float)
    values.flat[np.flatnonzero(values)[0]] *= WRONG
    return replace(problem, system=replace(problem.system, **{field: values}))


def with_links(problem: galvi.Problem) -> galvi.Problem:
    chain = problem.system.function
    wrong = replace(chain, masses=chain.masses * np.array([1.0, WRONG]))
    return replace(problem, system=replace(problem.system, function=wrong))


FAULTS: dict[str, Callable[[galvi.Problem], galvi.Problem]] = {
    "double pendulum": with_links,
    "grain of 400 um, C = 0.44": lambda problem: galvi.problems.brownout(400e-6 * WRONG),
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
    faulty = cell.of(FAULTS[name](cell.problem))
    assert wide(cell.run(), cell.truth(), cell.row) == {}
    assert {"q", "p"} <= wide(faulty.run(), cell.truth(), cell.row).keys()


@pytest.mark.parametrize("power", point_masses.POWERS)
def test_the_force_of_every_power_is_felt(power: float) -> None:
    cell = standard(f"force by r^{power}")
    problem = cell.problem
    without = cell.of(replace(problem, system=replace(problem.system, forces=())))
    assert "q" in wide(without.run(), cell.truth(), cell.row)


PLACES, VELOCITIES = ("A", "beta", "b", "C"), ("b", "integral", "projection")
TABLES = {
    "Kepler": PLACES,
    "V: driven, masses": PLACES,
    "planets and massless bodies": PLACES,
    "SymPy: elastic pendulum": VELOCITIES,
    "double pendulum": VELOCITIES,
    "spherical pendulum": VELOCITIES,
    "body in the plane": VELOCITIES,
    "forces: tides": VELOCITIES,
}


def with_entry(method: galvi.Galerkin, array: str) -> galvi.Galerkin:
    """The same method with an entry of its table, of the second stage, that is wrong."""
    rule = replace(method.rule, name=f"{method.rule.name}, wrong {array}")
    wrong = replace(method, rule=rule)
    values = getattr(method.table, array).copy()
    values[(1,) * values.ndim] *= WRONG
    vars(wrong)["table"] = replace(method.table, **{array: values})
    return wrong


@pytest.mark.parametrize(
    ("name", "array"), [(name, array) for name, arrays in TABLES.items() for array in arrays]
)
def test_an_entry_of_a_table_that_is_off_by_a_billionth_is_seen(name: str, array: str) -> None:
    cell = standard(name)
    faulty = replace(cell, method=with_entry(cell.method, array))
    assert wide(faulty.run(), cell.truth(), cell.row) != {}


def test_a_space_of_slopes_that_is_off_by_a_billionth_is_seen() -> None:
    """What is outside it enters where there are more points than coefficients."""
    cell = ROWS["SymPy: elastic pendulum"].by(4, 6)
    faulty = replace(cell, method=with_entry(cell.method, "slope"))
    assert wide(faulty.run(), cell.truth(), cell.row) != {}


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
