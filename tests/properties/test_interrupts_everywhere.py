"""No Ctrl-C is lost: whichever call of a user's function or moment of a compilation it meets."""

import signal
import threading
from functools import cache

import numba
import numpy as np
import pytest

import galvi

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
BUDGET = {"degrees": (4, 6), "by": "evaluations", "budget": 3e3}
pytestmark = pytest.mark.usefixtures("interruptible")


class InterruptingGradient:
    """The gradient of `quartic`, which calls ``interrupt`` at call ``at`` and cannot be traced."""

    def __init__(self, interrupt):
        self.interrupt, self.calls, self.at = interrupt, 0, None

    def __call__(self, q):
        self.calls += 1
        if self.calls == self.at:
            self.interrupt()
        return q + 0.2 * float(q @ q) * q

    def restart(self, at):
        self.calls, self.at = 0, at


def raise_interrupt():
    raise KeyboardInterrupt


def raise_signal():
    signal.raise_signal(signal.SIGINT)


def quartic(q):
    with np.errstate(all="ignore"):
        return 0.5 * q @ q + 0.05 * (q @ q) ** 2


def failing_round_trip(problem):
    with pytest.raises(ValueError, match="both ways must be completed"):
        galvi.round_trip_error(problem, FOUR, 30.0, 20)


CLOCK = galvi.Galerkin(
    galvi.Polynomials(2), galvi.gauss(2), clock=galvi.Clock(lambda q: 1.0 / (1.0 + q @ q))
)


@cache
def run_in_a_clock(problem):
    untraced = galvi.Canonical(1.0, lambda q: float(quartic(q)), problem.system.gradient)
    problem_in_clock = galvi.Problem(untraced, [1.0, 0.0], [0.0, 0.5])
    return galvi.integrate(problem_in_clock, CLOCK, 0.3, duration=0.6, save_every=10**6)


JOBS = {
    "states in a clock": lambda problem: galvi.states_at(run_in_a_clock(problem), 0.35),
    "recommend": lambda problem: galvi.recommend(problem, 1e-4, 20.0, **BUDGET),
    "round trip": lambda problem: galvi.round_trip_error(problem, FOUR, 0.3, 20),
    "round trip that fails": failing_round_trip,
    "run that fails": lambda problem: galvi.integrate(problem, FOUR, 300.0, 10),
    "many": lambda problem: galvi.integrate_many([problem, problem], FOUR, 0.3, 10),
    "defect": lambda problem: galvi.symplecticity_defect(problem, FOUR, 0.3),
}


@pytest.mark.slow_cases("run that fails-raised", "run that fails-pressed")
@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize("interrupt", [raise_interrupt, raise_signal], ids=["raised", "pressed"])
@pytest.mark.parametrize("name", JOBS)
def test_an_interrupt_at_any_call_of_a_potential_reaches_the_caller(name, interrupt):
    gradient = InterruptingGradient(interrupt)
    system = galvi.Canonical(1.0, quartic, gradient)
    problem = galvi.Problem(system, [1.0, 2.0], [0.0, 0.0])
    JOBS[name](problem)
    gradient.restart(None)
    JOBS[name](problem)
    for call_number in sorted({*np.linspace(1, 0.98 * gradient.calls, 6).astype(int)}):
        gradient.restart(int(call_number))
        try:
            returned = JOBS[name](problem)
        except KeyboardInterrupt:
            continue
        call_was_reached = (
            gradient.calls >= call_number
        )  # steps are done in batches, whose lengths depend on measured times
        run_is_interrupted = name == "many" and any(run.interrupted for run in returned)
        assert run_is_interrupted or (call_number > 1 and not call_was_reached), (
            f"call {call_number} of {name}: {returned}"
        )


def test_a_handler_of_the_program_that_raises_ends_many_runs_on_threads():
    problem = galvi.problems.outer_solar_system()
    galvi.integrate_many([problem] * 2, FOUR, 1.0, 10)  # numba must not be interrupted as it loads
    before = signal.signal(signal.SIGALRM, lambda *_: raise_interrupt())
    threads = set(threading.enumerate())
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    try:
        with pytest.raises(KeyboardInterrupt):
            galvi.integrate_many([problem] * 4, FOUR, 1.0, 10**8, save_every=10**7, threads=2)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert not {thread for thread in threading.enumerate() if "ThreadPool" in thread.name} - threads


def uncompiled_functions(strength):
    """A potential and a gradient that have not been compiled yet."""

    def potential(q):
        return 0.5 * (q @ q) + strength * q[0] ** 4

    def gradient(q):
        out = q.copy()
        out[0] += 4 * strength * q[0] ** 3
        return out

    return numba.njit(potential), numba.njit(gradient)


@pytest.mark.slow(beside="test_compilation_leaves_an_ignored_interrupt_ignored")
def test_an_interrupt_while_compiling_is_neither_printed_and_dropped_nor_lost(capfd):
    """The signal is delivered from a timer; a compilation is over before it takes effect."""
    before = signal.signal(signal.SIGALRM, lambda *_: raise_signal())
    outcomes = []
    try:
        for k in range(20):
            functions = uncompiled_functions(1.0 + k / 64)
            armed = True
            signal.setitimer(signal.ITIMER_REAL, 0.008 * (k + 0.5))
            try:
                start = galvi.Problem(galvi.Canonical(1.0, *functions), [1.0, 2.0], [0.0, 0.0])
                run = galvi.integrate(start, FOUR, 0.01, 10)
                armed = signal.getitimer(signal.ITIMER_REAL)[0] > 0.0
                outcomes.append(run.interrupted or armed)
            except KeyboardInterrupt:
                outcomes.append(True)
            finally:
                signal.setitimer(signal.ITIMER_REAL, 0.0)
    finally:
        signal.signal(signal.SIGALRM, before)
    assert all(outcomes) and len(outcomes) == 20
    assert "ignored" not in capfd.readouterr().err
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_compilation_leaves_an_ignored_interrupt_ignored():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        potential, _ = uncompiled_functions(0.125)
        assert potential(np.ones(2)) == 1.125
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)
