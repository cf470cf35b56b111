"""Function spaces on [0, 1]; SPACES constructs one of every kind from a number of at least 1."""

from collections.abc import Callable
from functools import partial

from galvi.spaces.component_polynomials import ComponentPolynomials
from galvi.spaces.fourier import Fourier
from galvi.spaces.piecewise_hermite import PiecewiseHermite
from galvi.spaces.piecewise_polynomials import PiecewisePolynomials
from galvi.spaces.polynomial_fourier import PolynomialFourier
from galvi.spaces.polynomials import Polynomials
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
