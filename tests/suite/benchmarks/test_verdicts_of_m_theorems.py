"""V30's terms: a step that a theorem excludes, and what the right side of theorem 3 tells."""

from __future__ import annotations

import pytest

import galvi
from benchmarks.claims.vector_spaces import solution_map, theorem_three
from benchmarks.claims.vector_spaces import v30_solution_map as v30


def test_theorem_2_is_not_accused_of_a_step_that_it_excludes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(v30, "opposed", lambda power: (0.5, 1.0, 1.01, 0.0))
    numbers = v30.of_general_spaces()
    assert isinstance(numbers["least singular value of the equations (8), over the largest"], str)


def test_the_right_side_of_theorem_3_grows_with_the_error_of_the_rule() -> None:
    """Lobatto N errs in |u'|^2, and not in the force more than N + 1 points: only I_2 tells."""
    case, rules = theorem_three.COMPARISONS[0], (galvi.lobatto(3), galvi.lobatto(4))
    best = [theorem_three.consistency(case, solution_map.nodes(rule), 3, 0.2)[0] for rule in rules]
    assert best[0] > 10.0 * best[1]
