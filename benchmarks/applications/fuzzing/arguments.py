"""Arguments: good ones for each parameter of a public function, and odd ones for any of them."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy.spatial.transform import Rotation

import galvi

TINY = np.nextafter(0.0, 1.0)
NUMBERS = [
    0,
    -0.0,
    1,
    -1,
    2,
    3,
    0.5,
    1e-300,
    TINY,
    1e300,
    -1e308,
    float("inf"),
    float("-inf"),
    float("nan"),
    2**31,
    2**63,
    2**70,
    -(2**63),
    10**400,
    True,
    False,
    np.float32(0.1),
    np.int8(-128),
    np.uint64(2**63),
    np.longdouble(1) / 3,
    np.bool_(True),
    1j,
    1 + 0j,
    Decimal("0.1"),
    Decimal("NaN"),
    Fraction(1, 3),
    np.float64("nan"),
    np.datetime64("2000-01-01"),
]
OBJECTS = [
    None,
    "",
    "1",
    "gauss",
    "\0",
    "ä" * 300,
    b"1",
    [],
    (),
    {},
    set(),
    [[]],
    [[1.0], [2.0, 3.0]],
    [None],
    [1, "a"],
    {"a": 1},
    object(),
    type,
    len,
    lambda: None,
    lambda *given: given,
    range(3),
    slice(1, 2),
    Ellipsis,
    NotImplemented,
    datetime(2000, 1, 1),
    iter([1.0, 2.0]),
    memoryview(b"12"),
    np.array(None),
    np.array("a"),
    np.array([1, "a"], dtype=object),
    np.ma.masked_array([1.0, 2.0], [True, False]),
    np.zeros((0,)),
    np.zeros((3, 0)),
    np.zeros((2, 2, 2)),
    np.eye(3),
    -np.eye(3),
    np.eye(4),
    2 * np.eye(3),
    np.array([1 + 1j, 2.0]),
    np.array([True, False]),
    Rotation.identity(),
    galvi,
    galvi.Polynomials,
    galvi.Polynomials(2),
    galvi.gauss,
    galvi.gauss(2),
    galvi.Rn(2),
    galvi.SO3(),
    galvi.SO3,
    galvi.Cayley(),
    galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2)),
    galvi.problems.kepler(0.3),
    galvi.problems,
]

DTYPES = st.one_of(
    arrays.floating_dtypes(),
    arrays.integer_dtypes(),
    arrays.boolean_dtypes(),
    arrays.complex_number_dtypes(),
    arrays.byte_string_dtypes(),
    arrays.datetime64_dtypes(),
)
ARRAYS = arrays.arrays(DTYPES, arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4))
NESTED = st.recursive(
    st.sampled_from(NUMBERS) | st.floats(), lambda items: st.lists(items, max_size=4), max_leaves=9
)
ODD = (
    st.sampled_from(NUMBERS)
    | st.sampled_from(OBJECTS)
    | ARRAYS
    | NESTED
    | st.floats()
    | st.integers()
)


def spoilt(good: Any) -> st.SearchStrategy[Any]:
    """Arrays like a good one with another shape, or one entry that is odd."""
    array = np.asarray(good, dtype=float)
    entries = st.sampled_from([float("nan"), float("inf"), -1e308, 1e300, 0.0, -1.0, TINY])
    places = st.integers(0, max(array.size - 1, 0))

    def replaced(place: int, entry: float) -> Any:
        changed = array.copy()
        if changed.size:
            changed.flat[place] = entry
        return changed

    shapes: list[Callable[[Any], Any]] = [
        lambda a: a[..., None],
        np.ravel,
        np.transpose,
        lambda a: a[None],
        lambda a: a[:-1],
        np.asfortranarray,
        lambda a: a.astype(np.float32),
        lambda a: a.astype(int),
        lambda a: a.tolist(),
        lambda a: a[::-1],
        lambda a: np.concatenate([a, a]),
        lambda a: a * 1e200,
        lambda a: a * 1e-200,
        lambda a: a * 0,
    ]
    other = st.sampled_from(shapes).map(lambda change: change(array) if array.ndim else array)
    return st.builds(replaced, places, entries) | other


SMALL = {
    name: getattr(galvi.problems, name)(*given)
    for name, given in {
        "harmonic_oscillator": (),
        "kepler": (0.4,),
        "double_pendulum": (),
        "elastic_pendulum": (),
        "free_rigid_body": (),
        "heavy_top": (),
        "henon_heiles": (),
        "outer_solar_system": (),
        "pendulum_3d": (),
        "free_body_se3": (),
        "skew_arm": (),
    }.items()
}
PROBLEMS = st.sampled_from(list(SMALL.values()))
SPACES = st.one_of(
    st.integers(1, 8).map(galvi.Polynomials),
    st.builds(galvi.PiecewisePolynomials, st.integers(1, 3), st.integers(1, 3)),
    st.builds(galvi.Fourier, st.integers(1, 3)),
    st.integers(1, 3).map(galvi.PiecewiseHermite),
)
RULES = st.one_of(
    st.integers(1, 9).map(galvi.gauss),
    st.integers(2, 8).map(galvi.lobatto),
    st.integers(2, 6).map(galvi.newton_cotes),
    st.integers(2, 8).map(galvi.clenshaw_curtis),
    st.integers(1, 6).map(galvi.radau),
)
CHARTS = st.sampled_from(
    [
        galvi.Cayley(),
        galvi.Exponential(),
        galvi.ModifiedRodrigues(),
        galvi.KeplerFrame(),
        galvi.HarmonicFrame(),
    ]
)


def pace(q: Any) -> Any:
    """A clock of any configuration, which is traced."""
    flat = q.reshape(-1)
    return 1.0 / (1.0 + flat[0] * flat[0])


def branching(q: Any) -> float:
    """A clock that cannot be traced, and stops for some."""
    return 1.0 if q.reshape(-1)[0] > 0.0 else 2.0 + float(q.reshape(-1)[0])


CLOCKS = st.one_of(
    st.just(galvi.DynamicalTime()),
    st.sampled_from([0.5, 1.0, 1.5, 2.0, 9.0]).map(galvi.Sundman),
    st.sampled_from([pace, branching, lambda q: float("nan"), lambda q: "1", len])
    .map(galvi.Clock),
)  # fmt: skip
MEETING = [
    galvi.Problem(galvi.NBody(masses), q, v, name=name)
    for name, masses, q, v in (
        ("Burrau", [3.0, 4.0, 5.0], [[1, 3], [-2, -1], [1, -1]], np.zeros((3, 2))),
        ("head on", [1.0, 1.0], [[1, 0, 0], [-1, 0, 0]], np.zeros((2, 3))),
        ("massless", [1.0, 0.5, 0.0], [[0, 0], [1, 0], [0, 2]], [[0, -0.4], [0, 0.8], [0.7, 0]]),
        ("light", [1.0, 1e-3, 1e-9], [[0, 0], [1, 0], [1.01, 0]], [[0, 0], [0, 1], [0, 1.3]]),
    )
]
METHODS = st.integers(1, 6).flatmap(
    lambda s: st.sampled_from(
        [galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(points)) for points in (s, s + 1)]
    )
)
STEPS = st.sampled_from([0.01, 0.1, -0.1, 0.3])
COUNTS = st.integers(1, 8)


def a_run(problem: Any, method: Any, step: float, steps: int) -> Any:
    """A run to ask something of; None where the pair is refused."""
    try:
        return galvi.integrate(problem, method, step, steps)
    except ValueError:
        return None


RUNS = st.builds(a_run, PROBLEMS, METHODS, STEPS, COUNTS).filter(lambda run: run is not None)
