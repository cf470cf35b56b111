"""A method and two problems, for the tests of theory."""

import galvi

P = galvi.Polynomials
OSCILLATOR = galvi.problems.harmonic_oscillator()
KEPLER = galvi.problems.kepler(0.6)


def method(degree=4, rule=None):
    return galvi.Galerkin(P(degree), rule or galvi.gauss(degree + 1))
