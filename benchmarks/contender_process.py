"""The other side of `benchmarks.outsider`: a process in which somebody else's contender runs.

A request is (what, *arguments), an answer ("done", value) or ("fault", sentence). Whatever the
contender raises becomes a sentence; what it hangs or breaks is this process and no other.
"""

from __future__ import annotations

import difflib
import importlib
import importlib.util
import os
import signal
import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from galvi import Problem
from references.setting import fixed_steps, sample_times

PARTS = ("name", "supports", "run")
OURS = "galvi"
NEAR = 1e-9  # of the duration: by how much a time may differ from the one asked for


class Fault(Exception):
    """What is wrong, in a sentence."""


def serve(connection: Any, path: str) -> None:
    """Answer requests until the connection closes. What the contender prints goes to stderr."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    os.dup2(2, 1)
    contender: Any = None
    while True:
        try:
            what, *arguments = connection.recv()
        except EOFError:
            return
        try:
            if what == "open":
                contender = opened(path)
                value: Any = contender.name
            else:
                value = ANSWERS[what](contender, *arguments)
            answer = ("done", value)
        except Fault as fault:
            answer = ("fault", str(fault))
        except BaseException as error:
            answer = ("fault", f"It raised {_told(error)}.")
        connection.send(answer)


def opened(path: str) -> Any:
    """The contender at "package.module:Class". Fault when there is none, or it is none."""
    module_name, _, name = path.partition(":")
    if not all(part.isidentifier() for part in (*module_name.split("."), name)):
        raise Fault(f"a contender is named package.module:Class; received {path!r}")
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        if error.name and (module_name + ".").startswith(error.name + "."):
            raise Fault(
                f"there is no module {error.name!r} to take {name} from; name one that Python can "
                f"import from this folder"
            ) from None
        raise Fault(f"importing {module_name} raised {_told(error)}") from None
    except BaseException as error:
        raise Fault(f"importing {module_name} raised {_told(error)}") from None
    if not hasattr(module, name):
        known = [word for word in vars(module) if not word.startswith("_")]
        near = difflib.get_close_matches(name, known, n=1, cutoff=0.0)
        raise Fault(
            f"module {module_name} has no {name!r}{f'; did you mean {near[0]!r}' if near else ''}"
        )
    made = getattr(module, name)
    if isinstance(made, type):
        try:
            made = made()
        except BaseException as error:
            raise Fault(f"{name}() raised {_told(error)}") from None
    lacking = [part for part in PARTS if not hasattr(made, part)]
    lacking += [
        part for part in PARTS[1:] if hasattr(made, part) and not callable(getattr(made, part))
    ]
    if lacking:
        raise Fault(
            f"{path} lacks {' and '.join(map(repr, lacking))}; a contender has name, "
            "supports(problem) and run(problem, duration, setting)"
        )
    if not isinstance(made.name, str) or not made.name.strip() or made.name.startswith(OURS):
        raise Fault(
            f"the name of {path} must be words that do not begin with {OURS!r}, which are galvi's "
            f"own methods; received {made.name!r}"
        )
    return made


def supports(contender: Any, problem: Problem) -> bool:
    """Whether it solves the problem."""
    return bool(contender.supports(problem))


def settings(contender: Any, problem: Problem, duration: float) -> list[dict[str, Any]] | None:
    """What it wants to be run with; None when it does not say."""
    if not hasattr(contender, "settings"):
        return None
    offered = list(contender.settings(problem, duration))
    if not offered or not all(isinstance(one, Mapping) for one in offered):
        raise Fault(f"Its settings must be mappings, one at least; received {offered!r}.")
    return [{str(name): _plain(str(name), value) for name, value in one.items()} for one in offered]


def _plain(name: str, value: Any) -> Any:
    """A value that another process can take without running code of the contender's."""
    value = value.item() if isinstance(value, np.generic) else value
    if value is not None and type(value) not in (bool, int, float, str):
        raise Fault(
            f"Its settings must hold numbers, words, True, False or None; {name} is a "
            f"{type(value).__name__}."
        )
    return value


def run(
    contender: Any, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> tuple[dict[str, Any], float]:
    """The run's parts, examined, and the seconds that it took."""
    start = time.perf_counter()
    found = contender.run(problem, duration, dict(setting))
    seconds = time.perf_counter() - start
    return examined(found, problem, duration, setting), seconds


def seconds(
    contender: Any, problem: Problem, duration: float, setting: Mapping[str, Any], repeats: int
) -> float:
    """Of one run, the mean of several."""
    start = time.perf_counter()
    for _ in range(repeats):
        contender.run(problem, duration, dict(setting))
    return (time.perf_counter() - start) / repeats


def examined(
    found: Any, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> dict[str, Any]:
    """t, q, p, success, status and counts of a run. Fault when they are not what was asked for."""
    wanted = ("t", "q", "p", "success", "status", "counts")
    lacking = [part for part in wanted if not hasattr(found, part)]
    if lacking:
        raise Fault(
            f"Its run must return a galvi.Trajectory; received {type(found).__name__}, which has "
            f"no {' and no '.join(lacking)}."
        )
    try:
        t, q, p = (np.array(part, dtype=np.float64) for part in (found.t, found.q, found.p))
    except (TypeError, ValueError) as error:
        raise Fault(f"Its t, q and p must be arrays of numbers; {error}.") from None
    try:
        times = _times(problem, duration, setting)
    except (KeyError, TypeError, ValueError) as error:
        raise Fault(
            "Its settings must say at which times a run has states, as step and save_every or as "
            f"samples; received {dict(setting)!r} ({_told(error)})."
        ) from None
    if t.shape != times.shape or not np.allclose(t, times, rtol=0.0, atol=NEAR * abs(duration)):
        raise Fault(
            f"Its times must be the {len(times)} from {times[0]:g} to {times[-1]:g} that its "
            f"setting asks for; received {_ends(t)}."
        )
    for name, states, start in (("q", q, problem.q0), ("p", p, problem.v0)):
        if states.shape != (len(times), *start.shape):
            raise Fault(
                f"Its {name} must have the shape {(len(times), *start.shape)}; received "
                f"{states.shape}."
            )
    success = bool(found.success)
    if success and not (np.isfinite(q).all() and np.isfinite(p).all()):
        raise Fault("It says that it succeeded, and its states are not finite.")
    try:
        counts = {str(name): int(count) for name, count in dict(found.counts).items()}
    except (TypeError, ValueError):
        raise Fault(
            f"Its counts must be whole numbers by their names; received {found.counts!r}."
        ) from None
    return {
        "t": t, "q": q, "p": p, "success": success, "status": str(found.status), "counts": counts,
    }  # fmt: skip


def _times(problem: Problem, duration: float, setting: Mapping[str, Any]) -> Any:
    if "step" in setting:
        return fixed_steps(duration, setting).times(problem.t0)
    return sample_times(problem.t0, duration, setting)


def _ends(t: Any) -> str:
    if t.ndim != 1 or not t.size:
        return f"an array of shape {t.shape}"
    return f"{len(t)} from {t[0]:g} to {t[-1]:g}"


def _told(error: BaseException) -> str:
    words = " ".join(str(error).split()).rstrip(".")
    return f"{type(error).__name__}: {words}" if words else type(error).__name__


ANSWERS = {"supports": supports, "settings": settings, "run": run, "seconds": seconds}
