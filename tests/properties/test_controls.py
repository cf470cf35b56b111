"""Controls of actuators that change: the same law with other numbers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import galvi

mujoco = pytest.importorskip("mujoco")
METHOD = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
TICK = 0.002
ARM = """<mujoco><option timestep="0.0005" integrator="RK4"/><worldbody>
  <body><joint name="a" axis="0 1 0" damping="0.3"/><joint name="b" axis="1 0 0"/>
    <inertial pos="0 0 -0.2" mass="1" diaginertia="0.02 0.02 0.01"/>
    <body pos="0 0 -0.4"><joint name="c" axis="0 1 0"/>
      <inertial pos="0 0 -0.2" mass="0.5" diaginertia="0.01 0.01 0.005"/>
      <site name="nozzle" pos="0 0 -0.3" euler="20 30 0"/></body></body></worldbody>
  <tendon><fixed name="both"><joint joint="a" coef="1"/><joint joint="c" coef="-0.5"/></fixed>
  </tendon>
  <actuator>
    <motor name="pusher" joint="a" gear="2" ctrlrange="-3 3"/>
    <position name="servo" joint="b" kp="8" kv="0.2"/>
    <motor name="pull" tendon="both"/>
    <general name="stiff" joint="c" gaintype="affine" gainprm="0.5 0.4 -0.3" biastype="affine"
      biasprm="0.1 -1 -0.1"/>
    <motor name="jet" site="nozzle" gear="1 0.5 0 0 0 0.1" forcelimited="true" forcerange="-1 1"/>
  </actuator></mujoco>"""
U = np.random.default_rng(3).uniform(-1.5, 1.5, (50, 5))


def arm(ctrl: Any = None) -> galvi.Problem:
    return galvi.from_mujoco(ARM, ctrl=ctrl)


@pytest.mark.parametrize("k", range(2))
def test_with_numbers_is_the_model_read_with_these_controls(k: int) -> None:
    read, given = arm(U[k]).system, arm().system.with_numbers(ctrl=U[k])
    q, v = U[k + 1, :3], U[k + 2, :3]
    assert given.acceleration(q, v) == pytest.approx(read.acceleration(q, v), rel=1e-13, abs=1e-13)
    np.testing.assert_array_equal(given.force.numbers, read.force.numbers)
    again = given.with_numbers(ctrl=U[k + 1])  # from one to the next, without reading
    np.testing.assert_array_equal(again.force.numbers, arm(U[k + 1]).system.force.numbers)
    heavy = given.with_numbers(masses=[2.0, 1.0])  # keeps its controls
    assert heavy.with_numbers(masses=[1.0, 0.5]).acceleration(q, v) == pytest.approx(
        read.acceleration(q, v), rel=1e-12
    )


def test_ticks_of_resume_are_those_of_mujoco() -> None:
    problem = arm()
    first = replace(problem, system=problem.system.with_numbers(ctrl=U[0]))
    run = galvi.integrate(first, METHOD, TICK, 1)
    data = mujoco.MjData(mujoco.MjModel.from_xml_string(ARM))
    for k, u in enumerate(U):
        run = galvi.resume(run, 1, ctrl=u) if k else run
        data.ctrl[:] = u
        mujoco.mj_step(data.model, data, nstep=4)
    assert run.engine == "lanes" and run.t[-1] == pytest.approx(len(U) * TICK)
    assert run.q[-1] == pytest.approx(data.qpos, abs=1e-9)
    assert run.v[-1] == pytest.approx(data.qvel, abs=1e-7)


@pytest.mark.slow(beside="test_with_numbers_is_the_model_read_with_these_controls")
def test_members_with_controls_of_their_own() -> None:
    problem = arm()
    q, v = np.repeat(problem.q0[None], 4, axis=0), np.repeat(problem.v0[None], 4, axis=0)
    many = galvi.integrate_ensemble(problem, q, v, METHOD, TICK, 50, parameters={"ctrl": U[:4]})
    for k in range(4):
        one = galvi.integrate(arm(U[k]), METHOD, TICK, 50)
        assert np.asarray(many)[k, 0] == pytest.approx(one.q[-1], abs=1e-13)


def test_other_controls_do_not_compile_anew() -> None:
    from galvi.tracing.laws_of_systems import law_of

    zero, other = (arm().system.with_numbers(ctrl=u) for u in (np.zeros(5), U[0]))
    assert law_of(zero)[0] == law_of(other)[0] == law_of(arm().system)[0]


def test_a_planted_drive_that_keeps_its_slope_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    from galvi.systems.trees.joint_forces import Drive

    sound = Drive.law
    monkeypatch.setattr(Drive, "law", lambda drive, u: (sound(drive, u)[0], *sound(drive, 0.0)[1:]))
    with pytest.raises(ValueError, match="misreads this model"):
        arm(U[0])


@pytest.mark.slow(beside="tests/suite/reports/test_judge.py::test_sources_of_every_kind_are_judged")
def test_judge_takes_controls(tmp_path: Any) -> None:
    """A servo at ctrl 0 rests; with others it moves, in MuJoCo's run as in galvi's."""
    ctrl = np.array([0.5, 0.4, 0.0, 0.2, 0.3])
    found = galvi.judge(
        mujoco.MjModel.from_xml_string(ARM), 0.2, 1e-6, ctrl=ctrl, qpos=[0.1, 0.0, 0.0], quick=True
    )
    assert found.passed and found.own["error"] < 1e-8


def test_a_thruster_on_the_world_pushes_nothing() -> None:
    text = """<mujoco><worldbody><site name="w" pos="0.3 0.2 1"/>
      <body><joint axis="0 1 0"/><inertial pos="0 0 -0.2" mass="1" diaginertia=".2 .2 .1"/></body>
      </worldbody><actuator><motor site="w" gear="1 0 0 0 0 0"/></actuator></mujoco>"""
    run = galvi.integrate(galvi.from_mujoco(text), METHOD, TICK, 1)
    assert abs(galvi.resume(run, 50, ctrl=[3.0]).q[-1, 0]) < 1e-15


def test_a_gain_that_is_misread_is_caught_where_controls_are_0(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from galvi.interop import mujoco_forces

    sound = mujoco_forces._laws
    monkeypatch.setattr(
        mujoco_forces, "_laws", lambda model, k: ((2.0, 0.0, 0.0), sound(model, k)[1])
    )
    with pytest.raises(ValueError, match="misreads this model"):
        arm()


def test_resume_with_controls_refuses_what_it_cannot_keep(tmp_path: Any) -> None:
    brake = galvi.Event(lambda q, v, t: np.sin(np.pi * t / 0.01), action=lambda q, v, t: (q, 0 * v))
    run = galvi.integrate(arm(), METHOD, 0.005, 5, events=[brake])
    galvi.save(run, tmp_path / "run")
    for one in (run, galvi.load(tmp_path / "run")):
        with pytest.raises(ValueError, match="events"):
            galvi.resume(one, 1, ctrl=np.zeros(5))
    strong = ARM.replace('gear="2"', 'gear="2" forcelimited="true" forcerange="-1 1"')
    run = galvi.integrate(galvi.from_mujoco(strong), METHOD, TICK, 1)
    with pytest.raises(ValueError, match=r"actuator pusher is beyond its limits .* Choose other"):
        galvi.resume(run, 1, ctrl=[3.0, 0.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("limits", ["5 10", "-9 -4", "-0.2 0.8", "0 0.1"])
def test_ranges_need_not_hold_0_or_1(limits: str) -> None:
    text = ARM.replace('ctrlrange="-3 3"', f'ctrlrange="{limits}"')
    least, most = map(float, limits.split())
    found = galvi.from_mujoco(text).system.force
    assert least <= found.controls[0] <= most and least <= found.some_controls()[0] <= most
