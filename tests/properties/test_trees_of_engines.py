"""Models that others wrote, as trees: what they have beyond, and their motion against MuJoCo's."""

import numpy as np
import pytest

import galvi
from tests.properties.engine_models import MODELS, path_of
from tests.properties.random_trees import random_state
from tests.properties.tree_equations import defects

mujoco = pytest.importorskip("mujoco")


@pytest.fixture(autouse=True)
def quiet():
    """MuJoCo's warnings of deprecated attributes would be written to a file."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda message: None)
    yield
    mujoco.set_mju_user_warning(before)


def without(model, parts):
    """The model with what galvi leaves out disabled."""
    flags = mujoco.mjtDisableBit
    model.opt.disableflags |= int(flags.mjDSBL_CONSTRAINT) | int(flags.mjDSBL_ACTUATION)
    if "fluid" in parts:
        model.opt.density = model.opt.viscosity = 0.0
    if "tendons" in parts:
        model.tendon_stiffness[:] = 0.0
        model.tendon_damping[:] = 0.0
    return model


@pytest.mark.parametrize("name", MODELS, ids=lambda name: name.replace("/", "-"))
def test_the_trees_of_a_model_move_as_in_mujoco_once_what_is_beyond_is_left_out(name):
    parts = MODELS[name]
    model = mujoco.MjModel.from_xml_path(str(path_of(name)))
    try:
        galvi.from_mujoco(model)
    except ValueError as refusal:
        lines = str(refusal).splitlines()
        named = {line.partition(":")[0].strip() for line in lines[1:-1]}
        assert named and named <= set(parts)  # actuators, tendons and others are read in part
    problem = galvi.from_mujoco(model, ignore=parts)
    found = [
        defects(without(model, parts), problem.system, *random_state(model, k)) for k in (0, 1)
    ]
    assert np.max(np.array(found)[:, 1:]) < 1e-12  # 2e-14


def test_a_model_of_a_suite_runs(tmp_path):
    problem = galvi.from_mujoco(path_of("dm_control/suite/acrobot.xml"), ignore="actuators")
    q, v = problem.system.from_mujoco([1.0, 0.5], [0.0, 0.0])
    eight = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    run = galvi.integrate(problem.with_initial_state(q, v), eight, 0.05, 100)
    assert run.success and "acrobot" in problem.name
