"""The members of an ensemble whose method has a clock: runs by themselves, each in its own time."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
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
from galvi.trajectory import COMPLETED, Trajectory


def members_in_clock(
    problem: Problem, q0: Any, v0: Any, method: Galerkin, step: Any, steps: int | None,
    parameters: Any, keep: Any, executor: Any, folder: Any, shows: bool, duration: float | None,
    tolerance: float | None,
) -> Ensemble:  # fmt: skip
    """`integrate_ensemble` with a clock. ValueError for what needs steps that all members share."""
    check_types(problem, method, "integrate_ensemble(problem, q0, v0, method, step, duration=...)")
    values = checked_parameters(parameters)
    q, v, h = starts_of(problem, q0, v0, step, values)
    own = Parameters(problem, values, len(q))
    own.check()
    kept, function = kept_of(keep)
    if executor is not None or folder is not None:
        given = "executor" if executor is not None else "folder"
        raise ValueError(f"with a clock members run in threads; received {given}. Leave it out.")
    if function is None and not isinstance(kept, FinalStates | StatesAt):
        raise ValueError(
            f"with a clock keep must be galvi.FinalStates(), galvi.StatesAt(times) or a Python "
            f"function of a run, since members do not share their steps; received {shown(keep)}."
        )
    times = np.array(kept.times) if isinstance(kept, StatesAt) else None
    save_every = LARGEST if function is None and times is None else 1

    def run(k: int) -> Callable[..., Trajectory]:
        here = replace(own.problem, system=own.system(k), q0=q[k], v0=v[k])
        return checked_in_clock(
            here, method, float(h[k]), steps, duration=duration, tolerance=tolerance,
            save_every=save_every,
        )  # fmt: skip

    def one(k: int) -> tuple[tuple[Array, ...] | None, str, int, int]:
        try:
            found = uninterrupted(run(k)())
            ending = found.status, found.failed_step or 0, found.counts["iterations"]
            if function is not None:
                return (np.asarray(function(found), dtype=np.float64),), *ending
            if not found.success:
                return None, *ending
            ends = (found.q[-1], found.p[-1])
            return ends if times is None else states_at(found, times), *ending
        except ValueError as error:
            if function is not None:
                error.add_note(f"This was member {k}.")
                raise
            return None, str(error), 1, 0
        except Exception as error:
            error.add_note(f"This was member {k}.")
            raise

    run(0)  # refuses what no member can do
    threads = processors() if function is None and isinstance(problem.system, NBody) else 1
    with ThreadPoolExecutor(threads) as pool:
        every = pool.map(one, range(len(q)))
        found = list(tqdm(every, total=len(q), unit="run") if shows else every)
    done = [values for values, *_ in found if values is not None]
    if len({tuple(part.shape for part in values) for values in done}) > 1:
        raise ValueError("keep must return arrays of one shape for all members.")
    lead = () if times is None else times.shape
    shapes = [part.shape for part in done[0]] if done else [
        (*lead, *q.shape[1:]), (*lead, *v.shape[1:])
    ]  # fmt: skip
    rows = tuple(
        read_only(np.stack([np.full(shape, np.nan) if x is None else x[k] for x, *_ in found]))
        for k, shape in enumerate(shapes)
    )
    messages = {k: status for k, (_, status, *_) in enumerate(found) if status != COMPLETED}
    failed, passes = (np.array([one[k] for one in found], dtype=np.int64) for k in (2, 3))
    return Ensemble(rows, failed, messages, passes)
