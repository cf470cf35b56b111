"""SymPy Lagrangians that are not twice differentiable somewhere, and starts beside it."""

from __future__ import annotations

import numpy as np
import pytest

import galvi
from galvi.fast.symbolic import kinks

pytest.importorskip("sympy")

import sympy

from tests.galvi.symbolic_letters import FOUR, FREE, k, made, u, w, x, y

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
        made(FREE - V, x, u, parameters={k: 3.0})


@pytest.mark.parametrize("V", SMOOTH)
def test_one_that_is_twice_differentiable_across_its_branches_is_taken(V):
    system = made(FREE - V, x, u, parameters={k: 3.0})
    assert kinks.check_start(system.function, np.zeros(1), np.ones(1), 0.0) is None


def test_a_start_on_a_kink_is_refused_and_one_beside_it_is_not():
    with pytest.warns(UserWarning):
        system = made(FREE - k * sympy.Max(0, x - 1) ** 2, x, u, parameters={k: 3.0})
    with pytest.raises(ValueError, match="not twice differentiable at the start, where 1 - x"):
        galvi.integrate(galvi.Problem(system, [1.0], [1.0]), FOUR, 0.1, 1)
    assert galvi.integrate(galvi.Problem(system, [1.01], [0.1]), FOUR, 0.1, 1).success


def test_a_kink_is_seen_at_a_place_of_any_size():
    with pytest.warns(UserWarning):
        system = made(FREE - sympy.Abs(x - k), x, u, parameters={k: 2.0**-30})
    on = np.array([2.0**-30])
    with pytest.raises(ValueError, match="not twice differentiable at the start"):
        kinks.check_start(system.function, on, np.ones(1), 0.0)
    kinks.check_start(system.function, 1.001 * on, np.ones(1), 0.0)


@pytest.mark.parametrize(("far", "t0"), [(1e9, 0.0), (1.0, 2.4e6)])
def test_a_start_beside_a_kink_is_told_from_one_on_it_whatever_the_others_measure(far, t0):
    with pytest.warns(UserWarning):
        system = made((u**2 + w**2) / 2 - sympy.Abs(x), [x, y], [u, w])
    beside, on = (np.array([place, far]) for place in (5e-7, 0.0))
    kinks.check_start(system.function, beside, np.ones(2), t0)
    with pytest.raises(ValueError, match="where x changes its sign"):
        kinks.check_start(system.function, on, np.ones(2), t0)
