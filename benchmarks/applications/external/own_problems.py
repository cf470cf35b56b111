"""Load problems of one's own, named "package.module:function"."""

from __future__ import annotations

import pickle
from dataclasses import replace

from benchmarks.applications.external.loading import ContenderError, describe_error, object_at
from galvi import Problem, input_checks

PATH_NOUNS = "problem", "function"


def load_problem(path: str, duration: float | None = None) -> tuple[Problem, float]:
    """Call the function at the path and return its problem and the duration.

    The function takes no arguments and returns (galvi.Problem, duration). Where `duration` is
    passed, it takes precedence, and the function may return the problem alone. A problem without a
    name is named after the function.

    Raises
    ------
    ContenderError
        Where the path leads to no function, the function raises or returns another value, or the
        duration is not positive.
    """
    function = object_at(path, *PATH_NOUNS)
    if not callable(function):
        raise ContenderError(f"{path} must be a function; received a {type(function).__name__}")
    try:
        returned = function()
    except Exception as error:
        raise ContenderError(f"it raised {describe_error(error)}") from None
    if duration is not None:
        returned = (returned[0] if isinstance(returned, tuple) and returned else returned), duration
    if not (
        isinstance(returned, tuple) and len(returned) == 2 and isinstance(returned[0], Problem)
    ):
        raise ContenderError(
            f"the function must return a galvi.Problem and its duration; received {returned!r}"
        )
    problem, stated_duration = returned
    try:
        duration = input_checks.positive("its duration", stated_duration)
    except (ValueError, TypeError) as error:
        raise ContenderError(str(error).rstrip(".")) from None
    name = problem.name or path.rpartition(":")[2].replace("_", " ")
    return replace(problem, name=name), duration


def require_sendable(problem: Problem) -> None:
    """Raise ContenderError unless the problem can be sent to the process of an integrator."""
    try:
        pickle.dumps(problem)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise ContenderError(
            "its functions must be at the top level of their module, as it is sent to another "
            f"process; received: {error}"
        ) from None
