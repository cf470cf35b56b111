"""Runs on disk: one .npz file with arrays and a line of JSON; nothing is pickled.

Spaces, rules, systems and potentials that consist of numbers are written field by field and
restored as equal values. Functions cannot be written: to load a run of a system with functions, the
caller gives its problem again.
"""

from __future__ import annotations

import json
import os
import sys
import tokenize
import zipfile
from dataclasses import fields, is_dataclass
from decimal import Decimal
from typing import Any, BinaryIO

import numpy as np

from galvi.arrays import read_only
from galvi.charts import CHARTS
from galvi.checkpoint import Checkpoint
from galvi.curves.clock_curves import ClockCurves, JoinedCurves
from galvi.curves.redone_curves import RedoneCurves
from galvi.groups import GROUPS
from galvi.input_checks import shown
from galvi.outcome import Outcome
from galvi.problem import Problem
from galvi.run.engines import formulation_of, motion_in_clock
from galvi.trajectory import Ending, Restarts, Trajectory
from galvi.whole_files import write_whole

VERSION = 6
EVENT_ARRAYS = ("t", "step", "value", "index", "q", "v")
STATE_FIELDS = ("state", "stages", "solver_state")  # fields of a checkpoint
ENERGY_ARRAYS = ("energies", "passage", "clock")  # its other arrays
UNREADABLE = (
    KeyError,
    ValueError,
    TypeError,
    AttributeError,
    EOFError,
    OSError,
    tokenize.TokenError,  # raised for an array's header
    NotImplementedError,  # raised for a compression that zipfile does not know
)


def save(run: Trajectory, path: str | os.PathLike[str]) -> None:
    """Write ``run`` to ``path`` (.npz), completely or not at all.

    The curves of a run that actions changed are not written. A symbolic link stays, and the file to
    which it points is written; a pipe or a device is opened and written.

    Raises
    ------
    ValueError
        For a run of a reference, and for one whose space, chart or clock is not galvi's own.
    OSError
        Where the file cannot be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> run = galvi.integrate(galvi.problems.kepler(0.3), method, step=0.25, steps=40)
    >>> with TemporaryDirectory() as folder:
    ...     galvi.save(run, Path(folder) / "orbit.npz")
    ...     print(np.array_equal(galvi.load(Path(folder) / "orbit.npz").q, run.q))
    True
    """
    if not isinstance(run, Trajectory) or run.checkpoint is None:
        raise ValueError(f"only a run of galvi.integrate can be saved; received {shown(run)}.")
    if not is_storable(run.method):
        raise ValueError(
            f"a run can be saved when its space, chart and clock are galvi's own; "
            f"received {shown(run.method)}. "
            f"Save run.t, run.q and run.p with numpy.savez instead."
        )
    problem, end = run.problem, run.checkpoint
    facts = {
        "version": VERSION,
        "problem": {"name": problem.name, "t0": problem.t0, "units": problem.units,
                    "parameters": {key: _plain_value(x) for key, x in problem.parameters.items()}},
        "system": _to_json(problem.system),
        "method": _to_json(run.method),
        "outcome": run.outcome.to_json(), "interrupted": run.interrupted,
        "counts": dict(run.counts), "step": run.step, "first": end.first, "solver": end.solver,
        "tolerance": end.tolerance, "save_every": end.save_every, "keep_curves": end.curves,
        "curves": getattr(run.curves, "t0", None), "engine": run.engine,
        "engine_reason": run.engine_reason,
    }  # fmt: skip
    arrays = {
        "t": run.t,
        "q": run.q,
        "p": run.p,
        "q0": problem.q0,
        "v0": problem.v0,
        "state": end.state,
        "stages": end.stages,
        "solver_state": end.solver_state,
        "energies": end.energies,
        "passage": end.passage,
        "clock": end.clock,
    }
    if run.velocities is not None:
        arrays["velocities"] = run.velocities
    if run.tau is not None:
        arrays["tau"] = run.tau
    if run.again is not None:
        first_steps = [checkpoint.first for checkpoint in run.again.checkpoints]
        facts["again"] = {
            "total": run.again.total,
            "done": run.again.steps_done,
            "known": first_steps,
        }
        for name in (*STATE_FIELDS, "clock"):
            arrays[f"known_{name}"] = np.stack(
                [getattr(checkpoint, name) for checkpoint in run.again.checkpoints]
            )
    if run.events is not None:
        events = run.events
        facts["events"] = [list(events.name), events.unresolved, events.status]
        arrays |= {f"events_{name}": getattr(events, name) for name in EVENT_ARRAYS}
    if run.restarts is not None:
        arrays |= {f"restarts_{name}": getattr(run.restarts, name) for name in "tqv"}
    if run.origin is not None:
        facts["origin"] = run.origin.t0
        arrays |= {"origin_q": run.origin.q0, "origin_v": run.origin.v0}
    if run.curves is not None and not isinstance(run.curves, JoinedCurves):
        arrays |= {"bases": run.curves.bases, "coefficients": run.curves.coefficients}
    if isinstance(run.curves, ClockCurves):
        arrays |= {"times": run.curves.times, "rates": run.curves.rates}
        facts["last"] = run.curves.last
    contents: dict[str, Any] = {"facts": np.array(json.dumps(facts)), **arrays}

    def write(stream: BinaryIO) -> None:
        np.savez(stream, **contents)

    write_whole(path, write)


def load(path: str | os.PathLike[str], problem: Problem | None = None) -> Trajectory:
    """The run that `save` wrote; it can be evaluated and resumed as before.

    Parameters
    ----------
    problem
        the run's problem; needed only when its system holds functions

    Raises
    ------
    ValueError
        When the file is not a saved run, when a problem is needed but not given, or when the given
        problem differs in its system or initial state.
    TypeError
        For a ``problem`` that is no `galvi.Problem`.
    FileNotFoundError
        Where there is no such file.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> run = galvi.integrate(galvi.problems.kepler(0.3), method, step=0.25, steps=40)
    >>> with TemporaryDirectory() as folder:
    ...     galvi.save(run, Path(folder) / "orbit.npz")
    ...     print(galvi.resume(galvi.load(Path(folder) / "orbit.npz"), steps=10).status)
    Completed.
    """
    if problem is not None and not isinstance(problem, Problem):
        raise TypeError(f"problem must be a galvi.Problem; received {shown(problem)}.")
    try:
        with open(path, "rb") as stream, np.load(stream, allow_pickle=False) as file:
            arrays = {name: read_only(file[name]) for name in file.files}
        facts = json.loads(str(arrays.pop("facts")))
        version = facts["version"]
    except FileNotFoundError:
        raise
    except (*UNREADABLE, zipfile.BadZipFile) as error:
        raise ValueError(
            f"{path} must be a run written by galvi.save; it cannot be read as one."
        ) from error
    if version != VERSION:
        raise ValueError(
            f"{path} must have format {VERSION}; received format {shown(version)}. Run its problem "
            f"again, or load it with the version of galvi that saved it."
        )
    try:
        run = _run_from(path, facts, arrays, problem)
        _check_run(run)
    except (LookupError, ArithmeticError, TypeError, AttributeError, AssertionError) as error:
        raise ValueError(
            f"{path} must be a run written by galvi.save; some of it is missing or does not fit."
        ) from error
    return run


def _check_run(run: Trajectory) -> None:
    """AssertionError unless the parts of a run fit each other."""
    end, step = run.checkpoint, run.step
    assert end is not None and step is not None and np.isfinite(step) and step != 0.0
    assert len(run.t) == len(run.q) == len(run.p) > 0 and np.all(np.diff(run.t) * step > 0.0)
    assert run.q.shape[1:] == run.problem.q0.shape and run.p[0].size == run.problem.v0.size
    assert run.curves is None or len(run.curves.bases) == len(run.curves.coefficients)
    if run.tau is not None:
        assert run.tau.shape == run.t.shape and end.clock.shape == (4,)
        return
    fresh = formulation_of(run.problem, run.method).initial_state(run.problem, run.method)
    for array, expected in zip((end.state, end.stages, end.solver_state), fresh, strict=True):
        assert array.shape == expected.shape and array.dtype == expected.dtype


def _run_from(
    path: str | os.PathLike[str],
    facts: dict[str, Any],
    arrays: dict[str, Any],
    problem: Problem | None,
) -> Trajectory:
    """The run of a file with these facts and arrays."""
    from galvi.events.search import Found  # events stand on runs

    method = _from_json(facts["method"], path)
    problem = _problem(path, facts, arrays, problem)
    event_facts, origin, restarts = facts.get("events"), None, None
    if "origin" in facts:
        origin = problem.moved(arrays["origin_q"], arrays["origin_v"], facts["origin"])
    if "restarts_t" in arrays:
        restarts = Restarts(*(arrays[f"restarts_{name}"] for name in "tqv"))
    events = None
    if event_facts:
        arrays_of = {name: arrays[f"events_{name}"] for name in EVENT_ARRAYS}
        events = Found(
            name=tuple(event_facts[0]),
            unresolved=event_facts[1],
            status=event_facts[2],
            **arrays_of,
        )
    end = Checkpoint(
        facts["first"],
        arrays["state"],
        arrays["stages"],
        arrays["solver_state"],
        facts["solver"],
        facts["tolerance"],
        facts["save_every"],
        facts["keep_curves"],
        *(arrays[name] for name in ENERGY_ARRAYS),
    )
    return Trajectory(
        problem, arrays["t"], arrays["q"], arrays["p"],
        counts=facts["counts"], step=facts["step"], method=method,
        curves=_curves(problem, method, facts, arrays),
        ending=Ending(Outcome.from_json(facts["outcome"]), end), interrupted=facts["interrupted"],
        velocities=arrays.get("velocities"), again=_redone_curves(problem, method, facts, arrays),
        engine=facts["engine"], engine_reason=facts["engine_reason"], tau=arrays.get("tau"),
        events=events, restarts=restarts, origin=origin,
    )  # fmt: skip


def _problem(
    path: str | os.PathLike[str],
    facts: dict[str, Any],
    arrays: dict[str, Any],
    user_problem: Problem | None,
) -> Problem:
    """The problem of a file; ValueError for a ``user_problem`` that differs."""
    problem_facts, problem = facts["problem"], user_problem
    if problem is None:
        problem = Problem(
            _from_json(facts["system"], path),
            arrays["q0"],
            arrays["v0"],
            problem_facts["t0"],
            problem_facts["name"],
            problem_facts["parameters"],
            problem_facts["units"],
        )
    same = np.array_equal(problem.q0, arrays["q0"]) and np.array_equal(problem.v0, arrays["v0"])
    if not same or problem.t0 != problem_facts["t0"]:
        raise ValueError(
            f"problem must start where the run in {path} did; received another q0, v0 or t0."
        )
    if not _same_json(_to_json(problem.system), facts["system"]):
        raise ValueError(f"problem must have the system of the run in {path}; it has another one.")
    return problem


def _curves(problem: Problem, method: Any, facts: dict[str, Any], arrays: dict[str, Any]) -> Any:
    """The kept curves; None for none."""
    if "times" in arrays:
        chart = motion_in_clock(problem, method, facts["solver"], facts["tolerance"]).chart
        times, bases, coefficients, rates = (
            arrays[name] for name in ("times", "bases", "coefficients", "rates")
        )
        return ClockCurves(
            method, facts["step"], facts["last"], times, bases, coefficients, rates, chart
        )
    if facts["curves"] is None:
        return None
    curve_arrays = arrays["bases"], arrays["coefficients"]
    try:
        formulation = formulation_of(problem, method)
        return formulation.curves(problem, method, facts["step"], facts["curves"], *curve_arrays)
    except ValueError as error:  # of numpy
        raise LookupError("the curves do not fit") from error


def _redone_curves(
    problem: Problem, method: Any, facts: dict[str, Any], arrays: dict[str, Any]
) -> RedoneCurves | None:
    """The curves, computed again when evaluated, of a run that did not keep them; else None."""
    if "again" not in facts:
        return None
    redone_facts, solver, tolerance = facts["again"], facts["solver"], facts["tolerance"]
    stored_states = zip(
        *(arrays[f"known_{name}"] for name in (*STATE_FIELDS, "clock")), strict=True
    )
    checkpoints = tuple(
        Checkpoint(first, state, stages, numbers, solver, tolerance, clock=clock)
        for first, (state, stages, numbers, clock) in zip(
            redone_facts["known"], stored_states, strict=True
        )
    )
    total, steps_done = (redone_facts.get(name, 0) for name in ("total", "done"))
    last = float(arrays["t"][-1])
    return RedoneCurves(problem, method, facts["step"], total, steps_done, last, checkpoints)


def storable_values() -> dict[str, Any]:
    """The classes whose values can be stored, by name: galvi's public frozen dataclasses, the
    classes of its charts and groups, and those in ``stored_with`` of a public class."""
    public: dict[str, Any] = vars(sys.modules[__name__.partition(".")[0]])
    registered = {type(value).__name__: type(value) for value in (*CHARTS, *GROUPS)}
    for kind in public.values():
        registered |= {part.__name__: part for part in getattr(kind, "stored_with", ())}
    return registered | {name: kind for name, kind in public.items() if _is_frozen_dataclass(kind)}


def _is_storable_kind(kind: type) -> bool:
    """Whether a class is one of ``storable_values``; other classes than frozen dataclasses are
    rejected first, since collecting those takes time."""
    return _is_frozen_dataclass(kind) and storable_values().get(kind.__name__) is kind


def _is_frozen_dataclass(kind: Any) -> bool:
    parameters = getattr(kind, "__dataclass_params__", None)
    return isinstance(kind, type) and parameters is not None and parameters.frozen


def _to_json(value: Any) -> Any:
    kind = type(value).__name__
    if _is_storable_kind(type(value)):
        content = {
            field.name: _to_json(getattr(value, field.name))
            for field in fields(value)
            if field.compare
        }
        return {"kind": kind, **content}
    if isinstance(value, np.ndarray):
        return {"kind": "array", "values": value.tolist()}
    if isinstance(value, tuple):
        return {"kind": "tuple", "values": [_to_json(item) for item in value]}
    if isinstance(value, Decimal):
        return {"kind": "decimal", "values": str(value)}
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    # All functions compare equal; of other values at least the type is compared on loading.
    name = kind if is_dataclass(value) else "function"
    return {"kind": "unknown", "type": name, "description": repr(value)}


def is_storable(value: Any) -> bool:
    """Whether a value can be written to a file completely; functions cannot."""
    return _is_complete(_to_json(value))


def _is_complete(written: Any) -> bool:
    if isinstance(written, list):
        return all(_is_complete(item) for item in written)
    if not isinstance(written, dict):
        return True
    return written["kind"] != "unknown" and all(_is_complete(item) for item in written.values())


def _same_json(left: Any, right: Any) -> bool:
    """Whether two written values are equal, ignoring parts that cannot be written."""
    if isinstance(left, list) and isinstance(right, list):
        return len(left) == len(right) and all(map(_same_json, left, right))
    if not isinstance(left, dict) or not isinstance(right, dict):
        return bool(left == right)
    if "unknown" in (left["kind"], right["kind"]):
        return left["kind"] == right["kind"] and left["type"] == right["type"]
    return left.keys() == right.keys() and all(_same_json(left[key], right[key]) for key in left)


def _from_json(written: Any, path: Any = "") -> Any:
    if not isinstance(written, dict):
        return written
    kind: str = written["kind"]
    values: Any = written.get("values")
    if kind == "array":
        return np.array(values)
    if kind == "tuple":
        return tuple(_from_json(item, path) for item in values)
    if kind == "decimal":
        return Decimal(values)
    stored_class = storable_values().get(kind)
    if stored_class is not None:
        content = {name: _from_json(item, path) for name, item in written.items() if name != "kind"}
        return stored_class(**content)
    raise ValueError(
        f"the run in {path} needs its problem, because {written.get('description', kind)} cannot "
        f"be stored; use galvi.load(path, problem=...)."
    )


def _plain_value(value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (tuple, list)):
        return [_plain_value(item) for item in value]
    return value if value is None or isinstance(value, (bool, int, float, str)) else repr(value)
