"""The exponential of matrices of any size against that in forty digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from benchmarks.measures import matrix_group


def in_forty_digits(X):
    with mpmath.workdps(40):
        return np.array(mpmath.expm(mpmath.matrix(X.tolist())).tolist(), dtype=float)


@pytest.mark.parametrize("size", [1e-8, 0.4, 0.9, 1.9, 3.9, 7.9])
def test_the_exponential_is_exact_to_a_few_roundings(monkeypatch, size):
    X = np.random.default_rng(0).standard_normal((4, 4))
    X *= size / np.linalg.norm(X)
    exact = in_forty_digits(X)
    assert np.max(np.abs(matrix_group.exponential(X) - exact)) <= 1e-14 * np.max(np.abs(exact))
    monkeypatch.setattr(matrix_group, "TERMS", 8)
    if size >= 0.4:
        assert np.max(np.abs(matrix_group.exponential(X) - exact)) > 1e-12 * np.max(np.abs(exact))


def test_the_exponential_is_exact_where_one_entry_is_all_of_the_norm():
    found = matrix_group.exponential(np.diag([8.0, 0.0, 0.0]))
    assert np.allclose(np.diag(found), [np.exp(8.0), 1.0, 1.0], rtol=2e-14, atol=0.0)
