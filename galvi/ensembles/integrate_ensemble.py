"""Runs many members of one system at once, eight in a vector instruction."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import replace
from typing import Any

import numpy as np
from tqdm import tqdm

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.ensembles.chunk import PROBE, Chunk, ChunkRun, members_of_a_chunk, run_chunks, workers_of
from galvi.ensembles.folder import Folder
from galvi.ensembles.keep import FinalStates, OfStates, StatesAt, TimeGrid, keep_or_function
from galvi.ensembles.member_laws import Law, law_in_lanes, least_tolerance
from galvi.ensembles.parameters import Parameters, check_parameters, starts_of
from galvi.ensembles.result import Ensemble
from galvi.ensembles.singles import Singles
from galvi.input_checks import shown
from galvi.method import Galerkin
from galvi.outcome import Outcome
from galvi.problem import Problem
from galvi.run.engines import stepper_for
from galvi.run.ensemble import processors
from galvi.run.request import RunRequest, check_time_changes, check_types, number_of_steps

SINGLE_NOTE = "It was run by itself, since {why}."
PYTHON_FUNCTION_KEPT = "what is kept is a Python function of a run"
STEP_NOT_SOLVED = "vector code could not do step {step}"
Count = Callable[[int], Any]


def integrate_ensemble(
    problem: Problem,
    q0: Any,
    v0: Any,
    method: Galerkin,
    step: Any,
    steps: int | None = None,
    parameters: Any = None,
    keep: Any = None,
    executor: Any = None,
    folder: Any = None,
    progress: bool | None = None,
    *,
    duration: float | None = None,
    tolerance: float | None = None,
    version: str | None = None,
) -> Ensemble:
    """Integrate n members of ``problem`` from their own starts, as `galvi.integrate` would.

    Parameters
    ----------
    q0, v0 : array, shape (n, ...)
        starts; an array with the shape of the problem's is the start of all members
    step
        step size, or an array (n,) with one for each member
    steps
        number of steps of each member; give either this or ``duration``
    duration
        length of time, the same whole number of steps of all members. With a clock it may have any
        length: each member then has its own steps, and runs by itself
    parameters
        name -> (n, ...) numbers of the system that differ between members: fields of the system,
        its potential, force or Lagrangian (every one of that name), or parameters of a SymPy
        expression
    keep
        the values to keep of each run: `FinalStates` (the default), `StatesAt`, `Extrema`,
        `Histogram`, `Events`; a function (t, q, p) of all states of a run, compiled by
        ``numba.njit``; or a Python function of a `Trajectory`, with which members run one by one,
        some hundred times slower
    executor
        an object with ``submit``, such as Dask's ``Client``; None: one thread for each processor
    folder
        folder for the members, one .npz file for each chunk; files that are in it are loaded
    progress
        True shows a progress bar of members
    tolerance
        as for `galvi.integrate`
    version
        a text that you change with the code of your functions, for a folder. It is needed where a
        function is called (``keep``, or one of the system that could not be traced), since the
        code that it calls is not compared

    Returns
    -------
    Ensemble
        A member is equal to a run of `galvi.integrate` up to round-off, and has the
        same bits in every ensemble, order, thread and process on one type of processor. A member
        with a step that the vector code cannot do is run again by itself, and so are all members of
        a system without generated code, or with a method in a moving frame; their status says so.
        The values of a member that fails, or that `galvi.Problem` then refuses, are NaN from there
        on; its status says why, and the others go on. Energies of members without a clock are not
        assessed. Ctrl-C raises KeyboardInterrupt; files in the folder stay there, and the next call
        goes on from them.

    Raises
    ------
    ValueError, TypeError
        For bad input before the first step.

    Examples
    --------
    >>> problem = galvi.problems.kepler(0.3)
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> q0 = problem.q0 + np.linspace(0.0, 0.1, 16)[:, None]
    >>> result = galvi.integrate_ensemble(problem, q0, problem.v0, method, step=0.25, steps=40)
    >>> result[0].shape, bool(result.success.all())
    ((16, 2), True)
    """
    shows_progress = progress is not None and input_checks.flag("progress", progress)
    check_types(problem, method, "integrate_ensemble(problem, q0, v0, method, step, steps)")
    values = check_parameters(parameters)
    starts = starts_of(problem, q0, v0, step, values)
    member_parameters = Parameters(problem, values, len(starts[0]))
    work = _Work(member_parameters, *starts, method, keep, steps, duration, tolerance)
    if work.in_clock and (executor is not None or folder is not None):
        argument = "executor" if executor is not None else "folder"
        raise ValueError(f"with a clock members run in threads; received {argument}. Leave it out.")
    workers = workers_of(executor, processors())
    if version is not None and not isinstance(version, str):
        raise TypeError(f"version must be a text, or None; received {shown(version)}.")
    store = None if folder is None else Folder(folder, *work.identity(), version)
    with tqdm(total=work.members, unit="run") if shows_progress else nullcontext() as bar:
        return work.run(executor, workers, store, (lambda n: None) if bar is None else bar.update)


def steps_of_all(step: Array, steps: int | None, duration: float | None) -> int:
    """The number of steps of all members; ValueError where it is not the same for each ``step``."""
    counts = {number_of_steps(h, steps, duration) for h in np.unique(step).tolist()}
    if len(counts) > 1:
        raise ValueError(
            f"duration must be the same number of steps of all members; received {duration!r}, "
            f"{min(counts)} to {max(counts)} steps. Give steps."
        )
    return counts.pop()


class _Work:
    """The members of an ensemble, and their values while these are computed."""

    def __init__(
        self,
        parameters: Parameters,
        q: Array,
        v: Array,
        step: Array,
        method: Galerkin,
        keep: Any,
        steps: int | None,
        duration: float | None,
        tolerance: float | None,
    ) -> None:
        self.parameters, self.method, self.q, self.v, self.step = parameters, method, q, v, step
        self.members, self.in_clock = len(q), method.clock is not None
        if not self.in_clock:
            steps, duration = steps_of_all(step, steps, duration), None
        limits: dict[str, Any] = {"steps": steps, "duration": duration, "tolerance": tolerance}
        problem = parameters.problem
        first = problem.with_initial_state(q[0], v[0])
        shortest, longest = (float(step[k(np.abs(step))]) for k in (np.argmin, np.argmax))
        if not self.in_clock:
            check_time_changes(problem.t0, shortest, shortest)
        stepper_for(RunRequest.checked(first, method, longest, curves=False, **limits))
        self.plan = TimeGrid(steps or 0, step, problem.t0, problem.q0.shape, problem.v0.shape)
        self.keep, self.function = keep_or_function(keep)
        self.singles = Singles(
            parameters, method, self.plan, q, v, self.keep, self.function, limits
        )
        self.law: Law | None = None
        self.why_alone, self.tolerance = "", tolerance or 0.0
        if self.in_clock:
            self._check_kept_in_clock(keep)
        elif self.keep is None:
            self.why_alone = PYTHON_FUNCTION_KEPT
        else:
            self.keep.steps(self.plan)  # refuses times that are not those of steps
            self._use_lanes(first)
        if self.law is None:
            parameters.check()
        self.values: list[Array] = []
        self.passes = np.zeros(self.members, dtype=np.int64)
        self.outcomes: dict[int, Outcome] = {}

    def _check_kept_in_clock(self, keep: Any) -> None:
        if self.function is None and not isinstance(self.keep, FinalStates | StatesAt):
            raise ValueError(
                f"with a clock keep must be galvi.FinalStates(), galvi.StatesAt(times) or a Python "
                f"function of a run, since members do not share their steps; received "
                f"{shown(keep)}."
            )

    def _use_lanes(self, first: Problem) -> None:
        """Set the law of the members for lanes, or the reason why there is none."""
        law_or_reason = law_in_lanes(first, self.method)
        if isinstance(law_or_reason, str):
            self.why_alone = law_or_reason
            return
        self.law, self.own = law_or_reason
        self.numbers = self.parameters.numbers(self.law, self.own)
        self.tolerance = max(self.tolerance, least_tolerance(self.law, self.method))

    def identity(self) -> tuple[Any, dict[str, Array]]:
        """The facts that all members share, and the arrays with a row for each, from which files
        get their names."""
        keep = self.function if self.keep is None else self.keep
        system: Any = self.parameters.problem.system
        if self.law is not None:  # its text says all of a function that was traced
            system = self.law, self.own.constants, self.own.mass
        facts = system, self.method, self.plan.steps, self.plan.t0, self.tolerance, keep
        parameter_arrays = {
            f"parameters/{name}": array for name, array in self.parameters.values.items()
        }
        return facts, {"q": self.q, "v": self.v, "step": self.step, **parameter_arrays}

    def run(self, executor: Any, workers: int, store: Folder | None, count: Count) -> Ensemble:
        """All members; ``count`` receives the number of finished members."""
        size, begun = self.first_size(executor, workers, store, count)
        firsts = range(begun, self.members, size)
        pieces = [slice(first, min(first + size, self.members)) for first in firsts]
        missing = [members for members in pieces if not self.loaded(store, members, count)]
        if missing and store is not None:
            store.make_writable()
        for members, chunk_run in self.computed(missing, executor, workers):
            self.take(members, chunk_run, count)
            if store is not None:
                kept_values = tuple(rows[members] for rows in self.values)
                store.save(members, kept_values, self.passes[members], self.outcomes)
        values = tuple(read_only(value) for value in self.values)
        files = "" if store is None else store.summary(len(missing))
        return Ensemble(values, self.outcomes, self.passes, files)

    def first_size(
        self, executor: Any, workers: int, store: Folder | None, count: Count
    ) -> tuple[int, int]:
        """The number of members of a chunk, from the time of a first one or as in the folder, and
        the number of members that are done: those of the first one where there is no folder."""
        if store is not None and (size := store.members_of_a_file()):
            return size, 0
        if self.law is None:
            return (self.members if store is None else PROBE), 0
        if store is not None:
            store.make_writable()
        probe = slice(0, min(PROBE, self.members))
        ((_, chunk_run),) = self.computed([probe], executor, workers)
        assert chunk_run is not None
        seconds_each = max(chunk_run.seconds / probe.stop, 1e-9)
        bytes_each = 8.0 * sum(value[0].size for value in chunk_run.values)
        if isinstance(self.keep, OfStates):
            bytes_each += 8.0 * (self.plan.steps + 1) * (self.q[0].size + self.v[0].size)
        bytes_each += 8.0 * (self.law.dimension * (self.method.stages + 8) + self.q[0].size + 64)
        size = members_of_a_chunk(seconds_each, bytes_each, self.members, workers)
        if store is not None:
            return size, 0
        self.take(probe, chunk_run, count)
        return size, probe.stop

    def computed(
        self, pieces: Sequence[slice], executor: Any, workers: int
    ) -> Iterator[tuple[slice, ChunkRun | None]]:
        """Members with their run in lanes; None where lanes cannot run them."""
        if self.law is None:
            yield from ((members, None) for members in pieces)
            return
        for chunk, chunk_run in run_chunks(map(self.chunk, pieces), executor, workers):
            yield slice(chunk.first, chunk.first + len(chunk.q)), chunk_run

    def chunk(self, members: slice) -> Chunk:
        """The chunk of some members."""
        assert self.law is not None and self.keep is not None
        numbers, plan = self.numbers.rows(members), self.plan._replace(step=self.step[members])
        return Chunk(
            self.law,
            numbers,
            self.method,
            plan,
            self.tolerance,
            self.keep,
            members.start,
            self.q[members],
            self.v[members],
        )

    def take(self, members: slice, chunk_run: ChunkRun | None, count: Count) -> None:
        """Store the values of some members, and run those by themselves that lanes did not."""
        single_members: Sequence[int] = range(members.start, members.stop)
        if chunk_run is not None:
            self.store_values(members, chunk_run.values)
            self.passes[members] = chunk_run.passes
            single_members = (members.start + np.flatnonzero(chunk_run.failed)).tolist()
            count(len(chunk_run.failed) - len(single_members))
        for member, single in zip(
            single_members, self.singles.run_members(single_members), strict=True
        ):
            why, notes = self.why_alone, single.outcome.notes
            if chunk_run is not None:
                why = STEP_NOT_SOLVED.format(step=int(chunk_run.failed[member - members.start]))
            if why:
                notes = (*notes, SINGLE_NOTE.format(why=why))
            self.store_values(
                slice(member, member + 1), tuple(value[None] for value in single.values)
            )
            self.outcomes[member] = replace(single.outcome, notes=notes)
            self.passes[member] = single.passes
            count(1)

    def store_values(self, members: slice, values: tuple[Array, ...]) -> None:
        """Put values in their rows."""
        if not self.values:
            self.values = [np.full((self.members, *x.shape[1:]), np.nan) for x in values]
        for rows, value in zip(self.values, values, strict=True):
            if rows.shape[1:] != value.shape[1:]:
                raise ValueError(
                    f"keep must return arrays of one shape for all members; received shapes "
                    f"{rows.shape[1:]} and, of member {members.start}, {value.shape[1:]}."
                )
            rows[members] = value

    def loaded(self, store: Folder | None, members: slice, count: Count) -> bool:
        """Load some members; returns whether they are in the folder."""
        rows = None if store is None else store.load(members)
        if rows is None:
            return False
        values, self.passes[members], outcomes = rows
        self.store_values(members, values)
        self.outcomes |= outcomes
        count(members.stop - members.start)
        return True
