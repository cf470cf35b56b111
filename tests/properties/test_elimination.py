"""Linear equations with pivoting, against numpy, whatever the order of the rows."""

import numpy as np
import pytest

from galvi.kernels.nystrom.step import solve_equations
from galvi.kernels.on_group.derivative import factor, substitute


@pytest.mark.parametrize("n", [1, 3, 24, 200])
def test_solutions_are_those_of_numpy_whatever_the_order_of_the_rows(n):
    random = np.random.default_rng(n)
    moved = 0
    for _ in range(5):
        matrix, rhs = random.normal(size=(n, n)), random.normal(size=n)
        factors, pivots, solved = matrix.copy(), np.empty(n, np.int64), rhs.copy()
        assert factor(factors, pivots)
        substitute(factors, pivots, solved)
        moved += int(np.sum(pivots[1:] != np.arange(1, n)))
        by_lapack = rhs.copy()
        assert solve_equations(np.ascontiguousarray(matrix.T), pivots, by_lapack)
        for solution in (solved, by_lapack):
            assert np.allclose(matrix @ solution, rhs, rtol=0, atol=1e-11)  # 3e-13
            assert np.allclose(solution, np.linalg.solve(matrix, rhs), rtol=1e-8, atol=0)
    assert n < 3 or moved > 0  # rows were exchanged after the first column


def test_a_singular_matrix_and_one_that_is_not_finite_are_seen():
    for matrix in (np.ones((2, 2)), np.zeros((3, 3)), np.full((2, 2), np.nan)):
        assert not factor(matrix, np.empty(len(matrix), np.int64))
    zeros = np.zeros((3, 3))
    assert not solve_equations(zeros, np.empty(3, np.int64), np.ones(3))
