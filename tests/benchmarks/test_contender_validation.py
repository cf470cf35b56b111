"""What a contender returns is validated before it is used, and timed by its own clock."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import galvi
from benchmarks.applications.external.loading import ContenderError
from benchmarks.applications.external.timed_run import TimedRun
from benchmarks.applications.external.validation import valid_run
from benchmarks.applications.external.worker import settings
from benchmarks.statistics.timing import interleaved, warmed

ORBIT = galvi.problems.kepler(0.6)


def finished(**parts):
    """What a run on ORBIT for {"samples": 2} over 1 should be, with some parts replaced."""
    t, q, p = np.array([0.0, 0.5, 1.0]), np.array([ORBIT.q0] * 3), np.array([ORBIT.p0] * 3)
    return galvi.Trajectory(**{"problem": ORBIT, "t": t, "q": q, "p": p, **parts})


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({"q": np.zeros((3, 5))}, r"q must have the shape \(3, 2\); received \(3, 5\)"),
        ({"p": np.zeros(3)}, r"p must have the shape \(3, 2\); received \(3,\)"),
        ({"q": np.full((3, 2), np.nan)}, "says that it succeeded, and its states are not finite"),
        ({"t": np.array([0.0, 0.5, 1.1])}, "times must be the 3 from 0 to 1 .* received 3 from 0"),
        ({"t": np.array([0.0, 1.0])}, "received 2 from 0 to 1"),
        ({"t": np.array(1.0)}, "received an array of shape"),
        ({"q": "far away"}, "must be arrays of numbers"),
        ({"counts": {"steps": "many"}}, "counts must be whole numbers by their names; received"),
    ],
)
def test_a_run_of_another_shape_or_time_is_refused(parts, said):
    good = valid_run(finished(), ORBIT, 1.0, {"samples": 2})
    assert good["success"] and good["q"].shape == (3, 2)
    with pytest.raises(ContenderError, match=said):
        valid_run(finished(**parts), ORBIT, 1.0, {"samples": 2})


def test_settings_are_plain_and_say_at_which_times_a_run_has_states():
    def offering(**setting):
        return SimpleNamespace(settings=lambda problem, duration: [setting])

    assert settings(offering(step=np.float64(0.5), save_every=np.int64(2)), ORBIT, 1.0, 100) == [
        {"step": 0.5, "save_every": 2}
    ]
    with pytest.raises(ContenderError, match="x is a SimpleNamespace"):
        settings(offering(samples=2, x=SimpleNamespace()), ORBIT, 1.0, 100)
    with pytest.raises(ContenderError, match=r"step must be a positive number; received -0\.5"):
        settings(offering(step=-0.5), ORBIT, 1.0, 100)
    with pytest.raises(ContenderError, match="must say at which times a run has states"):
        valid_run(finished(), ORBIT, 1.0, {"step": 0.5, "save_every": "often"})


def test_a_run_that_says_it_failed_says_why_and_may_hold_nan():
    with pytest.raises(ContenderError, match="its status does not say why"):
        valid_run(finished(success=False, status=" "), ORBIT, 1.0, {"samples": 2})
    parts = {"q": np.full((3, 2), np.nan), "success": False, "status": "Too long a step."}
    assert valid_run(finished(**parts), ORBIT, 1.0, {"samples": 2})["status"] == "Too long a step."


def test_its_clock_is_its_own_and_a_failure_between_rounds_leaves_no_time():
    answers = iter([2.0, 1e-3, 1e-3])  # seconds; then it is gone
    failures = []

    def ask(repeats):
        for seconds in answers:
            return {name: np.zeros(1) for name in "tqp"}, seconds
        raise ContenderError("Gone.")

    call = TimedRun("answers", ORBIT, 1.0, {"samples": 1}, ask, failures.append)
    found, seconds = warmed(call)
    assert found.success and seconds == 2.0
    (timing,) = interleaved([call], 3, 1e-3, [1e-3])
    assert np.isnan(timing.seconds) and call.failure == "Gone." and failures == ["Gone."]
