"""1 / x, 1 / sqrt(x) and x^(-7/4) with the processor's estimates, and where it has none."""

from types import SimpleNamespace

import numpy as np
import pytest

from galvi.lanes.functions import Reciprocals
from galvi.lanes.vectors import AVX512
from tests.properties.lane_functions import compiled


def all_of(features):
    """The three functions as compiled for a processor of these features."""
    target = SimpleNamespace(magic_tuple=lambda: ("", "", features))
    context = SimpleNamespace(codegen=lambda: target)

    def of(x):
        functions = Reciprocals(context, x.builder)
        return functions.reciprocal(x), functions.root(x), functions.quarters(x, 7)

    return of


def in_units(found, exact):
    """Errors in units of the last place."""
    return np.max(np.abs(found - exact) / np.spacing(np.abs(exact)))


@pytest.mark.parametrize("features", ["", "+avx2,+avx512f"])
def test_they_are_exact_to_about_a_unit(features):
    if features and not AVX512:
        pytest.skip("this processor has no estimates")
    x = np.exp(np.random.default_rng(0).uniform(-200.0, 200.0, 5_000))
    one_over, root, power = compiled(all_of(features), 1, 3)(x)
    assert in_units(one_over, 1.0 / x) <= (1.5 if features else 0.0)
    assert in_units(root, (1.0 / np.sqrt(x.astype(np.longdouble))).astype(float)) <= 2.0
    exact = (x.astype(np.longdouble) ** -1.75).astype(float)
    assert in_units(power, exact) <= (3.0 if features else 12.0)
