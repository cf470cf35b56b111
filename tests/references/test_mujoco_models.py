"""MuJoCo's bodies, energies and versions; what it does not take is a sentence."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import galvi

pytest.importorskip("mujoco")

import mujoco

from references.mujoco import body as mujoco_body
from references.mujoco import engine as mujoco_engine
from references.mujoco.body import on_a_pivot
from references.mujoco.engine import energies
from references.mujoco.steps import MUJOCO_DISCRETE, MUJOCO_RK4
from tests.references.mujoco_problems import ALL, LEVER, PROBLEMS, SKEW, SPIN, TILT, TILTED


@pytest.mark.parametrize(
    ("mass", "centre", "inertia"),
    [
        (0.8, [0.3, -0.5, 0.7], SKEW),
        (1.0, [0.0, 0.0, 1.0], np.diag([1.0, 1.0, 1e-3])),  # a point on a thin rod
        (1.0, [1.0, 0.0, 0.0], np.diag([0.25, 1.25, 1.5])),  # a disc that swings in its plane
        (3.0, [0.6, 0.8, 0.0], TILT @ np.diag([5.0, 7.0, 9.0]) @ TILT.T),
    ],
)
def test_a_pivoted_body_has_the_inertia_and_the_weight_that_were_given(mass, centre, inertia):
    m, r, moments, axes = on_a_pivot(mass, np.array(centre), inertia)
    A = Rotation.from_quat(axes[[1, 2, 3, 0]]).as_matrix()
    about = A @ np.diag(moments) @ A.T + m * (r @ r * np.eye(3) - np.outer(r, r))
    np.testing.assert_allclose(about, inertia, rtol=0, atol=1e-14 * np.abs(inertia).max())
    assert np.array_equal(m * r, mass * np.array(centre))
    assert np.all(moments > 0.0) and 2.0 * moments.max() <= moments.sum()


def test_the_model_has_the_numbers_bit_for_bit():
    system = PROBLEMS["3D pendulum, skew"].system
    body = mujoco_body.mujoco_body(system)
    _, model, _ = mujoco_engine.compiled(system)
    assert np.array_equal(model.body_inertia[1], body.moments)
    assert np.array_equal(model.body_ipos[1], body.centre)
    assert np.array_equal(model.opt.gravity, body.gravity) and model.body_mass[1] == body.mass


@pytest.mark.parametrize("name", PROBLEMS)
def test_mujocos_own_energies_are_those_of_the_problem(name):
    problem = PROBLEMS[name]
    run = MUJOCO_RK4.run(problem, 1.0, {"step": 2.0**-9, "save_every": 64})
    potential, kinetic = energies(run).T
    system = problem.system
    size = kinetic.max() + np.abs(potential).max()
    ours = 0.5 * np.sum(run.p * system.velocity(run.p), axis=-1)
    np.testing.assert_allclose(kinetic, ours, atol=1e-14 * size)  # 2e-15
    np.testing.assert_allclose(potential, system.potential_energy(run.q, run.t), atol=1e-14 * size)
    total = potential + kinetic
    assert np.abs(total - total[0]).max() < 1e-11 * size  # 1e-12


@pytest.mark.parametrize(
    "problem",
    [
        galvi.Problem(galvi.RigidBody(SKEW, lambda R: R[2, 2]), TILT, SPIN),
        galvi.Problem(galvi.RigidBody(SKEW, LEVER, lambda R: 0.0 * R, check=False), TILT, SPIN),
        galvi.Problem(galvi.Canonical(1.0, galvi.CosinePotential(1.0)), [1.0, 2.0], [0.0, 0.0]),
        galvi.Problem(
            galvi.Canonical(1.0, galvi.CosinePotential(1.0), lambda q: q, check=False), [1.0], [0.0]
        ),
        galvi.problems.kepler(),
    ],
    ids=["any potential", "a gradient of its own", "two pendulums", "another force", "no body"],
)  # fmt: skip
def test_other_problems_are_not_taken(problem):
    assert not any(contender.supports(problem) for contender in ALL)
    with pytest.raises(ValueError, match="MuJoCo RK4 does not solve"):
        MUJOCO_RK4.run(problem, 1.0, {"step": 0.1})


def test_a_body_that_mujoco_refuses_is_a_sentence():
    tiny = galvi.Problem(galvi.RigidBody(1e-18 * SKEW), TILT, SPIN)
    with pytest.raises(
        ValueError, match=r"^MuJoCo refuses this body: .*mjMINVAL.*Give it in units"
    ):
        MUJOCO_RK4.run(tiny, 1.0, {"step": 0.1})


def test_an_absent_or_old_mujoco_is_a_sentence(monkeypatch):
    for found, word in ((None, "mujoco"), ("4.0.0", "4.0.0 has known"), ("3.17.0", "3.17.0")):
        fake = None if found is None else SimpleNamespace(__version__=found)
        monkeypatch.setitem(sys.modules, "mujoco", fake)
        assert word in MUJOCO_RK4.missing
        assert MUJOCO_RK4.missing.endswith("Install mujoco-core 4.0.1 or newer.")
        with pytest.raises(ModuleNotFoundError, match=r"MuJoCo RK4 cannot run: .*mujoco"):
            MUJOCO_RK4.run(TILTED, 1.0, {"step": 0.1})


def test_an_integrator_that_a_version_has_not_is_missing(monkeypatch):
    fake = SimpleNamespace(__version__="10.0", mjtIntegrator=SimpleNamespace(mjINT_RK4=1))
    monkeypatch.setitem(sys.modules, "mujoco", fake)
    assert MUJOCO_RK4.missing == ""
    assert MUJOCO_DISCRETE.missing == "mujoco 10.0 has no integrator discrete."


def test_the_version_is_in_the_method():
    run = MUJOCO_RK4.run(TILTED, 1.0, {"step": 0.1})
    assert run.method == f"MuJoCo RK4 step=0.1 (mujoco {mujoco.__version__})"
