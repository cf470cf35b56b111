"""How a run ended is found when it is first asked for, once, and by whoever hands the run on."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from dataclasses import fields, replace

import numpy as np
import pytest

import galvi
from galvi.run import loop
from galvi.trajectory import Ending

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
KEPLER = galvi.problems.kepler(0.6)


@pytest.fixture
def judgements(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[float]]:
    """Times at which runs were judged, in steps done."""
    seen: list[float] = []
    assess_run = loop.assess_run

    def counted(engine, run, work):
        seen.append(work.done)
        return assess_run(engine, run, work)

    monkeypatch.setattr(loop, "assess_run", counted)
    yield seen


def looks(tmp_path):
    """Ways to ask."""
    return {
        "outcome": lambda run: run.outcome,
        "success": lambda run: run.success,
        "status": lambda run: run.status,
        "failed step": lambda run: run.failed_step,
        "checkpoint": lambda run: run.checkpoint,
        "repr": repr,
        "pickle": pickle.dumps,
        "replace": lambda run: replace(run, t=run.t),
        "save": lambda run: galvi.save(run, tmp_path / "run.npz"),
        "resume": lambda run: galvi.resume(run, 1).q,
        "SciPy": lambda run: run.to_scipy(),
    }


@pytest.mark.parametrize("name", looks(None))
def test_a_run_is_judged_once_when_it_is_asked(judgements, tmp_path, name):
    run = galvi.integrate(KEPLER, EIGHT, 0.1, 50)
    run(0.3), run.v, run.to_frame(), galvi.energy(run), run.counts, run.interrupted
    assert not judgements
    looks(tmp_path)[name](run)
    looks(tmp_path)[name](run)
    assert judgements == [50]
    assert run.success and run.status == "Completed." and run.checkpoint.first == 50


def test_what_is_handed_on_is_judged(judgements, tmp_path):
    run = galvi.integrate(KEPLER, EIGHT, 3.0, 60, solver="newton")
    galvi.save(run, tmp_path / "run.npz")
    copies = [pickle.loads(pickle.dumps(run)), galvi.load(tmp_path / "run.npz"), replace(run)]
    assert judgements.count(run.counts["steps"]) == 1
    for copy in copies:
        for name in ("success", "status", "failed_step"):
            assert getattr(copy, name) == getattr(run, name)
        assert copy.outcome == run.outcome
        assert np.array_equal(copy.checkpoint.energies, run.checkpoint.energies)
    assert all(isinstance(copy.ending, Ending) for copy in copies[:2])
    assert {one.name for one in fields(run)} == {*vars(run)}


def test_the_energies_of_a_part_are_those_of_the_whole():
    """A run that was never asked, and one that was, go on alike."""
    whole = galvi.integrate(KEPLER, EIGHT, 1.0, 200)
    first, other = (galvi.integrate(KEPLER, EIGHT, 1.0, 90) for _ in range(2))
    assert first.success
    for part in (first, other):
        rest = galvi.resume(part, 110)
        assert np.array_equal(rest.q[-1], whole.q[-1])
        assert np.array_equal(rest.checkpoint.energies[:2] <= whole.checkpoint.energies[:2], [1, 1])
        assert rest.success == whole.success


NUMBERS = {"k": 1.0}


@pytest.mark.parametrize("solver", ["auto", "newton"])
@pytest.mark.parametrize("kind", ["potential", "Lagrangian"])
def test_a_status_does_not_change_with_what_a_function_refers_to(monkeypatch, kind, solver):
    """What Python functions say is asked at once: later they may say something else."""
    if kind == "potential":
        system = galvi.Canonical(
            1.0, lambda q: 0.5 * NUMBERS["k"] * q[0] ** 2, lambda q: NUMBERS["k"] * q
        )
        problem = galvi.Problem(system, [1.0], [0.0])
    else:
        lagrangian = galvi.Lagrangian(
            lambda q, v: 0.5 * v[0] ** 2 - 0.5 * NUMBERS["k"] * q[0] ** 2, galvi.Rn(1)
        )
        problem = galvi.Problem(lagrangian, [1.0], [0.0])
    run = galvi.integrate(problem, EIGHT, 0.5, 40, solver=solver)
    monkeypatch.setitem(NUMBERS, "k", 4.0)
    assert run.status == "Completed." and run.success


def test_ctrl_c_while_a_run_is_judged_leaves_it_to_the_next_who_asks(monkeypatch):
    run, assess_run = galvi.integrate(KEPLER, EIGHT, 0.1, 50), loop.assess_run

    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(loop, "assess_run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        print(run.success)
    monkeypatch.setattr(loop, "assess_run", assess_run)
    assert run.success


def test_a_field_that_was_judged_cannot_be_set():
    run = galvi.integrate(KEPLER, EIGHT, 0.1, 5)
    with pytest.raises(AttributeError, match="no setter"):
        run.success = False
    assert run.success
