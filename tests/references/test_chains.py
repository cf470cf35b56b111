"""The double pendulum and a chain of rods: galvi, MuJoCo, DOP853 and heyoka agree."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

import galvi
from references import REFERENCES
from references.heyoka.lagrangian import HEYOKA_CHAIN, HEYOKA_CHAIN_QUADRUPLE
from references.mujoco import engine as mujoco_engine
from references.mujoco.body import MujocoChain, mujoco_chain
from references.mujoco.steps import (
    MUJOCO_IMPLICIT,
    MUJOCO_RK4,
)
from references.scipy.lagrangian_ivp import CHAIN_DOP853
from references.stored.chain import STORED_CHAIN

needs_mujoco = pytest.mark.skipif(bool(MUJOCO_RK4.missing), reason=MUJOCO_RK4.missing or "present")
needs_heyoka = pytest.mark.skipif(
    bool(HEYOKA_CHAIN.missing), reason=HEYOKA_CHAIN.missing or "present"
)
TIGHT = {"rtol": 3e-14, "atol": 1e-15}
EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
PROBLEMS = {
    "double pendulum": galvi.problems.double_pendulum(),
    "double pendulum, uneven": galvi.problems.double_pendulum(
        (2.0, 0.7), (0.8, 1.3), 5.0, (1.0, -0.5), (2.0, -1.0)
    ),
    "chain of 5 rods": galvi.problems.planar_chain(),
    "three points": galvi.Problem(
        galvi.Lagrangian(galvi.PlanarChain([1.0, 2.0, 0.5], [1.0, 0.5, 0.8]), galvi.Rn(3)),
        [1.0, 2.0, 3.0],
        [0.0, 1.0, 2.0],
    ),
    "one rod": galvi.problems.planar_chain(1, 2.0, 0.7, angle=2.5),
}
DURATION = 2.0
ROUNDING_BOUND = 2e-13  # of DOP853 and galvi after DURATION; 4e-14 measured with 120 steps
every_problem = pytest.mark.parametrize("name", PROBLEMS)


@pytest.fixture(scope="module")
def truths():
    return {
        name: CHAIN_DOP853.run(problem, DURATION, {"samples": 1, **TIGHT})
        for name, problem in PROBLEMS.items()
    }


def final_error(run, truth) -> float:
    assert run.success, run.status
    return float(max(np.abs(run.q[-1] - truth.q[-1]).max(), np.abs(run.p[-1] - truth.p[-1]).max()))


@pytest.mark.slow_cases("double pendulum")
@every_problem
def test_galvi_and_dop853_agree_within_their_errors(name, truths):
    coarse, fine = (
        galvi.integrate(PROBLEMS[name], EIGHT, DURATION / n, n, save_every=n) for n in (30, 120)
    )
    coarse_error = float(np.abs(fine.q[-1] - coarse.q[-1]).max())
    assert final_error(coarse, truths[name]) < 10.0 * coarse_error + ROUNDING_BOUND
    assert final_error(fine, truths[name]) < 1e-6 * coarse_error + ROUNDING_BOUND


@needs_mujoco
@every_problem
def test_mujoco_and_dop853_agree_within_their_errors(name, truths):
    for engine, step, bound in ((MUJOCO_RK4, 2.0**-10, 1e-7), (MUJOCO_IMPLICIT, 2.0**-13, 0.1)):
        run = engine.run(PROBLEMS[name], DURATION, {"step": step, "save_every": 10**6})
        assert (
            final_error(run, truths[name]) < bound
        )  # 2e-8 of the three points, 3e-2 of the double pendulum


@needs_mujoco
@every_problem
def test_mujocos_own_energies_are_those_of_the_lagrangian(name):
    run = MUJOCO_RK4.run(PROBLEMS[name], 1.0, {"step": 2.0**-9, "save_every": 128})
    energies = mujoco_engine.energies(run)
    size = np.abs(energies).max()
    np.testing.assert_allclose(energies.sum(axis=1), galvi.energy(run), atol=1e-14 * size)  # 5e-16


@needs_mujoco
@pytest.mark.parametrize("fault", ["absolute angles", "half a rod's moment", "one point too many"])
def test_a_wrong_model_is_caught(fault, truths, monkeypatch):
    name = "double pendulum" if fault == "one point too many" else "chain of 5 rods"

    def wrong(chain):
        m, l, model = chain.masses, chain.lengths, mujoco_chain(chain)
        if fault == "half a rod's moment":
            return MujocoChain(l, m, model.levers, 0.5 * model.moments, chain.gravity)
        if fault == "one point too many":
            return MujocoChain(l, 2.0 * model.masses, model.levers, model.moments, chain.gravity)
        return model

    if fault == "absolute angles":
        monkeypatch.setattr(mujoco_engine, "to_mujoco", lambda joint, q, v: (q, v))
    monkeypatch.setattr("references.mujoco.body.mujoco_chain", wrong)
    mujoco_engine.compiled.cache_clear()
    run = MUJOCO_RK4.run(PROBLEMS[name], DURATION, {"step": 2.0**-8, "save_every": 10**6})
    mujoco_engine.compiled.cache_clear()
    assert final_error(run, truths[name]) > 1e-2


@needs_heyoka
@pytest.mark.parametrize("name", ["double pendulum, uneven", "one rod"])
def test_heyoka_and_dop853_agree(name, truths):
    run = HEYOKA_CHAIN.run(PROBLEMS[name], DURATION, {"samples": 1, "compact_mode": True})
    assert final_error(run, truths[name]) < 5e-13  # 4e-14
    assert HEYOKA_CHAIN_QUADRUPLE.exact and not HEYOKA_CHAIN.exact


def test_the_double_pendulum_is_chaotic_and_this_is_how_fast():
    """The distance of two starts, 1e-9 in each angle, grows as exp(1.9 t) over ten units of time:
    the Lyapunov time is half a unit, and an error of 1e-16 would be 1e-8 at the end.
    """
    problem = PROBLEMS["double pendulum"]
    neighbour = problem.with_initial_state(problem.q0 + 1e-9, problem.v0)
    setting = {"samples": 10, "tolerance": 1e-13}
    a, b = (CHAIN_DOP853.run(start, 10.0, setting).q for start in (problem, neighbour))
    distances = np.linalg.norm(a - b, axis=1)
    assert 0.3 < 10.0 / np.log(distances[-1] / distances[0]) < 0.8  # 0.53


def test_damping_keeps_a_chain_and_agrees_with_galvi(truths):
    damped = replace(
        PROBLEMS["double pendulum"],
        system=replace(PROBLEMS["double pendulum"].system, force=lambda q, v: -0.3 * v),
    )
    supporting = [c.name for c in REFERENCES if c.supports(damped)]
    assert supporting == [CHAIN_DOP853.name]
    truth = CHAIN_DOP853.run(damped, 2.0, TIGHT)
    by_galvi = galvi.integrate(damped, EIGHT, 0.02, 100)
    assert np.max(np.abs(by_galvi.q[-1] - truth.q[-1])) < 1e-12  # 1.5e-14 when this was written
    assert np.max(np.abs(truths["double pendulum"].q[-1] - truth.q[-1])) > 0.1


def test_slopes_that_are_a_chains_own_keep_its_references_and_others_do_not(monkeypatch):
    problem = PROBLEMS["double pendulum"]
    system, slopes = problem.system, problem.system.function.slopes
    names = [c.name for c in REFERENCES if c.supports(problem)]
    same_slopes = replace(system, slopes=lambda q, v: slopes(q, v))
    assert [c.name for c in REFERENCES if c.supports(replace(problem, system=same_slopes))] == names
    assert len(names) >= 3
    scaled_slopes = replace(system, slopes=lambda q, v: 1.001 * slopes(q, v), check=False)
    copy = galvi.Lagrangian(lambda q, v: system.function(q, v), galvi.Rn(2))
    chains = (CHAIN_DOP853, HEYOKA_CHAIN, MUJOCO_RK4, STORED_CHAIN)
    for not_a_chain in (scaled_slopes, copy):
        assert not any(c.supports(replace(problem, system=not_a_chain)) for c in chains)
    assert not [c.name for c in REFERENCES if c.supports(replace(problem, system=scaled_slopes))]
    monkeypatch.setitem(sys.modules, "heyoka", None)
    assert "Install heyoka" in HEYOKA_CHAIN.missing
