"""One way to run: what differs between vector spaces and Lie groups is in two values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import galvi
from galvi.curves.curves import GroupChart, IdentityChart
from galvi.run import integrate as integrating
from galvi.run.engine_choice import engine_for
from galvi.run.group_engine import ON_GROUP
from galvi.run.nystrom_engine import NYSTROM
from galvi.run.plan import Run, RunArrays
from tests.galvi.lagrangians import opaque

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
KEPLER = galvi.problems.kepler(0.3)
CLOSE = 1e-10  # 1.1e-12 when this was written: the Lagrangian is differenced


def lagrangian(q, v):
    return 0.5 * v @ v + 1.0 / np.sqrt(q @ q)


ON_RN = galvi.Problem(galvi.Lagrangian(opaque(lagrangian), galvi.Rn(2)), KEPLER.q0, KEPLER.v0)


def test_both_engines_agree():
    one, other = (galvi.integrate(problem, FOUR, 0.1, 20) for problem in (KEPLER, ON_RN))
    assert one.counts.keys() < other.counts.keys()
    for name in ("t", "q", "p"):
        assert np.allclose(getattr(one, name), getattr(other, name), rtol=0.0, atol=CLOSE)
    t = np.linspace(0.0, 2.0, 13)
    assert np.allclose(one(t), other(t), rtol=0.0, atol=CLOSE)
    assert np.allclose(one.velocity(t), other.velocity(t), rtol=0.0, atol=CLOSE)


@pytest.mark.parametrize("chart", [galvi.Cayley(), galvi.Exponential()])
def test_the_chart_of_a_vector_space_is_that_of_rn(chart):
    base, xi, rate = np.random.default_rng(3).standard_normal((3, 7, 4))
    identity, of_group = IdentityChart((4,)), GroupChart(galvi.Rn(4), chart)
    assert np.array_equal(identity.place(base, xi), of_group.place(base, xi))
    velocities = (one.velocity(lambda: xi, rate) for one in (identity, of_group))
    assert np.array_equal(*velocities)
    bodies = IdentityChart((2, 2))
    assert np.array_equal(bodies.place(base.reshape(7, 2, 2), xi).reshape(7, 4), base + xi)


@pytest.mark.parametrize("problem", [KEPLER, galvi.problems.heavy_top()])
def test_a_resumed_run_keeps_what_the_run_kept(problem, tmp_path):
    thin = galvi.integrate(problem, FOUR, 0.02, 12, save_every=4)
    galvi.save(thin, tmp_path / "run.npz")
    for run in (thin, galvi.load(tmp_path / "run.npz")):
        rest = galvi.resume(run, 9)
        assert len(rest.t) == 4 and rest.curves is None  # after 0, 4, 8 and 9 steps
        every = galvi.resume(run, 9, save_every=1)
        assert len(every.t) == 10 and every.curves is not None
    curved = galvi.integrate(problem, FOUR, 0.02, 12, save_every=4, curves=True)
    assert galvi.resume(curved, 9).curves is not None
    assert galvi.resume(curved, 9, save_every=3, curves=False).curves is None
    bare = galvi.integrate(problem, FOUR, 0.02, 12, curves=False)
    assert len(galvi.resume(bare, 9).t) == 10 and galvi.resume(bare, 9).curves is None


def test_a_step_that_fails_is_tried_from_smaller_steps_by_both_engines(monkeypatch):
    asked = []

    def watched(engine):
        def guess(*arguments):
            asked.append(engine)
            return engine.guess_from_substeps(*arguments)

        return replace(engine, guess_from_substeps=guess)

    monkeypatch.setattr(
        integrating, "engine_for", lambda *arguments: watched(engine_for(*arguments))
    )
    eight = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    galvi.integrate(galvi.problems.kepler(0.95), eight, 0.5, 4)
    galvi.integrate(galvi.problems.free_rigid_body(), eight, 3.0, 4)
    assert asked == [NYSTROM, ON_GROUP]


@pytest.mark.parametrize("first", [0, 1000, 12_345])
def test_a_run_keeps_one_row_for_each_step_that_is_watched(first):
    """And one for its end, wherever it begins."""
    start = replace(galvi.integrate(KEPLER, FOUR, 0.02, 3).checkpoint, first=first)
    work = RunArrays.of(Run(KEPLER, FOUR, 0.02, 5000, start), 1, (2, 3))
    every = 2**work.watch
    watched = np.count_nonzero(np.arange(first + 1, first + 5001) % every == 0)
    assert every > 1 and len(work.seen) == watched + 1
