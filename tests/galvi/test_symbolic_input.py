"""What SymPy may give as a Lagrangian: what is taken, and what is refused in a sentence."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import galvi

pytest.importorskip("sympy")

import sympy

from tests.galvi.symbolic_letters import FOUR, FREE, k, m, made, t, u, w, x, y

f = sympy.Function("f")
real = sympy.Symbol("t", real=True)
th = sympy.Function("th")(t)
REFUSED = [
    (lambda: made(m * FREE - k * x, x, u), ValueError, r"received k, m\. Give parameters={k: "),
    (lambda: made(FREE * sympy.Symbol("m"), x, u, parameters={m: 1.0}), ValueError,
     "received m. The given m has other assumptions: use one symbol throughout"),
    (lambda: made(FREE - x * t, x, u), ValueError, r"Give parameters={t: ...}, or t=t where it"),
    (lambda: made(sympy.Function("th")(real).diff(real) ** 2, th), ValueError,
     r"received Derivative\(th\(t\), t\)\. .* The given Derivative\(th\(t\), t\) has"),
    (lambda: made(FREE, th, t=real), ValueError, "with t = t. The given t has other"),
    (lambda: made(FREE, {x, y}, [u, w]), TypeError, "q must be a list, in the order .*no order"),
    (lambda: made(FREE, x, u, force={x: -u}), TypeError, "force must be a list.*no order"),
    (lambda: made(FREE, x, u, force="-u"), TypeError, "the force must be a SymPy expression"),
    (lambda: made(FREE, [x, y], [u]), ValueError, "received 1 for 2"),
    (lambda: made(FREE, [x], [x]), ValueError, "must all differ; received x more than once"),
    (lambda: made(FREE, [x, x], [u, w]), ValueError, "received x more than once"),
    (lambda: made(FREE, x), ValueError, "v must hold the velocities"),
    (lambda: made(FREE, [3], u), TypeError, r"q must hold SymPy symbols.*received \[3\]"),
    (lambda: made("u**2", x, u), TypeError, "must be a SymPy expression; received 'u"),
    (lambda: made(sympy.Matrix([[FREE]]), x, u), TypeError, r"shape \(1, 1\)\. Take its entry"),
    (lambda: made(FREE + sympy.I * x, x, u), ValueError, "must be real and finite; received"),
    (lambda: made(FREE - sympy.sqrt(-(x**2)), x, u), ValueError, r"for real .* I\*Abs\(x\)"),
    (lambda: made(FREE + sympy.zoo, x, u), ValueError, "real and finite"),
    (lambda: made(FREE, x, u, parameters={m: np.nan}), ValueError, "parameter m must be a finite"),
    (lambda: made(FREE, x, u, parameters={"m": 1.0}), TypeError, "received 'm'. Give the symbol"),
    (lambda: made(FREE, x, u, parameters=[m]), TypeError, "must be a dict"),
    (lambda: made(FREE + sympy.Integral(sympy.exp(-(x**2)), (x, 0, x)), x, u), ValueError,
     r"integrals or sums left to do; received Integral.*Call doit\(\)"),
    (lambda: made(th.diff(t) ** 2 + th.diff(t, 2), th), ValueError, r"Derivative\(th, \(t, 2\)\)"),
    (lambda: made(FREE + f(x), x, u), ValueError, r"known functions; received f\(x\)"),
    (lambda: made(FREE + sympy.besselj(0, x), x, u), ValueError, "compiled; received one of bess"),
    (lambda: made(FREE + sympy.floor(x), x, u), ValueError, "differentiable; received floor"),
    (lambda: made(th.diff(t) ** 2, th, t=x), ValueError, "functions of the time alone"),
    (lambda: made(FREE, x, u, "t"), TypeError, "t must be a SymPy symbol"),
    (lambda: made(FREE, x, u, force=[1, 2]), ValueError, "force must hold one .*received 2 for 1"),
    (lambda: made(FREE, x, u, force=-k * u), ValueError, "the force must hold .*received k"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "error", "sentence"), REFUSED)
def test_what_cannot_be_a_lagrangian_is_refused_in_one_sentence(make, error, sentence):
    with pytest.raises(error, match=sentence):
        make()


def test_coordinates_and_forces_in_a_matrix_and_parameters_of_sympy_are_taken():
    L = m * (u**2 + w**2) / 2 - k * x**2
    lists = made(L, [x, y], [u, w], parameters={m: np.sqrt(2.0), k: 0.5}, force=[-u, 0])
    columns = map(sympy.Matrix, ([x, y], [u, w]))
    numbers = {m: sympy.sqrt(2), k: sympy.Rational(1, 2)}
    matrices = made(L, *columns, parameters=numbers, force=sympy.Matrix([-u, 0]))
    assert matrices.function == lists.function
    assert matrices.force == lists.force and repr(lists.force) == "[-u, 0]"
    assert matrices.force(np.ones(2), np.ones(2), 0.0).tolist() == [-1.0, 0.0]


def test_a_piecewise_that_does_not_say_what_holds_elsewhere_is_not_defined_there():
    half = sympy.Piecewise((x**2, x > 0))
    for system in (made(FREE - half, x, u), made(FREE, x, u, force=half)):
        assert galvi.integrate(galvi.Problem(system, [1.0], [0.0]), FOUR, 0.1, 2).success
        with pytest.raises(ValueError, match=r"finite.*at the start"):
            galvi.integrate(galvi.Problem(system, [-1.0], [0.0]), FOUR, 0.1, 1)


def test_a_missing_sympy_is_a_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "sympy", None)
    with pytest.raises(ImportError, match=r"from_sympy needs SymPy: .* Install sympy\."):
        made(FREE, x, u)


def test_galvi_does_not_import_sympy():
    command = [sys.executable, "-c", "import sys, galvi; sys.exit('sympy' in sys.modules)"]
    assert subprocess.run(command).returncode == 0


def test_a_degenerate_lagrangian_says_which_velocities_it_lacks():
    system = made((u - 2 * w) ** 2 / 2 - x**2 - y**2, [x, y], [u, w])
    with pytest.raises(ValueError, match=r"degenerate.*along v\[0\] \+ 0\.5 v\[1\]\."):
        galvi.integrate(galvi.Problem(system, [1.0, 1.0], [1.0, 0.0]), FOUR, 0.1, 1)


def test_a_lagrangian_that_is_not_defined_at_the_start_is_refused():
    system = made(FREE - sympy.log(x), x, u)
    with pytest.raises(ValueError, match="must return a finite number; received nan at the start"):
        galvi.integrate(galvi.Problem(system, [-1.0], [1.0]), FOUR, 0.1, 1)
