"""What a call may do: return what holds, or refuse in one sentence of galvi's own."""

from __future__ import annotations

import dataclasses
import linecache
import traceback
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import galvi
from galvi.run.energies import conserves_energy

Call = tuple[Callable[[], Any], str]  # a call without arguments, and its text
HERE = Path(galvi.__file__).parent
KINDS = (ValueError, TypeError, OSError, ImportError, AttributeError)
RETURNED, REFUSED = "returned", "refused"
LONGEST = 900  # characters of a message
WRONG = 0.01  # of the energy's scale, above which a run must not be called good


def judged(call: Callable[[], Any]) -> str:
    """``returned`` or ``refused``, or a sentence saying what is wrong with the call's end.

    What is asked of a run that failed may be NaN; ``call`` is then a ``functools.partial`` with the
    run among its keywords.
    """
    given = getattr(call, "keywords", {}).values()
    failed = any(isinstance(one, galvi.Trajectory) and not one.success for one in given)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            result = call()
    except Exception as error:
        return REFUSED if _is_own(error) else _told(error)
    try:
        with np.errstate(all="ignore"):
            return _flaw(result, failed) or RETURNED
    except Exception as error:
        return f"of the result, {_told(error)}"


def _told(error: Exception) -> str:
    """The kind and place of an error, which findings are told apart by, and its message."""
    return f"{type(error).__name__} {_where(error)} | {' '.join(str(error).split())}"


def _is_own(error: Exception) -> bool:
    """Whether galvi itself raised this, with a sentence."""
    *_, frame = traceback.extract_tb(error.__traceback__)
    raised = "raise" in linecache.getline(frame.filename, frame.lineno or 0)
    text = str(error)
    sentence = text.endswith((".", "?")) and "\n" not in text and 0 < len(text) <= LONGEST
    return isinstance(error, KINDS) and raised and sentence and HERE in Path(frame.filename).parents


def _where(error: Exception) -> str:
    """The deepest line of galvi in the traceback."""
    inside = [
        frame for frame in traceback.extract_tb(error.__traceback__) if str(HERE) in frame.filename
    ]
    if not inside:
        return "outside galvi"
    return f"at {Path(inside[-1].filename).relative_to(HERE)}:{inside[-1].lineno}"


def _flaw(result: Any, of_failed: bool) -> str:
    if isinstance(result, galvi.Trajectory):
        return _flaw_of_run(result)
    if isinstance(result, galvi.Problem):
        return (
            ""
            if np.isfinite(result.q0).all() and np.isfinite(result.v0).all()
            else "q0 or v0 is not finite"
        )
    values = vars(result).values() if dataclasses.is_dataclass(result) else [result]
    for value in values:
        real = isinstance(value, float | np.ndarray) and np.asarray(value).dtype.kind == "f"
        if real and np.isnan(value).any() and not of_failed:
            return "nan in the result"
    return ""


def _flaw_of_run(run: Any) -> str:
    if not isinstance(run.status, str) or not run.status.endswith("."):
        return f"the status is no sentence: {run.status!r}"
    finite = np.isfinite(run.q).all() and np.isfinite(run.p).all() and np.isfinite(run.t).all()
    if not run.success:
        return "" if run.failed_step is not None else f"no failed step: {run.status}"
    if not finite:
        return f"not finite, and called good: {run.status}"
    acted = run.restarts is not None  # events, which may change the energy
    if run.status == "Completed." and conserves_energy(run.problem.system) and not acted:
        E = np.asarray(galvi.energy(run))
        work = np.abs(run.p * run.v).reshape(len(E), -1).sum(axis=1)  # twice the kinetic energy
        if np.abs(E - E[0]).max() > WRONG * (np.abs(E).max() + work.max()):
            return f"energy from {E[0]:.3g} to {E[-1]:.3g}, and called good"
    return ""
