"""The members of an ensemble whose method has a clock: runs by themselves, each in its own time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from galvi.arrays import Array, read_only
from galvi.ensembles.keep import FinalStates, StatesAt
from galvi.ensembles.result import Ensemble
from galvi.input_checks import shown
from galvi.problem import Problem
from galvi.run.ensemble import processors
from galvi.run.states import states_at
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

Runner = Callable[[Problem], Trajectory]


def members_in_clock(
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
        return states_at(found, times) if found.success else None, *ending

    compiled = function is None and isinstance(problems[0]().system, NBody)
    with ThreadPoolExecutor(processors() if compiled else 1) as pool:
        found = []
        for single in pool.map(one, range(len(problems))):
            found.append(single)
            count(1)
    known = next((values for values, *_ in found if values is not None), None)
    if known is None:
        known = tuple(np.full((() if times is None else times.shape) + shape, np.nan) for _ in "qp")
    rows = [
        np.stack([np.full_like(part, np.nan) if one[0] is None else one[0][k] for one in found])
        for k, part in enumerate(known)
    ]
    messages = {k: one[1] for k, one in enumerate(found) if one[1] != "Completed."}
    failed, passes = (np.array([one[k] for one in found], dtype=np.int64) for k in (2, 3))
    return Ensemble(tuple(map(read_only, rows)), failed, messages, passes)
