"""Lagrangians from SymPy: input, code, kinks."""

import os
import subprocess
import sys

import mpmath
import numpy as np
import pytest
import sympy

import galvi
from galvi.tracing import code as symbolic_code
from galvi.tracing import kinks, lane_law
from tests.properties.symbolic_letters import FOUR, FREE, c, from_sympy, k, m, u, w, x, y


def test_coordinates_and_forces_in_a_matrix_and_parameters_of_sympy_are_taken():
    L = m * (u**2 + w**2) / 2 - k * x**2
    lists = from_sympy(L, [x, y], [u, w], parameters={m: np.sqrt(2.0), k: 0.5}, force=[-u, 0])
    columns = map(sympy.Matrix, ([x, y], [u, w]))
    numbers = {m: sympy.sqrt(2), k: sympy.Rational(1, 2)}
    matrices = from_sympy(L, *columns, parameters=numbers, force=sympy.Matrix([-u, 0]))
    assert matrices.function == lists.function
    assert matrices.force == lists.force and repr(lists.force) == "[-u, 0]"
    assert matrices.force(np.ones(2), np.ones(2), 0.0).tolist() == [-1.0, 0.0]


def test_a_piecewise_that_does_not_say_what_holds_elsewhere_is_not_defined_there():
    half = sympy.Piecewise((x**2, x > 0))
    for system in (from_sympy(FREE - half, x, u), from_sympy(FREE, x, u, force=half)):
        assert galvi.integrate(galvi.Problem(system, [1.0], [0.0]), FOUR, 0.1, 2).success
        with pytest.raises(ValueError, match=r"finite.*at the start"):
            galvi.integrate(galvi.Problem(system, [-1.0], [0.0]), FOUR, 0.1, 1)


def test_a_missing_sympy_is_a_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "sympy", None)
    with pytest.raises(ImportError, match=r"by SymPy need the package sympy: .* Install sympy\."):
        from_sympy(FREE, x, u)


def test_galvi_does_not_import_sympy():
    command = [sys.executable, "-c", "import sys, galvi; sys.exit('sympy' in sys.modules)"]
    assert subprocess.run(command).returncode == 0


def test_parameters_are_numbers_of_the_system_and_not_of_the_code():
    unit, doubled = (
        from_sympy(m * u**2 / 2 - k * x**2, x, u, parameters={m: 1.0, k: stiffness})
        for stiffness in (1.0, 2)
    )
    renamed = from_sympy(c * w**2 / 2 - m * y**2, y, w, parameters={c: 1.0, m: 1.0})
    assert unit.function.source == doubled.function.source
    assert repr(unit.function) == "-k*x**2 + m*u**2/2" and repr(unit.function) in repr(unit)
    assert unit.function.slopes(np.array([1.0]), np.array([2.0])).tolist() == [2.0, -2.0]
    assert doubled.function.slopes(np.array([1.0]), np.array([2.0])).tolist() == [2.0, -4.0]
    assert renamed.function.slopes(np.array([1.0]), np.array([2.0])).tolist() == [2.0, -2.0]


SOURCE = """
import numpy, sympy, galvi
a, b, u, v, g = sympy.symbols("a b u v g")
L = (u**2 + v**2 + u*v*sympy.cos(a - b))/2 + g*(sympy.cos(a) + sympy.sin(b)**2)
system = galvi.Lagrangian.from_sympy(L, [a, b], [u, v], parameters={g: 9.81})
print(system.function.source)
law = system.lagrangian_kernel().function
law(numpy.ones(2), numpy.ones(2), 0.0, numpy.ones(1), numpy.empty((2, 2)))
print("from disk", sum(law.stats.cache_hits.values()))
"""


@pytest.mark.slow(beside="test_parameters_are_numbers_of_the_system_and_not_of_the_code")
def test_the_code_is_the_same_in_every_process_and_compiled_in_the_first_only():
    def code_and_cache_hits(seed):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        command = [sys.executable, "-c", SOURCE]
        completed = subprocess.run(
            command, capture_output=True, text=True, check=True, env=environment
        )
        return completed.stdout.rpartition("from disk ")

    first, second = code_and_cache_hits("1"), code_and_cache_hits("2")
    assert first[0] == second[0] and "def law_" in first[0]
    assert int(second[2]) == 1


def test_constants_of_any_order_have_a_law():
    L = (k - m) ** sympy.Rational(7, 3) * u**2 / 2 - x**2 / 2
    problem = galvi.Problem(from_sympy(L, x, u, parameters={m: 1.0, k: 3.0}), [0.4], [0.5])
    run = galvi.integrate(problem, FOUR, 0.05, 2)
    assert run.success and run.counts["linear_solves"] == 0


def test_nowhere_to_keep_the_code_is_no_reason_to_fail(monkeypatch):
    def refused(function):
        raise RuntimeError("no folder")

    text = symbolic_code.source({"law": ("q, v, t, c, out", ["out[0, 0] = sin(q[0]) + 0.0625"])})
    monkeypatch.setattr(symbolic_code, "KernelCache", refused)
    assert symbolic_code._cached_file(text) is None
    out = np.zeros((1, 1))
    symbolic_code.functions(text)["law"].py_func([0.0], [0.0], 0.0, [], out)
    assert out[0, 0] == 0.0625


def test_code_that_was_not_used_for_longest_goes(tmp_path):
    for i in range(symbolic_code.MAX_CACHED_EXPRESSIONS + 3):
        path = tmp_path / f"{i}" / "expression.source"
        path.parent.mkdir()
        path.touch()
        os.utime(path, (i, i))
    symbolic_code._delete_old_expressions(tmp_path)
    remaining = sorted(int(path.name) for path in tmp_path.iterdir())
    assert remaining == list(range(3, symbolic_code.MAX_CACHED_EXPRESSIONS + 3))


@pytest.mark.parametrize(
    "V",
    [
        sympy.asin(x / 9) * sympy.atan2(x, 2),
        sympy.tanh(x) ** 2 + sympy.acosh(3 + x),
        sympy.erf(x) + sympy.log(2 + x, 10),
        sympy.pi * sympy.E**x / 3 + x**10 / 10**12,
        sympy.Min(x, x + 1, x + 2) ** 2,
        sympy.sign(x) * sympy.Abs(x) ** 3,
    ],
    ids=str,
)
def test_the_compiled_slopes_are_those_of_mpmath(V):
    system = from_sympy(FREE - V, x, u)
    slopes = np.empty((2, 1))
    for position in (0.3, -0.8):
        law = system.lagrangian_kernel().function
        law(np.array([position]), np.array([0.5]), 0.0, np.zeros(0), slopes)
        slope = mpmath.diff(sympy.lambdify(x, V, "mpmath"), mpmath.mpf(position))
        assert slopes[0, 0] == 0.5 and slopes[1, 0] == pytest.approx(-float(slope), rel=1e-13)


@pytest.mark.parametrize(
    ("line", "in_lanes"),
    [("sin(q[0])", True), ("hypot(q[0], 1.0)", False), ("1.0 if q[0] > 0.0 else 2.0", False)],
)
def test_lanes_have_no_code_for_a_branch_or_a_function_that_they_lack(line, in_lanes):
    assert bool(lane_law.function_lines("law(q)", [], [line])) == in_lanes


KINKS = [
    (sympy.Abs(x), "x changes its sign: its first derivatives jump"),
    (sympy.Abs(x) ** sympy.Rational(3, 2), "second derivatives have no bound"),
    (k * sympy.Max(0, x - 1) ** 2, "1 - x changes its sign: its second derivatives jump"),
    (sympy.Heaviside(x - 1) * x, "x - 1 changes its sign: its values jump"),
    (sympy.Piecewise((x**2, x < 0), (2 * x**2, True)), "second derivatives jump"),
]
SMOOTH = [
    10**6 * sympy.Abs(x) ** 3,
    sympy.Abs(x) ** sympy.Rational(5, 2),
    sympy.Max(0, x - 1) ** 3,
    sympy.Piecewise((x**4, x < 0), (2 * x**4, True)),
    sympy.Abs(k) * x**2,
    sympy.sqrt(x**2 + 1),
]


@pytest.mark.parametrize(("V", "sentence"), KINKS)
def test_a_lagrangian_that_is_not_twice_differentiable_is_named(V, sentence):
    with pytest.warns(UserWarning, match=f"not twice differentiable where .*{sentence}"):
        from_sympy(FREE - V, x, u, parameters={k: 3.0})


@pytest.mark.parametrize("V", SMOOTH)
def test_one_that_is_twice_differentiable_across_its_branches_is_taken(V):
    system = from_sympy(FREE - V, x, u, parameters={k: 3.0})
    assert kinks.check_start(system.function, np.zeros(1), np.ones(1), 0.0) is None


@pytest.mark.parametrize(
    ("V", "on_kink", "beside_kink", "t0"),
    [
        (sympy.Max(0, x - 1) ** 2, (1.0, 0.0), (1.01, 0.0), 0.0),
        (sympy.Abs(x - k), (2.0**-30, 0.0), (1.001 * 2.0**-30, 0.0), 0.0),
        (sympy.Abs(x), (0.0, 1e9), (5e-7, 1e9), 0.0),
        (sympy.Abs(x), (0.0, 1.0), (5e-7, 1.0), 2.4e6),
    ],
)
def test_a_start_on_a_kink_is_refused_and_one_beside_it_is_not(V, on_kink, beside_kink, t0):
    """The kink may lie at a coordinate of any size, whatever the size of the others."""
    with pytest.warns(UserWarning):
        system = from_sympy((u**2 + w**2) / 2 - V, [x, y], [u, w], parameters={k: 2.0**-30})
    with pytest.raises(ValueError, match=r"not twice differentiable at the start, where .*x"):
        galvi.integrate(galvi.Problem(system, on_kink, [1.0, 0.0], t0), FOUR, 0.1, 1)
    assert kinks.check_start(system.function, np.array(beside_kink), np.ones(2), t0) is None
