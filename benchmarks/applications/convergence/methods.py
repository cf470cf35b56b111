"""The methods of an order table: galvi's, other codes by name, and integrators of others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from itertools import pairwise
from typing import Any

import galvi
from benchmarks.applications.convergence.own_class import OwnIntegrator
from benchmarks.applications.external.integrator import TIME_LIMIT, ExternalIntegrator
from benchmarks.applications.external.loading import ContenderError
from benchmarks.work_precision.galvi_methods import InClock, Variational, gauss_collocation
from benchmarks.work_precision.own_problem import FIXED, ladder, peers, tolerances
from benchmarks.work_precision.problem import Participant, Setting, Truth, fixed, galvi_label
from galvi import Problem
from galvi.interop.convergence import ConvergenceRequest
from references import Contender, named
from references.contender import refusal_reason
from references.setting import COUNT_TOLERANCE

DEGREES = (2, 4, 8)  # of galvi's methods where none are named
FEWEST_STEPS = 20  # steps of an integrator that offers its settings
LEAST_RUNGS = 6  # fewer tried numbers of steps are refined by those between
HALVINGS = 12  # of a step in a clock, at most, until a run reaches its end

Methods = Mapping[str, Contender]


@contextmanager
def opened(request: ConvergenceRequest, timeout: float = TIME_LIMIT) -> Iterator[Methods]:
    """The contenders of a request by their names; processes of integrators end with the context.

    Parameters
    ----------
    timeout
        seconds for an answer of an integrator in a process of its own

    Raises
    ------
    ValueError, ContenderError, ModuleNotFoundError
        With a sentence, for a method that does not exist, cannot run or does not solve the problem,
        and for two methods with one name.
    """
    problem = request.problem
    methods: dict[str, Contender] = {}
    if request.with_all:
        methods = {galvi_label(degree): gauss_collocation(degree) for degree in DEGREES}
        methods |= {label(contender): contender for contender in peers(problem)}
    with ExitStack() as stack:
        for name, method in request.methods:
            contender = _contender(problem, name, method, timeout)
            if isinstance(contender, ExternalIntegrator):
                stack.callback(contender.close)
            name = name or label(contender)
            if name in methods:
                raise ValueError(f"two methods are called {name!r}; give each a name of its own.")
            _check_usable(name, contender, problem)
            methods[name] = contender
        yield methods


def label(contender: Contender) -> str:
    """The contender's name and its options in the tables, such as "REBOUND leapfrog, order 8"."""
    options = {k: v for k, v in FIXED.get(contender.name, {}).items() if k != "safe_mode"}
    return ", ".join([contender.name, *(f"{name} {value}" for name, value in options.items())])


def _check_usable(name: str, contender: Any, problem: Problem) -> None:
    if contender.missing:
        raise ModuleNotFoundError(f"the method {name!r} cannot run: {contender.missing}")
    if contender.supports(problem):
        return
    faults = getattr(contender, "faults", ())
    if faults:
        raise ContenderError(faults[0].rstrip("."))
    reason = refusal_reason(contender, problem)
    raise ValueError(
        f"the method {name!r} does not solve this kind of problem; received one with a "
        f"{type(problem.system).__name__} system. "
        + (f"The reason is {reason}." if reason else "Take another method, or None for all.")
    )


def _contender(problem: Problem, name: str, method: Any, timeout: float) -> Any:
    if isinstance(method, galvi.Galerkin):
        return Variational(method) if method.clock is None else InClock(method)
    if not isinstance(method, str):
        return OwnIntegrator.of(name, method)
    return ExternalIntegrator.open(method, timeout) if ":" in method else named(method, problem)


def with_settings(methods: Methods, request: ConvergenceRequest, truth: Truth) -> list[Participant]:
    """Each method with its settings, from coarse to fine.

    Raises
    ------
    ValueError
        For a step that does not go into the duration.
    ContenderError
        For an integrator that offers no settings.
    """
    return [
        Participant(name, contender, _settings(request, contender, truth))
        for name, contender in methods.items()
    ]


def _settings(request: ConvergenceRequest, contender: Any, truth: Truth) -> Sequence[Setting]:
    problem, duration = request.problem, request.duration
    if isinstance(contender, InClock):
        return [{"step": h} for h in _clock_steps(request, contender)]
    options = FIXED.get(contender.name, {})
    if hasattr(contender, "settings"):
        offered = contender.settings(problem, duration, FEWEST_STEPS)
        if not offered:
            raise ContenderError(f"{contender.name} offers no settings")
        if "step" not in offered[-1]:
            return [{**setting, "samples": 1} for setting in offered]
        options = {k: v for k, v in offered[-1].items() if k not in ("step", "save_every")}
    elif not contender.fixed_step:
        return tolerances(contender)
    counts = _counts(request)
    if counts:
        return [{**fixed(duration, count), **options} for count in counts]
    rungs = ladder(problem, duration, contender, truth, options=options)
    counts = [setting["save_every"] for setting in rungs]
    while 1 < len(counts) < LEAST_RUNGS:  # a high order falls to round-off in a few halvings
        counts = sorted({*counts, *(round((a * b) ** 0.5) for a, b in pairwise(counts))})
    return [{**fixed(duration, count), **options} for count in counts]


def _counts(request: ConvergenceRequest) -> Sequence[int]:
    """The requested numbers of equal steps, increasing for sizes; empty where none are requested.

    ValueError for a size that does not go into the duration.
    """
    for h in request.sizes:
        count = max(1, round(request.duration / h))
        if abs(request.duration / h - count) > COUNT_TOLERANCE * count:
            raise ValueError(
                f"each step must go into the duration {request.duration:g} a whole number of "
                f"times; received {h!r}. The nearest is {request.duration / count!r}; numbers of "
                "steps must all be of type int."
            )
    return request.counts or sorted({round(request.duration / h) for h in request.sizes})


def _clock_steps(request: ConvergenceRequest, contender: InClock) -> Sequence[float]:
    """Steps in the clock: the requested sizes, or steps that give about the requested numbers.

    ValueError where no run in the clock reaches the end.
    """
    if request.sizes:
        return request.sizes
    counts = request.counts or tuple(FEWEST_STEPS * 2**k for k in range(6))
    problem, duration = request.problem, request.duration
    rate = float(contender.method.clock.rate(problem)(problem.q0.ravel()))
    step = duration / rate / counts[-1]
    for _ in range(HALVINGS):
        run = galvi.integrate(problem, contender.method, step, 10 * counts[-1], duration=duration)
        if run.success and run.t[-1] >= problem.t0 + duration * (1.0 - COUNT_TOLERANCE):
            return [float(run.tau[-1]) / count for count in counts]
        step *= 0.5
    raise ValueError(
        f"no step in the clock was found with which {contender.name} comes to its end; the last "
        f"run: {run.status} Give steps as sizes."
    )
