"""`verify` of contenders that are wrong, remember or ask for too much: none passes."""

from dataclasses import replace

import numpy as np
import pytest

from tests.suite.benchmarks.contenders_at_hand import ORBIT, SWING, Gauss, Inside, checked
from tests.suite.benchmarks.wrong_contenders import WRONG, Mirrored, Remembering, Unseen


@pytest.mark.parametrize("wrong", WRONG, ids=lambda kind: kind.__name__)
def test_what_solves_another_problem_or_none_is_red(wrong):
    quantity, said = WRONG[wrong]
    short = replace(ORBIT, long=20.3)
    assert checked(Gauss(), short)[1] == []
    rows, differing, _ = checked(wrong(), short)
    (caught,) = (row for row in rows if row.quantity == f"{quantity}, {ORBIT.problem.name}")
    assert caught in differing and said in caught.reason


def test_what_it_conserves_has_to_be_looked_at_somewhere():
    _, (caught,), _ = checked(Unseen(), replace(ORBIT, long=20.3), replace(SWING, long=20.3))
    assert caught.quantity.startswith("problems where its angular momentum") and not caught.measured


def test_what_it_returned_before_has_no_time():
    external = Inside.of(Remembering())
    call = external.timed(ORBIT.problem, 5.0, {"step": 0.5, "save_every": 10})
    assert call().success and np.isnan(call.seconds(3))
    assert "had returned before" in call.failure
    sound = Inside.of(Gauss()).timed(ORBIT.problem, 5.0, {"step": 0.5, "save_every": 10})
    assert sound().success and sound.seconds(3) > 0.0 and not sound.failure
    late = Inside.of(Mirrored()).timed(ORBIT.problem, 5.0, {"step": 0.5, "save_every": 10})
    assert np.isnan(late.seconds(3)) and "Its first p" in late.failure


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ({"samples": 10**14}, "10,000,000 states at most; received"),
        ({"step": 1e-320}, "10,000,000,000 steps at most; received a step of 1e-320"),
        ({"step": 1e-8, "save_every": 1}, "states at most"),
    ],
)
def test_a_setting_that_asks_for_too_much_is_refused_and_a_run_with_it_fails(setting, said):
    greedy = Gauss()
    greedy.settings = lambda problem, duration: [setting]
    external = Inside.of(greedy)
    assert external.settings(ORBIT.problem, 5.0, 100) == [] and said in external.faults[0]
    for beyond in (10**14, 10**400):  # a MemoryError, an OverflowError
        assert len(external.run(ORBIT.problem, 5.0, {"samples": beyond}).t) == 2
