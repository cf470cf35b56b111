"""Symbols and a method, for the tests of Lagrangians from SymPy."""

import pytest

import galvi

pytest.importorskip("sympy")

import sympy

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
x, y, u, w, t = sympy.symbols("x y u w t")
m, k, c = sympy.symbols("m k c", positive=True)
from_sympy = galvi.Lagrangian.from_sympy
FREE = u**2 / 2
