"""Which engine does a run, the reason that it states, and what a resumed run keeps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

import galvi
from galvi.run import engines
from galvi.run.stepper import Declined, Engine
from tests.agreement.on_vector_spaces import SYMBOLIC, vr
from tests.properties.lagrangians import opaque

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
ready = galvi.problems
KEPLER, TOP = ready.kepler(0.3), ready.heavy_top()
PENDULUM, COORDINATES, *START = SYMBOLIC["elastic pendulum"]


def method(**parts: Any) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), **parts)


UNTRACED = galvi.Problem(galvi.Canonical(1.0, opaque(lambda q: 0.5 * q @ q)), [1.0], [0.0])
PUSHED = galvi.Lagrangian.from_sympy(PENDULUM, *COORDINATES, force=[sp.Max(vr, 0), 0])
# Name -> problem, method, options, the engine, a part of its reason.
RUNS: dict[str, tuple[Any, ...]] = {
    "kepler": (KEPLER, EIGHT, {}, "lanes", "known as expressions"),
    "newton": (KEPLER, EIGHT, {"solver": "newton"}, "general", "lanes: steps are"),
    "body": (ready.free_rigid_body(), EIGHT, {}, "lanes", "known as expressions"),
    "untraced": (
        UNTRACED,
        EIGHT,
        {},
        "general",
        "lanes: its force is not known as a short expression",
    ),
    "branches": (galvi.Problem(PUSHED, *START), FOUR, {}, "general", "lanes: "),
    "frame": (
        ready.outer_solar_system(),
        method(chart=galvi.KeplerFrame()),
        {},
        "frame",
        "Kepler frame",
    ),
    "clock": (
        ready.outer_solar_system(),
        method(clock=galvi.DynamicalTime()),
        {},
        "clock",
        "point masses in galvi.DynamicalTime() have lanes",
    ),
    "sundman": (
        KEPLER,
        method(clock=galvi.Sundman()),
        {},
        "clock",
        "in transformed time, by the lanes of equal steps, since the clock's lanes are for point "
        "masses",
    ),
}


@pytest.mark.skipif(not galvi.FAST, reason="the general kernel is alone")
@pytest.mark.parametrize("case", RUNS)
def test_a_run_says_which_engine_did_it_and_why(case: str, tmp_path: Path) -> None:
    problem, chosen, options, engine, reason = RUNS[case]
    run = galvi.integrate(problem, chosen, 0.05, 3, **options)
    assert run.engine == engine and reason in run.engine_reason, run.engine_reason
    if case not in ("untraced", "branches"):
        galvi.save(run, tmp_path / "run")
        loaded = galvi.load(tmp_path / "run")
        assert (loaded.engine, loaded.engine_reason) == (run.engine, run.engine_reason)
    ended = galvi.integrate(
        problem,
        chosen,
        0.05,
        3,
        events=[galvi.Event(lambda q, v, t: t - 1e9, terminal=True)],
        **options,
    )
    assert (ended.engine, ended.engine_reason) == (run.engine, run.engine_reason)


def test_the_first_engine_that_offers_does_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    lazy = Engine("lazy", lambda request: Declined("it is tired"))
    monkeypatch.setattr(engines, "ENGINES", (lazy, engines.GENERAL))
    run = galvi.integrate(KEPLER, EIGHT, 0.2, 3)
    assert run.engine == "general" and "lazy: it is tired" in run.engine_reason
    monkeypatch.setattr(engines, "ENGINES", (lazy,))
    with pytest.raises(ValueError, match="it is tired"):
        galvi.integrate(KEPLER, EIGHT, 0.2, 3)


def reversed_velocity(q: Any, v: Any, t: float) -> tuple[Any, Any]:
    return q, -v


SAVED_RUNS: dict[str, tuple[Any, ...]] = {
    "long": (KEPLER, 0.1, 2500, {"curves": False}),
    "sparse": (TOP, 0.05, 1500, {"save_every": 7}),
    "acted upon": (
        KEPLER,
        0.1,
        30,
        {"events": [galvi.Event(lambda q, v, t: q[0], action=reversed_velocity)]},
    ),
    "ended at once": (
        KEPLER,
        1.2,
        30,
        {"events": [galvi.Event(lambda q, v, t: q[0], terminal=True)]},
    ),
    "ended late": (
        KEPLER,
        0.1,
        1500,
        {"curves": False, "events": [galvi.Event(lambda q, v, t: t - 140.03, terminal=True)]},
    ),
}


@pytest.mark.parametrize("case", SAVED_RUNS)
def test_a_run_is_saved_loaded_and_resumed_with_its_states(case: str, tmp_path: Path) -> None:
    problem, step, steps, options = SAVED_RUNS[case]
    run = galvi.integrate(problem, FOUR, step, steps, **options)
    assert run.success, run.status
    galvi.save(run, tmp_path / "run")
    loaded = galvi.load(tmp_path / "run")
    assert np.array_equal(loaded.q, run.q) and loaded.outcome == run.outcome
    for state in (run.checkpoint, *getattr(run.again, "checkpoints", ())):
        assert state.state.size and state.stages.size and state.solver_state.size
    if run.curves is None and run.again is not None:
        assert np.array_equal(loaded(run.t[-1] * 0.9), run(run.t[-1] * 0.9))
    resumed = [galvi.resume(source, 3, events=()) for source in (run, loaded)]
    assert np.array_equal(resumed[0].q, resumed[1].q) and resumed[0].success


@pytest.mark.parametrize("problem", [KEPLER, TOP])
def test_a_resumed_run_keeps_what_the_run_kept(problem: Any, tmp_path: Path) -> None:
    thin = galvi.integrate(problem, FOUR, 0.02, 12, save_every=4)
    galvi.save(thin, tmp_path / "run.npz")
    for run in (thin, galvi.load(tmp_path / "run.npz")):
        resumed = galvi.resume(run, 9)
        assert len(resumed.t) == 4 and resumed.curves is None  # after 0, 4, 8 and 9 steps
        full = galvi.resume(run, 9, save_every=1)
        assert len(full.t) == 10 and full.curves is not None
    curved = galvi.integrate(problem, FOUR, 0.02, 12, save_every=4, curves=True)
    assert galvi.resume(curved, 9).curves is not None
    assert galvi.resume(curved, 9, save_every=3, curves=False).curves is None
    bare = galvi.integrate(problem, FOUR, 0.02, 12, curves=False)
    assert len(galvi.resume(bare, 9).t) == 10 and galvi.resume(bare, 9).curves is None


@pytest.mark.skipif(not galvi.FAST, reason="the general kernel is alone")
def test_a_run_of_another_engine_in_a_clock_is_not_resumed(monkeypatch: pytest.MonkeyPatch) -> None:
    run = galvi.integrate(ready.outer_solar_system(), method(clock=galvi.DynamicalTime()), 0.3, 8)
    monkeypatch.setattr(engines, "ENGINES", (engines.GENERAL,))
    with pytest.raises(ValueError, match="done by another engine"):
        galvi.resume(run, 2)
