"""The equal steps of a run: a `Stepper`, made of a `Formulation` and a `Kernel`.

A formulation defines the arrays of a run's state: on vector spaces, on Lie groups, in moving
frames. A kernel does steps of it: the general one, or one in lanes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple, Protocol, cast

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.curves.curves import Curves, FrameCurves, LocalChart
from galvi.kernels.nystrom.advance import HOLDS
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.request import RunRequest
from galvi.run.run_arrays import COUNT_NAMES, RunArrays, State, has_massless
from galvi.systems.nbody import NBody

RunCurves = Curves | FrameCurves
NEWTON_STEPS_NOTE = (
    "Newton's method did {left} of {steps} steps, as accurately but more slowly, since fixed-point "
    "iteration did not converge there. A smaller step may take less time."
)


class Kernel(Protocol):
    """Steps of one run."""

    def advance(self, n: int) -> int:
        """Does up to n more steps; returns 0, or the code of the step that failed."""


MakeKernel = Callable[[RunRequest, RunArrays], Kernel]


class Formulation(Protocol):
    """The meaning of a run's state arrays: `VECTOR_SPACE`, `ON_GROUP` or `IN_FRAME`.

    Attributes
    ----------
    velocity_row
        row of the state that is saved with q: velocities or momenta
    guess_kind
        the kernels' code for the kind of guess that ``guess`` returns
    in_other_way
        the name, in a run's counts, of the steps that the second kernel did, and the note on them
    """

    velocity_row: int
    guess_kind: int
    in_other_way: tuple[str, str]

    def initial_state(self, problem: Problem, method: Galerkin) -> State:
        """The state before the first step; the same arrays for each run, which copies them."""

    def is_compiled(self, problem: Problem, method: Galerkin) -> bool:
        """Whether its kernel is compiled, so that several runs can proceed in threads."""

    def momenta(self, problem: Problem, saved_moving: Array) -> Array:
        """The conjugate momenta (saved, ...) of rows of `RunArrays.saved_moving`."""

    def curve_size(self, problem: Problem, method: Galerkin) -> tuple[int, int]:
        """The size of a curve's base, and the number of rows of its coefficients."""

    def curves(
        self, problem: Problem, method: Galerkin, step: float, t0: float, bases: Array, x: Array
    ) -> RunCurves:
        """The curves with coefficients x of a run that starts at t0."""

    def guess(self, substeps: Substeps, request: RunRequest, work: RunArrays) -> Array | None:
        """The stages (d, s) from which the second kernel iterates the next step: a guess from
        smaller steps, or the current stages where it needs none; None where the step is not to be
        retried."""

    def failure(self, request: RunRequest, code: int, work: RunArrays) -> str:
        """A sentence on why the next step failed, and the remedy."""


def curves_in(
    chart: LocalChart,
    problem: Problem,
    method: Galerkin,
    step: float,
    t0: float,
    bases: Array,
    x: Array,
) -> Curves:
    """The curves with coefficients x in a chart about bases (steps, r)."""
    return Curves(method.space, t0, step, bases.reshape(-1, *problem.q0.shape), x, chart)


class SavedStates(NamedTuple):
    """The saved states of a run, as `galvi.Trajectory` has them."""

    t: Array
    q: Array
    p: Array
    velocities: Array | None
    tau: Array | None = None


class Stepper:
    """The equal steps of one run by one engine.

    Parameters
    ----------
    request
        of the run
    formulation
        of its state
    engine
        the ``name`` of one of `galvi.run.engines.ENGINES`

    Attributes
    ----------
    engine_reason
        why this engine does the run, and why earlier ones declined
    work
        its arrays, once begun
    """

    work: RunArrays
    over = reached = False  # with a clock: it must do no more steps; it reached its time

    def __init__(
        self,
        request: RunRequest,
        formulation: Formulation,
        engine: str,
        reason: str,
        kernel: MakeKernel,
        second_kernel: MakeKernel,
    ) -> None:
        self.request, self.formulation = request, formulation
        self.engine, self.engine_reason = engine, reason
        self._kernel, self._second_kernel = kernel, second_kernel

    @property
    def steps_done(self) -> int:
        """Number of completed steps."""
        return self.work.steps_done

    def begin(self, *, watched: bool = True) -> None:
        """Make the arrays; ``watched`` states whether to keep states to assess the energy."""
        (problem, method, _, _, start, *_), formulation = self.request, self.formulation
        state = start.state, start.stages, start.solver_state
        if not start.state.size:
            state = formulation.initial_state(problem, method)
        size = formulation.curve_size(problem, method)
        self.work = RunArrays.of(self.request, state, formulation.velocity_row, size, watched)
        self._steps = self._kernel(self.request, self.work)

    def advance(self, n: int) -> int:
        """Does up to n more steps; returns 0, or the code of the step that failed."""
        return self._steps.advance(n)

    def retry(self, engines: Sequence[Engine], code: int) -> int:
        """Do the failed step by the second kernel, from `Formulation.guess`; returns its code, or
        ``code`` where there is no guess."""
        work, substeps = self.work, partial(solve_steps, engines, retried=False)
        guess = self.formulation.guess(substeps, self.request, work)
        if guess is None:
            return code
        stages_before, held_kind = work.stages.copy(), work.solver_state[HOLDS]
        work.solver_state[HOLDS] = self.formulation.guess_kind
        work.stages[:] = guess
        code = self._second_kernel(self.request, work).advance(1)
        if code:
            work.stages[:], work.solver_state[HOLDS] = stages_before, held_kind
        return code

    def finish(self) -> None:
        """Does nothing: see `ClockStepper.finish`."""

    @property
    def checkpoint(self) -> Checkpoint:
        """The current state of the run."""
        start, work = self.request.checkpoint, self.work
        state = work.state.copy(), work.stages.copy(), work.solver_state.copy()
        return Checkpoint(start.first + work.steps_done, *state, start.solver, start.tolerance)

    @property
    def traced(self) -> bool:
        """Whether the run used traced functions."""
        return self.work.in_lanes

    @property
    def curves(self) -> Any:
        """The `RunCurves` of the completed steps; None where they are not kept."""
        problem, method, step, _, start = self.request[:5]
        if not start.keeps_curves:
            return None
        arrays = read_only(self.work.bases), read_only(self.work.coefficients)
        return self.formulation.curves(problem, method, step, self.request.begin_time, *arrays)

    def states(self) -> SavedStates:
        """The saved states."""
        problem, _, step, _, start = self.request[:5]
        work, velocities = self.work, None
        if has_massless(problem):
            velocities = work.saved_moving.reshape(-1, *problem.v0.shape)
        return SavedStates(
            problem.t0 + (start.first + work.saved_steps) * step,
            work.saved_q.reshape(-1, *problem.q0.shape),
            self.formulation.momenta(problem, work.saved_moving),
            velocities,
        )

    def counted(self) -> dict[str, int]:
        """The counts of the run by name."""
        *counted, pairs, second_kernel_steps, in_lanes = self.work.counts.tolist()
        system: Any = self.request.problem.system
        counts = {"steps": self.steps_done, **dict(zip(COUNT_NAMES, counted, strict=True))}
        forces = counts["force_evaluations"]
        if isinstance(system, NBody):
            counts["pair_evaluations"] = forces * system.pairs + pairs
        calls_per_force = getattr(system, "potential_calls_per_force", 0)
        if calls_per_force and forces > in_lanes:
            differenced_forces = forces - in_lanes
            counts["potential_evaluations"] = (
                differenced_forces * calls_per_force * self.request.problem.v0.size
            )
        if second_kernel_steps:
            counts[self.formulation.in_other_way[0]] = second_kernel_steps
        return counts

    @property
    def is_compiled(self) -> bool:
        """Whether its kernel is compiled, so that several runs can proceed in threads."""
        return self.formulation.is_compiled(self.request.problem, self.request.method)

    def failure(self, code: int) -> str:
        """A sentence on why the next step failed, and the remedy."""
        return self.formulation.failure(self.request, code, self.work)


class Declined(NamedTuple):
    """An engine's refusal of a run; its reason is "" where the engine is not meant for such
    runs."""

    reason: str = ""


class Engine(NamedTuple):
    """One of `galvi.run.engines.ENGINES`.

    Attributes
    ----------
    name
        for `galvi.Trajectory.engine`
    offer
        (request) -> a `Stepper`, in a clock a `ClockStepper`, or `Declined`; ValueError for a
        request that no engine can do
    """

    name: str
    offer: Callable[[RunRequest], Any]


def first_offer(engines: Sequence[Engine], request: RunRequest) -> Any:
    """The stepper of the first engine that offers one; ValueError where none does."""
    declined: list[str] = []
    for engine in engines:
        offer = engine.offer(request)
        if not isinstance(offer, Declined):
            offer.engine_reason = "; ".join(filter(None, [offer.engine_reason, *declined]))
            return offer
        if offer.reason:
            declined.append(f"{engine.name}: {offer.reason}")
    raise ValueError(offer.reason)


Substeps = Callable[[RunRequest], tuple[Stepper, int]]  # see `solve_steps`


def solve_steps(
    engines: Sequence[Engine], request: RunRequest, *, retried: bool = True
) -> tuple[Stepper, int]:
    """The stepper of a run after its steps, up to one that fails, and the code of that one, or 0.

    Parameters
    ----------
    retried
        whether a step that fails is retried once, see `Stepper.retry`
    """
    stepper, code = first_offer(engines, request), 0
    stepper.begin(watched=False)
    steps = cast(int, request.steps)
    while code == 0 and stepper.steps_done < steps:
        code = stepper.advance(steps - stepper.steps_done)
        if code and retried:
            code = stepper.retry(engines, code)
    return stepper, code
