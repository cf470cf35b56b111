"""Public calls with odd arguments return valid values or refuse in one sentence of galvi's own.

One or two arguments of each call, good otherwise, are odd: numbers of any kind and size, arrays of
other shapes and types, objects. Faults are an error of numpy, numba or Python below galvi, a
warning, NaN, a run called good that is not finite or whose energy is not constant, a file left
behind, and a call that does not end before the time-out.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import inspect
import json
import linecache
import traceback
from collections.abc import Callable, Mapping
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import galvi
from galvi.run.energies import conserves_energy

EXAMPLES_PER_CALL = 12
COUNTS = {"steps", "particles", "masses", "links", "points"}
LARGEST_QUICK_COUNT, LARGEST_COUNT = 100, 2**62  # counts in between are valid, and take long
LONGEST_REFUSAL = 2000  # characters of a refusal, with 64 numbers
# fraction of the energy's scale; a run that reports success changes its energy by less
ENERGY_CHANGE = 0.01
REFUSAL_ERRORS = ValueError, TypeError, OSError, ImportError, AttributeError, RuntimeError
GALVI_FOLDER = Path(galvi.__file__).parent

TINY, HUGE = float(np.nextafter(0.0, 1.0)), 10**400
NUMBERS = [
    0, -0.0, 1, -1, 2, 0.5, TINY, 1e300, -1e308, np.inf, np.nan, 2**31, 2**63, HUGE, True,
    np.float32(0.1), np.int8(-128), np.uint64(2**63), np.longdouble(1) / 3, np.bool_(True), 1j,
    Decimal("0.1"), Decimal("NaN"), Fraction(1, 3), np.datetime64("2000-01-01"),
]  # fmt: skip
OBJECTS = [
    None, "", "gauss", "\0", "ä" * 300, b"1", [], (), {}, set(), [[1.0], [2.0, 3.0]], [1, "a"],
    {"a": 1}, object(), type, lambda: None, lambda *x: x, range(3), Ellipsis, iter([1.0]),
    memoryview(b"1"), np.array(None), np.array("a"), np.array([1, "a"], dtype=object), np.zeros(0),
    np.ma.masked_array([1.0, 2.0], [True, False]), np.zeros((2, 2, 2)), np.eye(3), -np.eye(3),
    np.array([1 + 1j, 2.0]), np.array([True, False]), galvi, galvi.Polynomials,
    galvi.Polynomials(2), galvi.gauss(2), galvi.Rn(2), galvi.SO3(), galvi.SO3, galvi.Cayley(),
    galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2)), galvi.problems,
]  # fmt: skip
DTYPES = st.sampled_from(["f4", "f8", "i1", "i8", "u8", "?", "c16", "S2", "M8[s]"])
ARRAYS = arrays.arrays(DTYPES, arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4))
LISTS = st.lists(st.sampled_from(NUMBERS) | st.floats(), max_size=4)
ODD = st.sampled_from(NUMBERS) | st.sampled_from(OBJECTS) | ARRAYS | LISTS | st.integers()
ENTRIES = st.sampled_from([np.nan, np.inf, -1e308, 1e300, 0.0, -1.0, TINY])
CHANGES: list[Callable[[Any], Any]] = [
    lambda a: a[..., None],
    np.ravel,
    np.transpose,
    lambda a: a[None],
    lambda a: a[:-1],
    lambda a: a.astype(np.float32),
    lambda a: a.astype(int),
    lambda a: a[::-1],
    lambda a: np.concatenate([a, a]),
    lambda a: a * 1e200,
    lambda a: a * 1e-200,
    lambda a: a * 0,
]


def altered(good: Any) -> st.SearchStrategy[Any]:
    """A strategy: the good array with one odd entry, or of another shape, size or type."""
    array = np.atleast_1d(np.asarray(good, dtype=float))
    indices = np.arange(array.size).reshape(array.shape)
    with_odd_entry = st.builds(
        lambda index, entry: np.where(indices == index, entry, array),
        st.integers(0, array.size - 1),
        ENTRIES,
    )
    return with_odd_entry | st.sampled_from(CHANGES).map(lambda change: change(array))


def method(degree: int, points: int, **options: Any) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(points), **options)


KEPLER, TWO = galvi.problems.kepler(0.3), method(2, 2)
PROBLEMS = {
    "kepler": KEPLER,
    "oscillator": galvi.problems.harmonic_oscillator(),
    "planets": galvi.problems.outer_solar_system(),
    "body": galvi.problems.free_rigid_body(),
}


@functools.cache
def short_run(name: str) -> galvi.Trajectory:
    return galvi.integrate(PROBLEMS[name], TWO, 0.1, 5)


def energy_like(q: Any, v: Any = 0.0, t: float = 0.0) -> float:
    return float(np.sum(np.asarray(q) ** 2))


RUN = {"run": st.sampled_from([*PROBLEMS]).map(short_run)}
RUN_AT = {**RUN, "t": 0.005}
DEGREES, AXIS, INERTIA = st.integers(1, 8), [0.0, 0.6, 0.8], [1.0, 1.2, 1.4]
STEP = {
    "problem": st.sampled_from([*PROBLEMS.values()]),
    "method": st.sampled_from([TWO, method(3, 4), method(3, 3, chart=galvi.Exponential())]),
    "step": st.sampled_from([0.01, 0.1, -0.1]),
}
STEPS = {**STEP, "steps": DEGREES}
BETWEEN = {
    "problem": KEPLER,
    "method": STEP["method"],
    "q0": np.array([0.7, 0.0]),
    "q1": np.array([0.69, 0.1]),
    "h": 0.1,
}
MEMBERS = {
    "problem": KEPLER,
    "q0": np.array([[0.7, 0.0]] * 3),
    "v0": np.array([[0.0, 1.4]] * 3),
    "method": TWO,
    "step": 0.1,
    "steps": 3,
}
HINGE = galvi.Joint("hinge")
ROD = galvi.Link((HINGE,), 1.0, (0.0, 0.0, -1.0), 0.1)
MODEL = "<mujoco><worldbody><body><joint/><geom size='.1'/></body></worldbody></mujoco>"
AROUND = {"i": 1, "j": 0}

# Good values, or strategies that draw them, for parameters without a default or where another value
# than the default is used.
GOOD_ARGUMENTS: dict[str, Mapping[str, Any]] = {
    "Polynomials": {"degree": DEGREES},
    "Fourier": {"harmonics": 2},
    "PiecewisePolynomials": {"degree": DEGREES, "pieces": DEGREES},
    "PiecewiseHermite": {"pieces": DEGREES},
    "PolynomialFourier": {"degree": 3, "harmonics": 2},
    "ComponentPolynomials": {"degrees": (2, 3)},
    "gauss": {"points": DEGREES},
    "lobatto": {"points": 4},
    "radau": {"points": DEGREES},
    "newton_cotes": {"points": 5},
    "clenshaw_curtis": {"points": 6},
    "composite": {"rule": galvi.gauss(2), "pieces": 3},
    "Rule": {"name": "mine", "degree": 1, "exact_nodes": (0.5,), "exact_weights": (1.0,)},
    "Galerkin": {"space": galvi.Polynomials(2), "rule": galvi.gauss(3), "chart": galvi.Cayley()},
    "HarmonicFrame": {"stiffness": np.eye(2)},
    "Clock": {"function": energy_like},
    "theory": {"method": STEP["method"], "problem": PROBLEMS["oscillator"], "step": 0.1},
    "Rn": {"n": 3},
    "Product": {"factors": (galvi.SO3(), galvi.Rn(2))},
    "Canonical": {"mass": [1.0, 2.0], "potential": energy_like},
    "Lagrangian": {"function": lambda q, v: v @ v - q @ q, "group": galvi.Rn(2)},
    "NBody": {"masses": [1.0, 0.1, 0.0]},
    "RigidBody": {"inertia": INERTIA},
    "FreeBody": {"mass": 2.0, "inertia": INERTIA},
    "PlanarChain": {"masses": [1.0, 2.0], "lengths": [1.0, 0.5]},
    "Joint": {"type": "hinge"},
    "Link": {"joints": (HINGE,), "mass": 1.0, "centre": AXIS, "inertia": 0.1},
    "Multibody": {"links": (ROD,)},
    "UniformGravity": {"mass": 1.0, "centre": AXIS},
    "UniformField": {"force": AXIS},
    "RotorDrag": {"factor": 1.0, "drag_law": galvi.QuadraticDrag()},
    "SchillerNaumann": {"scale": 1.0},
    "Relativity": {"c": 100.0},
    "Oblateness": {"body": 0, "J2": 1e-3, "radius": 0.1},
    "Radiation": {"beta": [0.1, 0.2], "c": 100.0},
    "Drag": {"coefficients": [0.1, 0.2]},
    "Tides": {"body": 1, "k2": 0.3, "radius": 0.1, "lag": 0.01},
    "PowerLaw": {"source": 0, "strength": 1e-3, "power": -2.0},
    "Force": {"function": lambda q: -q},
    "Problem": {"system": KEPLER.system, "q0": [0.7, 0.0], "v0": [0.0, 1.4]},
    "integrate": STEPS,
    "integrate_many": {"problems": [KEPLER], "method": TWO, "step": 0.1, "threads": 1},
    "integrate_ensemble": MEMBERS,
    "StatesAt": {"times": [0.1, 0.2]},
    "Events": {"events": galvi.events.section(lambda q, v, t: q[1]), "at_most": 2},
    "Histogram": {"quantity": energy_like, "edges": [0.0, 1.0, 2.0]},
    "recommend": {
        "problem": PROBLEMS["oscillator"],
        "error": 1e-4,
        "duration": 1.0,
        "by": "evaluations",
        "degrees": (4,),
    },
    "resume": {**RUN, "steps": DEGREES},
    "save": {**RUN, "path": "run.npz"},
    "load": {"path": "run.npz"},
    "states_at": {**RUN, "times": [0.005, 0.01]},
    "energy": RUN_AT,
    "momentum_map": RUN_AT,
    "linear_momentum": RUN_AT,
    "momentum_balance": RUN,
    "orbital_elements": {**RUN, "centre": 0},
    "heliocentric": {**RUN, "centre": 0},
    "rotations": RUN_AT,
    "orthogonality_defect": RUN_AT,
    "nearest_rotation": {"matrix": np.eye(3)},
    "action": RUN,
    "discrete_lagrangian": BETWEEN,
    "discrete_legendre_transforms": BETWEEN,
    "round_trip_error": STEPS,
    "step_derivative": STEP,
    "symplecticity_defect": STEP,
    "cite": RUN,
    "from_rebound": {"source": None},
    "from_mujoco": {"model": MODEL},
    "find_events": {**RUN, "events": galvi.events.plane_crossing((0.0, 1.0))},
    "Event": {"function": lambda q, v, t: q[0]},
    "apsis": {"i": 1, "about": 0},
    "closest_approach": AROUND,
    "within": {**AROUND, "distance": 5.0},
    "transit": {**AROUND, "observer": AXIS},
    "plane_crossing": {"normal": AXIS},
    "angle": {"joint": 0, "value": 0.5},
    "section": {"function": lambda q, v, t: q[0]},
}
RETURNED = {"Citation", "End", "Ensemble", "Found", "Judged", "MomentumBalance", "OrbitalElements",
           "Outcome", "Recommendation", "Theory", "Trajectory"}  # fmt: skip
SLOW = {"judge", "convergence"}  # their refusals are in tests/users/refusals and test_convergence
NEVER_ODD = {"self", "progress", "executor", "folder", "path", "name"}  # names of parameters
CALLS: dict[str, tuple[Callable[..., Any], Mapping[str, Any]]] = {
    name: (getattr(module, name), GOOD_ARGUMENTS.get(name, {}))
    for module in (galvi, galvi.problems, galvi.events)
    for name in module.__all__
    if callable(getattr(module, name)) and name not in RETURNED | SLOW
}
CALLS["run(t)"] = galvi.Trajectory.__call__, {"self": RUN["run"], "t": 0.005}
CALLS["run.velocity"] = galvi.Trajectory.velocity, {"self": RUN["run"], "t": 0.005}
CALLS["run.to_scipy"] = galvi.Trajectory.to_scipy, {"self": RUN["run"]}
CALLS["run.to_frame"] = galvi.Trajectory.to_frame, {"self": RUN["run"]}


def odd_call(data: st.DataObject, call: Callable[..., Any], good: Mapping[str, Any]) -> Any:
    """The call with good arguments, of which one or two are replaced by odd ones that are drawn."""
    parameters = inspect.signature(call).parameters.values()
    plain_types = (int, float, str, tuple, type(None))
    values = {
        parameter.name: parameter.default
        for parameter in parameters
        if isinstance(parameter.default, plain_types)
    }
    values |= good
    may_be_odd = sorted(values.keys() - NEVER_ODD)
    odd = (
        data.draw(st.sets(st.sampled_from(may_be_odd), min_size=1, max_size=2))
        if may_be_odd
        else set()
    )
    for name, value in values.items():
        if isinstance(value, st.SearchStrategy):
            value = data.draw(value)
        if name in odd:
            value = data.draw(altered(value) | ODD if is_numeric(value) else ODD)
        assume(name not in COUNTS or not is_long(value))
        values[name] = value
    return functools.partial(call, **values)


def is_numeric(value: Any) -> bool:
    numeric_types = (int, float, tuple, list, np.ndarray)
    return (
        isinstance(value, numeric_types)
        and np.size(value) > 0
        and np.asarray(value).dtype.kind in "fi"
    )


def is_long(count: Any) -> bool:
    return (
        isinstance(count, int | float | np.number)
        and LARGEST_QUICK_COUNT < abs(count) <= LARGEST_COUNT
    )


def fault(call: Any) -> str:
    """A description of the fault of a call; "" where it returns valid values or refuses."""
    run = call.keywords.get("run", call.keywords.get("self"))
    try:
        returned = call()
    except Exception as error:
        return "" if is_refusal(error) else "".join(traceback.format_exception(error))
    if isinstance(returned, galvi.Trajectory):
        return fault_of_run(returned)
    if isinstance(run, galvi.Trajectory) and not run.success:
        return ""  # quantities of a run are NaN after its failure
    if isinstance(returned, galvi.Recommendation) and not returned.reached:
        return ""
    values = vars(returned).values() if dataclasses.is_dataclass(returned) else [returned]
    numbers = [x for x in values if isinstance(x, float | np.ndarray)]
    wrong = any(np.isnan(x).any() for x in numbers if np.asarray(x).dtype.kind == "f")
    return f"NaN in the result: {returned}" if wrong else ""


def fault_of_run(run: galvi.Trajectory) -> str:
    if not run.status.endswith("."):
        return f"the status is no sentence: {run.status}"
    if not run.success:
        return "" if run.failed_step is not None else f"no failed step: {run.status}"
    if not all(np.isfinite(x).all() for x in (run.q, run.p, run.t)):
        return f"not finite, and called good: {run.status}"
    if run.status == "Completed." and conserves_energy(run.problem.system):
        energies = galvi.energy(run)
        twice_kinetic = np.abs(run.p * run.v).reshape(len(energies), -1).sum(axis=1)
        if np.ptp(energies) > ENERGY_CHANGE * (np.abs(energies).max() + twice_kinetic.max()):
            return f"energy from {energies.min():.3g} to {energies.max():.3g}, and called good"
    return ""


def is_refusal(error: Exception) -> bool:
    """Whether a `raise` of galvi raised the error, with one sentence of limited length."""
    *_, innermost = traceback.extract_tb(error.__traceback__)
    raised = "raise" in linecache.getline(innermost.filename, innermost.lineno or 0)
    text, in_galvi = str(error), GALVI_FOLDER in Path(innermost.filename).parents
    sentence = text.endswith((".", "?")) and "\n" not in text and len(text) <= LONGEST_REFUSAL
    return isinstance(error, REFUSAL_ERRORS) and in_galvi and raised and sentence


def property_of(strategy: Any, examples: int) -> Any:
    """A decorator: calling the function runs it on `examples` values drawn from the strategy."""
    return lambda check: settings(
        max_examples=examples,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )(given(strategy)(check))


@pytest.fixture(autouse=True)
def empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", CALLS)
def test_odd_arguments_give_what_holds_or_a_refusal(name: str, empty_folder: Path) -> None:
    @property_of(st.data(), EXAMPLES_PER_CALL)
    def check(data: st.DataObject) -> None:
        with np.errstate(all="ignore"):
            call = odd_call(data, *CALLS[name])
        assert fault(call) == "", call

    saved = empty_folder / "run.npz"
    galvi.save(short_run("kepler"), saved)
    check()
    assert [*empty_folder.iterdir()] == [saved]


def damaged(data: st.DataObject, content: bytes) -> bytes:
    """Bytes cut short, or with some changed, taken out or put in."""
    start = data.draw(st.integers(0, len(content)))
    end = start + data.draw(st.sampled_from([0, 1, 20, len(content)]))
    return content[:start] + data.draw(st.binary(max_size=8)) + content[end:]


@pytest.mark.parametrize("name", ["run.npz", "model.xml"])
def test_a_damaged_file_is_refused_or_read(name: str, empty_folder: Path) -> None:
    run, path = short_run("planets"), empty_folder / name
    if name == "model.xml":
        pytest.importorskip("mujoco")
        path.write_text(MODEL)
    else:
        galvi.save(run, path)
    content, read = path.read_bytes(), galvi.load if name == "run.npz" else galvi.from_mujoco

    @property_of(st.data(), 5 * EXAMPLES_PER_CALL)
    def check(data: st.DataObject) -> None:
        path.write_bytes(damaged(data, content))
        assert fault(functools.partial(read, path)) == "", path.read_bytes()
        if name == "run.npz":
            with contextlib.suppress(ValueError, OSError):
                loaded = galvi.load(path)
                assert all(np.array_equal(getattr(loaded, x), getattr(run, x)) for x in "tqp")

    check()


def with_facts(**changes: Any) -> Callable[[dict[str, Any]], dict[str, Any]]:
    def changed(arrays: dict[str, Any]) -> dict[str, Any]:
        facts = json.loads(str(arrays["facts"])) | changes
        present = {name: value for name, value in facts.items() if value is not None}
        return {**arrays, "facts": np.array(json.dumps(present))}

    return changed


MISFIT = "must be a run written by galvi.save; some of it is missing or does not fit"
ODD_FILES: dict[str, tuple[str, Callable[[dict[str, Any]], dict[str, Any]]]] = {
    "times in falling order": (MISFIT, lambda a: {**a, "t": a["t"][::-1]}),
    "fewer configurations than times": (MISFIT, lambda a: {**a, "q": a["q"][:3]}),
    "a state of another shape": (MISFIT, lambda a: {**a, "state": a["state"][:, :1]}),
    "stages of another shape": (MISFIT, lambda a: {**a, "stages": a["stages"][:1]}),
    "a state of whole numbers": (MISFIT, lambda a: {**a, "state": a["state"].astype(int)}),
    "bases of another shape": (MISFIT, lambda a: {**a, "bases": a["bases"][:, :1][:3]}),
    "curves of another shape": (
        MISFIT,
        lambda a: {**a, "coefficients": a["coefficients"][:, :1][:3]},
    ),
    "no solver state": (MISFIT, lambda a: {x: a[x] for x in a if x != "solver_state"}),
    "a step of 0": (MISFIT, with_facts(step=0.0)),
    "no counts": (MISFIT, with_facts(counts=None)),
    "another format": (r"must have format \d+; received format 3. Run ", with_facts(version=3)),
}


@pytest.mark.parametrize("odd", ODD_FILES)
@pytest.mark.parametrize("name", ["kepler", "body"])
def test_a_file_whose_parts_do_not_fit_is_refused(name: str, odd: str, empty_folder: Path) -> None:
    message, change = ODD_FILES[odd]
    galvi.save(short_run(name), "run.npz")
    with np.load("run.npz") as file:
        arrays = dict(file)
    np.savez("run.npz", **change(arrays))
    with pytest.raises(ValueError, match=message):
        galvi.load("run.npz")


FORMS: dict[str, Callable[[Any], Any]] = {
    "lists": np.ndarray.tolist,
    "Fortran": np.asfortranarray,
    "a view": lambda a: np.repeat(a, 2, 0)[::2],
    "longdouble": lambda a: a.astype(np.longdouble),
}


@pytest.mark.parametrize("form", FORMS)
def test_the_same_numbers_in_another_form_give_the_same_bits(form: str) -> None:
    planets, same_numbers, run = PROBLEMS["planets"], FORMS[form], short_run("planets")
    problem = galvi.Problem(planets.system, same_numbers(planets.q0), same_numbers(planets.v0))
    same_run = galvi.integrate(problem, TWO, 0.1, 5)
    assert same_run.q.tobytes() == run.q.tobytes() and same_run.p.tobytes() == run.p.tobytes()
    times = np.array([0.11, 0.23])
    states, same = galvi.states_at(run, times), galvi.states_at(run, same_numbers(times))
    assert np.array_equal(states, same)


def raising(error: Exception) -> None:
    raise error


FAULTS: dict[str, tuple[Callable[[], Any], str]] = {
    "another package's error": (lambda: raising(ValueError("It is wrong.")), "It is wrong"),
    "an error of Python": (lambda: galvi.Rn(2).hat, "has no attribute"),
    "NaN": (lambda: np.array([1.0, np.nan]), "NaN in the result"),
    "energy": (
        lambda: dataclasses.replace(short_run("kepler"), q=0.5 * np.ones((6, 2)) + np.eye(6, 2)),
        "and called good",
    ),
    "a status": (lambda: dataclasses.replace(short_run("kepler"), status="ok"), "no sentence"),
    "a failure": (lambda: dataclasses.replace(short_run("kepler"), success=False), "failed step"),
}


@pytest.mark.parametrize("planted", FAULTS)
def test_a_planted_fault_is_seen(planted: str) -> None:
    call, message = FAULTS[planted]
    assert message in fault(functools.partial(call))
    assert fault(functools.partial(galvi.gauss, -1)) == ""
