"""Built-in potentials: their derivatives at any configuration, and what they refuse."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import galvi

POTENTIALS = (
    galvi.CentralForce(1.7),
    galvi.CosinePotential(0.6),
    galvi.LinearSpring(2.5),
    galvi.SpringChain(0.3, -0.2),
    galvi.UniformField([1.0, -2.0, 0.5]),
)
each_potential = pytest.mark.parametrize("potential", POTENTIALS, ids=lambda V: type(V).__name__)
COORDINATES = st.floats(0.1, 2.0) | st.floats(-2.0, -0.1)


@each_potential
@given(q=st.lists(COORDINATES, min_size=3, max_size=3))
def test_derivatives_are_those_of_the_value(potential: Any, q: list[float]) -> None:
    shifted = np.array(q)[:, None] + 1e-30j * np.eye(3)
    slopes = [np.imag(potential(position)) / 1e-30 for position in shifted.T]
    second_derivatives = [np.imag(potential.gradient(position)) / 1e-30 for position in shifted.T]
    np.testing.assert_allclose(potential.gradient(q), slopes, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(potential.hessian(q), second_derivatives, rtol=1e-12, atol=1e-13)
    of_complex = potential.hessian(np.array(q) + 0j)
    np.testing.assert_allclose(of_complex, potential.hessian(q), rtol=1e-14, atol=1e-15)
    kernel = galvi.Canonical(1.0, potential).force_kernel(3)
    columns, forces, blocks = np.array(q)[:, None], np.empty((3, 1)), np.empty((3, 3, 1))
    kernel.force(columns, np.zeros(1), kernel.constants, forces)
    kernel.slope(columns, np.zeros(1), kernel.constants, blocks)
    np.testing.assert_allclose(forces[:, 0], slopes, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(blocks[..., 0], second_derivatives, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("size", [1e-95, 1e-60, 1e60, 1e95])
def test_a_central_force_is_exact_far_away_and_near(size: float) -> None:
    hessian = galvi.CentralForce(2.0).hessian(np.array([1.0, 2.0, 3.0]) * size)
    exact = 2.0 / 14.0**1.5 * (np.eye(3) - 3.0 * np.outer([1, 2, 3], [1, 2, 3]) / 14.0)
    np.testing.assert_allclose(hessian * size * size * size, exact, rtol=1e-14)


def test_integers_and_other_precisions_are_taken_as_float64() -> None:
    for q in ([1, 2, 2], np.array([1, 2, 2]), np.array([1, 2, 2], dtype=np.float32)):
        slopes = galvi.CentralForce(27.0).gradient(q)
        assert slopes.dtype == np.float64 and slopes.tolist() == [1.0, 2.0, 2.0]


def test_a_field_of_another_number_of_coordinates_is_refused() -> None:
    field = galvi.UniformField([1.0, 0.0, -2.0])
    for derivative in (field.gradient, field.hessian):
        with pytest.raises(ValueError, match=r"shape of the force, \(3,\); received \(2,\)"):
            derivative(np.zeros(2))


@dataclass(frozen=True)
class WithName(galvi.CentralForce):
    name: str = "earth"


def test_a_class_with_more_fields_is_the_same_potential() -> None:
    original, of_subclass = (
        galvi.integrate(
            galvi.Problem(galvi.Canonical(1.0, V), [1.0, 0.0], [0.0, 1.1]),
            galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4)),
            0.1,
            10,
        )
        for V in (galvi.CentralForce(1.0), pickle.loads(pickle.dumps(WithName(1.0))))
    )
    assert np.array_equal(original.q, of_subclass.q)


class ForceWithBuiltInName(galvi.CentralForce):
    """A potential with other slopes, under a name that galvi uses."""

    @staticmethod
    def slopes(q: Any, c: Any, out: Any) -> None:
        out[:] = 2.0 * c[0] * q


ForceWithBuiltInName.slopes.__name__ = "pendulum"


def test_a_force_of_ones_own_is_not_taken_for_one_of_the_same_name() -> None:
    from galvi.tracing.laws_of_systems import slopes_of

    assert slopes_of(galvi.Canonical(1.0, ForceWithBuiltInName(1.0))) is None
    assert slopes_of(galvi.Canonical(1.0, galvi.CosinePotential())) is not None


def test_a_drag_law_takes_arrays_and_both_signs() -> None:
    speeds = np.array([-2.0, 0.0, 3.0])
    assert galvi.QuadraticDrag()(speeds).tolist() == [2.0, 0.0, 3.0]
    assert np.all(np.isfinite(galvi.SchillerNaumann(55.0)(speeds)))
