"""The members of an ensemble whose method has a clock: runs by themselves, each in its own time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from tqdm import tqdm

from galvi.arrays import Array, read_only
from galvi.ensembles.keep import FinalStates, StatesAt, kept_of
from galvi.ensembles.parameters import Parameters, checked_parameters, starts_of
from galvi.ensembles.result import Ensemble
from galvi.input_checks import LARGEST, shown
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.ensemble import processors
from galvi.run.integrate import check_types, checked_in_clock
from galvi.run.interruption import uninterrupted
from galvi.run.states import states_at
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

Runner = Callable[[Problem], Trajectory]


def _all_of(
    problems: Sequence[Callable[[], Problem]], run: Runner, keep: Any, shape: tuple[int, ...],
    executor: Any, folder: Any, count: Callable[[int], Any],
) -> Ensemble:  # fmt: skip
    """The ensemble of these problems, each made when its turn comes; ValueError for what needs
    steps that all members share."""
    function = None if hasattr(keep, "begin") else keep
    if executor is not None or folder is not None:
        given = "executor" if executor is not None else "folder"
        raise ValueError(f"with a clock members run in threads; received {given}. Leave it out.")
    if function is None and not isinstance(keep, FinalStates | StatesAt):
        raise ValueError(
            f"with a clock keep must be galvi.FinalStates(), galvi.StatesAt(times) or a Python "
            f"function of a run, since members do not share their steps; received {shown(keep)}."
        )
    times = np.array(keep.times) if isinstance(keep, StatesAt) else None

    def one(member: int) -> tuple[tuple[Array, ...] | None, str, int, int]:
        try:
            found = run(problems[member]())
            at = states_at(found, times) if times is not None and found.success else None
        except ValueError as error:
            return None, str(error), 1, 0
        except Exception as error:
            error.add_note(f"This was member {member}.")
            raise
        ending = found.status, found.failed_step or 0, found.counts["iterations"]
        if function is not None:
            return (np.asarray(function(found), dtype=np.float64),), *ending
        if times is None:
            return (found.q[-1], found.p[-1]) if found.success else None, *ending
        return at, *ending

    compiled = function is None and isinstance(problems[0]().system, NBody)
    with ThreadPoolExecutor(processors() if compiled else 1) as pool:
        found = []
        for single in pool.map(one, range(len(problems))):
            found.append(single)
            count(1)
    known = next((values for values, *_ in found if values is not None), None)
    if known is None:
        known = tuple(np.full((() if times is None else times.shape) + shape, np.nan) for _ in "qp")
    shapes = {tuple(part.shape for part in values) for values, *_ in found if values is not None}
    if len(shapes) > 1:
        raise ValueError(
            f"keep must return arrays of one shape for all members; received shapes "
            f"{', '.join(str(one[0]) for one in sorted(shapes)[:2])}."
        )
    rows = [
        np.stack([np.full_like(part, np.nan) if one[0] is None else one[0][k] for one in found])
        for k, part in enumerate(known)
    ]
    messages = {k: one[1] for k, one in enumerate(found) if one[1] != "Completed."}
    failed, passes = (np.array([one[k] for one in found], dtype=np.int64) for k in (2, 3))
    return Ensemble(tuple(map(read_only, rows)), failed, messages, passes)


def members_in_clock(
    problem: Problem, q0: Any, v0: Any, method: Galerkin, step: Any, steps: int | None,
    parameters: Any, keep: Any, executor: Any, folder: Any, shows: bool, duration: float | None,
    tolerance: float | None,
) -> Ensemble:  # fmt: skip
    """`integrate_ensemble` with a clock."""
    check_types(problem, method, "integrate_ensemble(problem, q0, v0, method, step, duration=...)")
    values = checked_parameters(parameters)
    q, v, h = starts_of(problem, q0, v0, step, values)
    own = Parameters(problem, values, len(q))
    own.check()
    kept, function = kept_of(keep)

    def made(k: int) -> Problem:
        return replace(own.problem, system=own.system(k), q0=q[k], v0=v[k])

    each = [partial(made, k) for k in range(len(q))]
    if len(set(h.tolist())) > 1:
        raise ValueError("with a clock, step must be one number for all members.")
    checked_in_clock(each[0](), method, float(h[0]), steps, duration=duration, tolerance=tolerance)

    def run(here: Problem) -> Trajectory:
        return uninterrupted(checked_in_clock(
            here, method, float(h[0]), steps, duration=duration, tolerance=tolerance,
            save_every=1 if function or not isinstance(kept, FinalStates) else LARGEST,
        )())  # fmt: skip

    with ExitStack() as stack:
        bar = stack.enter_context(tqdm(total=len(q), unit="run")) if shows else None
        return _all_of(
            each, run, function or kept, q.shape[1:], executor, folder,
            (lambda n: None) if bar is None else bar.update,
        )  # fmt: skip
