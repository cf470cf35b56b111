"""Function spaces on [0, 1]; SPACES names every kind, each made from one number."""

from galvi.spaces.polynomials import Polynomials

SPACES = (Polynomials,)
