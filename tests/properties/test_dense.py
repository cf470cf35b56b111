"""Symmetric matrices in lanes, factored in loops as when they are written out."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
import pytest
from numba import types
from numba.extending import intrinsic

import galvi
from galvi.lanes import dense
from galvi.lanes.values import Lane
from galvi.lanes.vectors import LANES, Lanes
from galvi.run.in_lanes import law_kernel
from galvi.tracing import lane_law


def balls() -> galvi.Problem:
    return galvi.from_mujoco(
        '<mujoco><worldbody><body><joint type="ball"/>'
        '<inertial pos=".1 0 .2" mass="1" diaginertia=".02 .02 .01"/>'
        '<body pos="0 .1 .4"><joint type="ball"/>'
        '<inertial pos="0 .1 .2" mass="1" diaginertia=".02 .02 .01"/>'
        "</body></body></worldbody></mujoco>"
    ).with_initial_state(np.tile(np.eye(3).ravel(), 2), [0.3, -0.2, 0.5, 0.7, 0.1, -0.4])


def solved_in_loops(d: int) -> Any:
    """(triangle and right-hand side, 8), in place <- factors and solution."""

    @intrinsic
    def both(typingctx, rows, padded):  # type: ignore[no-untyped-def]
        signature = types.void(rows, padded)

        def generate(context, builder, signature, values):  # type: ignore[no-untyped-def]
            row = values[1].type
            lanes = Lanes(context, builder, values[1], row(0))
            data = lanes.data(signature.args[0], values[0])
            triangle, first = dense.Triangle(builder, lanes, data, 0, d), d * (d + 1) // 2
            triangle.factor()
            right = [Lane(builder, lanes.load(data, row(first + i))) for i in range(d)]
            for i, x in enumerate(triangle.solve(right)):
                lanes.store(x.value, data, row(first + i))
            return context.get_dummy_value()

        return signature, generate

    @numba.njit(error_model="numpy")
    def solve(rows):  # type: ignore[no-untyped-def]
        both(rows, rows.shape[1])

    return solve


@pytest.mark.parametrize("d", [1, 2, 4, 5, 11])
def test_loops_find_the_factors_of_what_is_written_out_and_solve(d: int) -> None:
    random = np.random.default_rng(d)
    roots, right = random.normal(size=(LANES, d, d)), random.normal(size=(LANES, d))
    masses = roots @ roots.swapaxes(1, 2) + np.eye(d)
    lower = np.tril_indices(d)
    rows = np.ascontiguousarray(np.concatenate([masses[:, lower[0], lower[1]], right], axis=1).T)
    solved_in_loops(d)(rows)
    for k, mass in enumerate(masses):
        factors = dense.factored([mass[i, : i + 1] for i in range(d)])
        expected = np.concatenate([np.array(row) for row in factors])
        np.testing.assert_allclose(rows[: expected.size, k], expected, rtol=1e-10, atol=1e-13)
        found = rows[expected.size :, k]
        np.testing.assert_allclose(found, np.linalg.solve(mass, right[k]), rtol=1e-9, atol=1e-11)


@pytest.mark.slow_cases("5-two ball joints", "6-two ball joints")
@pytest.mark.parametrize(
    "make", [balls, galvi.problems.double_pendulum], ids=["two ball joints", "a double pendulum"]
)
@pytest.mark.parametrize("points", [5, 6])
def test_steps_are_the_same_with_loops(make: Any, points: int, monkeypatch: Any) -> None:
    problem = make()
    method = galvi.Galerkin(galvi.Polynomials(5), galvi.gauss(points))
    written_out = galvi.integrate(problem, method, 0.02, 10)
    remembered = (law_kernel.law_on_space, law_kernel.law_on_group)
    for one in (*remembered, lane_law.compiled_law):
        one.cache_clear()
    monkeypatch.setattr(dense, "WRITTEN_OUT_PRODUCTS", -1)
    monkeypatch.setattr(lane_law, "STEP", lane_law.STEP + "\n\n# in loops\n")  # another file
    in_loops = galvi.integrate(problem, method, 0.02, 10)
    for one in (*remembered, lane_law.compiled_law):
        one.cache_clear()
    assert in_loops.engine == written_out.engine == "lanes"
    np.testing.assert_allclose(in_loops.q, written_out.q, rtol=0, atol=1e-14)  # 4e-16
    np.testing.assert_allclose(in_loops.p, written_out.p, rtol=0, atol=1e-14)


def test_what_is_long_is_done_in_loops_and_what_is_sparse_written_out() -> None:
    def chain(first: int, d: int) -> list[tuple[int, int]]:
        return [(first + i, first + j) for i in range(d) for j in range(i)]

    assert dense.is_written_out(chain(0, 29)) and not dense.is_written_out(chain(0, 36))
    assert dense.is_written_out([pair for k in range(12) for pair in chain(3 * k, 3)])
