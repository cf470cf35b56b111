"""Members that run by themselves, as `galvi.integrate` would run them; with a clock each has its
own steps."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from galvi.arrays import Array
from galvi.ensembles.keep import FinalStates, Keep, StatesAt, TimeGrid
from galvi.ensembles.parameters import Parameters
from galvi.input_checks import LARGEST_WHOLE, shown
from galvi.method import Galerkin
from galvi.outcome import End, Outcome
from galvi.run.ensemble import processors
from galvi.run.integrate import prepare_run
from galvi.run.interruption import uninterrupted
from galvi.run.request import RunRequest, check_memory
from galvi.run.states import states_at
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

LONG_RUN = 10**4  # steps above which curves are not kept but computed again


class Single(NamedTuple):
    """The values of a run by itself, without the members' axis, and its outcome."""

    values: tuple[Array, ...]
    outcome: Outcome
    passes: int = 0


class Singles:
    """The members of an ensemble as runs by themselves.

    Parameters
    ----------
    q, v : array, shape (n, ...)
        starts
    keep, function
        the `Keep` of the ensemble, or a function of a run that returns the kept values; the other
        is None
    limits
        ``steps``, ``duration`` and ``tolerance``, as for `galvi.integrate`
    """

    def __init__(
        self,
        parameters: Parameters,
        method: Galerkin,
        plan: TimeGrid,
        q: Array,
        v: Array,
        keep: Keep | None,
        function: Callable[[Trajectory], Any] | None,
        limits: dict[str, Any],
    ) -> None:
        self.parameters, self.method, self.plan, self.q, self.v = parameters, method, plan, q, v
        self.keep, self.function, self.limits = keep, function, limits

    def run_members(self, members: Iterable[int]) -> Iterator[Single]:
        """Run members one after another; in a clock of point masses several at a time, unless a
        Python function evaluates them. Exceptions carry the member's number."""
        in_parallel = isinstance(self.parameters.problem.system, NBody) and self.function is None
        if self.method.clock is None or not in_parallel:
            yield from map(self._run_numbered, members)
            return
        with ThreadPoolExecutor(processors()) as pool:
            yield from pool.map(self._run_numbered, members)

    def _run_numbered(self, member: int) -> Single:
        try:
            return self._single(member)
        except Exception as error:
            error.add_note(f"This was member {member}.")
            raise

    def _single(self, member: int) -> Single:
        """Run one member; a start that is refused counts as a failure at its first step, unless a
        function evaluates the run, which then raises."""
        try:
            do_run = self._prepare(member)
        except ValueError as error:
            if self.function is not None:
                raise
            return self._refused_start(member, error)
        run = uninterrupted(do_run())
        if self.function is not None:
            return _single_of((_numbers(self.function(run)),), run)
        if self.method.clock is None:
            return _single_of(self._record_states(member, run.q, run.p), run)
        if not run.success:
            return _single_of(self._unknown_values(member), run)
        if isinstance(self.keep, FinalStates):
            return _single_of((run.q[-1], run.p[-1]), run)
        try:
            return _single_of(states_at(run, self._times), run)
        except ValueError as error:
            return self._refused_start(member, error)

    def _prepare(self, member: int) -> Callable[..., Trajectory]:
        """A function that does the run of one member; ValueError for a start or numbers that cannot
        be run."""
        system, base_problem = self.parameters.system(member), self.parameters.problem
        problem = replace(base_problem, system=system, q0=self.q[member], v0=self.v[member])
        in_clock = self.method.clock is not None
        request = RunRequest.checked(
            problem,
            self.method,
            float(self.plan.step[member]),
            **self.limits,
            save_every=LARGEST_WHOLE if in_clock and isinstance(self.keep, FinalStates) else 1,
            curves=None if in_clock else self.function is not None and self.plan.steps <= LONG_RUN,
        )
        check_memory([request])
        run = prepare_run(request)
        return run if in_clock else lambda: run(watched=False)

    def _record_states(self, member: int, q: Array, p: Array) -> tuple[Array, ...]:
        """The kept values of a member with these states (steps + 1, ...)."""
        assert self.keep is not None
        plan = self.plan._replace(step=self.plan.step[member : member + 1])
        record = self.keep.begin(plan)
        for k in self.keep.steps(plan):
            record.see(k, plan.t0 + k * plan.step, q[k : k + 1], p[k : k + 1])
        return tuple(value[0] for value in record.result())

    def _unknown_values(self, member: int) -> tuple[Array, ...]:
        """The kept values of a member without states: NaN."""
        shapes = self.plan.q_shape, self.plan.p_shape
        if self.method.clock is None:
            rows = self.plan.steps + 1
            q, p = (np.broadcast_to(np.nan, (rows, *shape)) for shape in shapes)
            return self._record_states(member, q, p)
        leading_shape = () if isinstance(self.keep, FinalStates) else self._times.shape
        return tuple(np.full((*leading_shape, *shape), np.nan) for shape in shapes)

    @property
    def _times(self) -> Array:
        assert isinstance(self.keep, StatesAt)
        return np.array(self.keep.times)

    def _refused_start(self, member: int, error: ValueError) -> Single:
        reason = str(error).removesuffix(".")
        return Single(self._unknown_values(member), Outcome(End.STEP_FAILED, 1, reason=reason))


def _numbers(value: Any) -> Array:
    """The numbers that a function of a run returned; TypeError for others."""
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise TypeError(
            f"the function given as keep must return numbers; it returned {shown(value)}. "
            f"`integrate_many` returns runs."
        ) from None


def _single_of(values: tuple[Array, ...], run: Trajectory) -> Single:
    return Single(values, run.outcome, run.counts["iterations"])
