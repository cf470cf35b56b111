"""Vectors of four lanes and of eight: which stages run in fours, and functions in both."""

import numpy as np
import pytest

from galvi.lanes import functions, vectors
from galvi.run.in_lanes import tables as method_tables
from tests.properties.lane_functions import compiled


@pytest.mark.parametrize("stages", [1, 4, 8, 9, 12, 13])
def test_only_stages_that_would_leave_a_register_idle_run_in_fours(stages, monkeypatch):
    monkeypatch.setattr(vectors, "AVX512", False)
    lanes = vectors.lanes_for(stages)
    assert lanes == (4 if stages in (1, 4, 9, 12) else 8)
    assert len(method_tables.stages_in_lanes(stages, lanes)) == -(-stages // lanes) * lanes
    monkeypatch.setattr(vectors, "AVX512", True)
    assert vectors.lanes_for(stages) == 8


def test_functions_are_the_same_to_the_bit():
    def all_functions(x):
        one_argument = (
            functions.exponential,
            functions.logarithm,
            functions.inverse_fourth_root,
            functions.square_root,
        )
        return (*functions.sine_cosine(x), *(function(x) for function in one_argument))

    x = np.exp(np.random.default_rng(3).uniform(-5.0, 5.0, 400))
    four, eight = (compiled(all_functions, 1, 6, lanes)(x) for lanes in (4, 8))
    np.testing.assert_array_equal(four, eight)
