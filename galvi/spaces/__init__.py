"""Function spaces on [0, 1]; SPACES constructs one of every kind from a number of at least 1."""

from collections.abc import Callable
from functools import partial

from galvi.spaces.fourier import Fourier, PolynomialFourier
from galvi.spaces.piecewise import PiecewiseHermite, PiecewisePolynomials
from galvi.spaces.polynomials import ComponentPolynomials, Polynomials
from galvi.spaces.space import Space

SPACES: tuple[Callable[[int], Space], ...] = (
    Polynomials,
    partial(PiecewisePolynomials, pieces=3),
    PiecewiseHermite,
    partial(PolynomialFourier, harmonics=2),
    partial(PolynomialFourier, harmonics=1, frequency=20.0),
    Fourier,
    lambda degree: ComponentPolynomials((degree, degree)),
)
