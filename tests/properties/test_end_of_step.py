"""The end of a step is computed with twice the digits of its parts."""

import mpmath as mp
import numpy as np
import pytest

import galvi
from galvi.kernels.nystrom.step import complete_step
from galvi.run.vector_space import kernel_tableau


@pytest.mark.slow_cases("0")
@pytest.mark.parametrize("node", range(4))
def test_weights_and_state_count_to_twice_the_precision(node):
    """The accelerations and the step are powers of 2, so that products with them are exact."""
    tableau = kernel_tableau(galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4)).table)
    random, h = np.random.default_rng(node), 0.25
    state = random.normal(size=(4, 3)) * np.array([[1.0], [1e-17], [1.0], [1e-17]])
    a = np.zeros((3, 4))
    a[:, node] = -2.0, 0.5, 1.0
    with mp.workprec(300):
        q, q_low, v, v_low = (np.array([mp.mpf(x) for x in row]) for row in state)
        b, b_low, beta, beta_low = (
            mp.mpf(float(row[node]))
            for row in (tableau.b, tableau.b_low, tableau.beta, tableau.beta_low)
        )
        position = q + q_low + h * (v + v_low) + h * h * (beta + beta_low) * a[:, node]
        velocity = v + v_low + h * (b + b_low) * a[:, node]
        complete_step(tableau, h, a, state)
        for exact, high, low in ((position, 0, 1), (velocity, 2, 3)):
            for k in range(3):
                error = mp.mpf(state[high, k]) + mp.mpf(state[low, k]) - exact[k]
                assert abs(error) < 1e-30  # 2e-31
    assert abs(float(beta_low)) > 1e-20 and np.all(np.abs(state[1::2]) < 1e-15)
