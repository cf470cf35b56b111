"""Members that run one by one through `galvi.integrate`, from their starts; in a clock each in its
own time."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from tqdm import tqdm

from galvi.arrays import Array, read_only
from galvi.ensembles.keep import FinalStates, Keep, Record, StatesAt, TimeGrid, kept_of
from galvi.ensembles.parameters import Parameters, checked_parameters, starts_of
from galvi.ensembles.result import Ensemble
from galvi.input_checks import LARGEST, shown
from galvi.method import Galerkin
from galvi.outcome import End, Outcome
from galvi.problem import Problem
from galvi.run.ensemble import processors
from galvi.run.integrate import prepared
from galvi.run.interruption import uninterrupted
from galvi.run.request import RunRequest, check_memory, check_types
from galvi.run.states import states_at
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory


class Single(NamedTuple):
    """What a run by itself leaves: values without the members' axis, and how it ended."""

    values: tuple[Array, ...]
    outcome: Outcome
    passes: int


class Singles:
    """The members of an ensemble as runs by themselves, whose energies are not judged."""

    def __init__(
        self, parameters: Parameters, method: Galerkin, plan: TimeGrid, q: Array, v: Array,
        tolerance: float | None, solver: str,
    ) -> None:  # fmt: skip
        self.parameters, self.method, self.plan = parameters, method, plan
        self.q, self.v = q, v
        self.options: dict[str, Any] = {"tolerance": tolerance, "solver": solver}

    def problem(self, member: int) -> Problem:
        """The problem of one member."""
        own = self.parameters.problem
        system = self.parameters.system(member)
        return replace(own, system=system, q0=self.q[member], v0=self.v[member])

    def run(self, member: int, curves: bool) -> Callable[..., Trajectory]:
        """The run of one member; ValueError for a start or numbers that cannot be run."""
        problem, steps = self.problem(member), self.plan.steps
        step, options = float(self.plan.step[member]), self.options
        request = RunRequest.checked(problem, self.method, step, steps, curves=curves, **options)
        check_memory([request])
        run = prepared(request)
        return lambda: uninterrupted(run(watched=False))

    def kept(self, member: int, keep: Keep) -> Single:
        """Reduced result of one member; one that is refused failed at its first step."""
        plan = self.plan._replace(step=self.plan.step[member : member + 1])
        record = keep.begin(plan)
        try:
            begun = self.run(member, curves=False)
        except ValueError as error:
            q, p = np.full((1, *plan.q_shape), np.nan), np.full((1, *plan.p_shape), np.nan)
            for k in keep.steps(plan):
                record.see(k, plan.t0 + k * plan.step, q, p)
            return Single(_of_one(record), refused(error), 0)
        run = begun()
        for k in keep.steps(plan):
            record.see(k, run.t[k : k + 1], run.q[k : k + 1], run.p[k : k + 1])
        return _single(_of_one(record), run)

    def returned(self, member: int, function: Callable[[Trajectory], Any]) -> Single:
        """What a function of the run returns."""
        run = self.run(member, curves=self.plan.steps <= 10**4)()
        value = function(run)
        try:
            kept = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            raise TypeError(
                f"the function given as keep must return numbers; it returned {shown(value)}. "
                f"`integrate_many` returns runs."
            ) from None
        return _single((kept,), run)


def refused(error: ValueError) -> Outcome:
    """The outcome of a member that an error kept from its first step."""
    return Outcome(End.STEP_FAILED, 1, reason=str(error).removesuffix("."))


def _of_one(record: Record) -> tuple[Array, ...]:
    return tuple(value[0] for value in record.result())


def _single(values: tuple[Array, ...], run: Trajectory) -> Single:
    return Single(values, run.outcome, run.counts["iterations"])


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
        return prepared(RunRequest.checked(
            here, method, float(h[k]), steps, duration=duration, tolerance=tolerance,
            save_every=save_every,
        ))  # fmt: skip

    def one(k: int) -> tuple[tuple[Array, ...] | None, Outcome, int]:
        try:
            found = uninterrupted(run(k)())
            ending = found.outcome, found.counts["iterations"]
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
            return None, refused(error), 0
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
    outcomes = {k: outcome for k, (_, outcome, _) in enumerate(found)}
    return Ensemble(rows, outcomes, np.array([passes for *_, passes in found], dtype=np.int64))
