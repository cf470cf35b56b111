"""Assessment of runs with forces: energy less work, damping faster than a step, singular masses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import galvi
from galvi import End
from galvi.run import work_of_forces


def method(s: int, rule: Any = None) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(s), rule or galvi.gauss(s))


def damped_hinge(damping: float) -> galvi.Problem:
    """A hinge with moment of inertia 1, without gravity: v' = -damping v."""
    joint = galvi.Joint("hinge", axis=(0, 0, 1), damping=damping)
    link = galvi.Link(joint, 1.0, (0, 0, 0), 1.0)
    return galvi.Problem(galvi.Multibody([link], gravity=(0, 0, 0)), [0.0], [1.0])


def damped_oscillator(damping: float) -> galvi.Problem:
    system = galvi.Canonical(1.0, lambda q: 0.5 * q[0] ** 2, force=lambda q, v: -damping * v)
    return galvi.Problem(system, [0.0], [1.0])


DAMPED = {"a joint's damper": damped_hinge, "a user's force": damped_oscillator}


def named_step(run: galvi.Trajectory) -> float:
    """The step that a run's remedy names."""
    return float(run.outcome.remedy.partition("a step of ")[2].split()[0])


@pytest.mark.parametrize("name", DAMPED)
@pytest.mark.parametrize("s", [2, 3])
def test_a_damper_that_gives_energy_ruins_a_run(name: str, s: int) -> None:
    """In long steps Gauss's rule does not damp velocities, and Radau's multiplies them."""
    for rule, end in ((galvi.radau, End.RUINED), (galvi.gauss, End.DOUBTFUL)):
        run = galvi.integrate(DAMPED[name](20.0), method(s, rule(s)), 1.0, 40)
        assert run.outcome.end is end
        assert (np.max(np.abs(galvi.energy(run))) > 10.0) == (end is End.RUINED)
        assert "damped a velocity in 1/20 of a step" in run.outcome.reason


@pytest.mark.parametrize("name", DAMPED)
@pytest.mark.parametrize(("s", "save_every", "step"), [(2, 7, 0.2), (8, 1, -0.2)])
def test_a_damper_that_a_step_resolves_is_not_named(
    name: str, s: int, save_every: int, step: float
) -> None:
    run = galvi.integrate(DAMPED[name](0.5), method(s), step, 300, save_every=save_every)
    assert run.outcome.end is End.COMPLETED


WRIST = """<mujoco><option gravity="0 0 0"/><worldbody><body><joint name="wrist" axis="0 0 1"/>
<inertial pos="0 0 0" mass=".5" diaginertia="1e-3 1e-3 1e-3"/></body></worldbody>
<actuator><position joint="wrist" kp="500" kv="50"/></actuator></mujoco>"""


def wrist(v: float) -> galvi.Problem:
    """Rates of 5e4 and 10 per second: v falls to 10 (0.1 - q) at once."""
    return galvi.from_mujoco(WRIST, ctrl=[0.1]).with_initial_state([0.0], [v])


@pytest.mark.parametrize(("s", "step"), [(4, 0.02), (8, 0.002)])
def test_a_servo_too_stiff_for_a_step_is_named_with_the_step_that_does(s: int, step: float) -> None:
    problem = wrist(2.0)
    run = galvi.integrate(problem, method(s), step, 10)
    assert f"damped a velocity in 1/{step * 5e4:,.0f} of a step" in run.outcome.reason
    stated_error = float(run.outcome.reason.partition("wrong by about ")[2].split()[0])
    q, v = run.q[1, 0], problem.system.velocity(run.p[1], run.q[1])[0]
    assert abs(v - 10.0 * (0.1 - q)) / 2.0 == pytest.approx(stated_error, rel=0.3)
    fine = galvi.integrate(problem, method(s), named_step(run), 200)
    assert fine.outcome.end is End.COMPLETED
    v = problem.system.velocity(fine.p[-1], fine.q[-1])[0]
    assert v == pytest.approx(10.0 * (0.1 - fine.q[-1, 0]), rel=1e-3)


def test_a_stiff_servo_whose_fast_motion_is_not_excited_is_not_named() -> None:
    run = galvi.integrate(wrist(1.0), method(8), 0.02, 10)
    assert run.outcome.end is End.COMPLETED
    v = run.problem.system.velocity(run.p[-1], run.q[-1])[0]
    assert v == pytest.approx(np.exp(-10.0 * 0.2), rel=1e-3)


@pytest.mark.slow(beside="test_a_servo_too_stiff_for_a_step_is_named_with_the_step_that_does")
def test_the_step_of_a_stiff_servo_is_recommended_for_its_velocities() -> None:
    choice = galvi.recommend(wrist(2.0), 1e-4, 0.02)
    assert choice.reached
    assert abs(choice.step) * 5e4 < 2.0 * choice.method.stages


def gimbal(damping: float, angle: float, v: Any) -> galvi.Problem:
    hinges = "".join(
        f'<joint axis="{a}" damping="{damping}"/>' for a in ("1 0 0", "0 1 0", "0 0 1")
    )
    model = f"""<mujoco><worldbody><body>{hinges}<inertial pos="0 0 .1" mass=".5"
    diaginertia=".004 .005 .002"/></body></worldbody></mujoco>"""
    return galvi.from_mujoco(model).with_initial_state([0.0, angle, 0.0], v)


@pytest.mark.parametrize(
    ("damping", "angle", "step", "steps"),
    [
        (0.0, 0.0, 0.01, 1000),
        (1e-12, 0.5 * np.pi - 0.1, 0.01, 100),
        (0.0, 0.5 * np.pi - 0.3, 0.001, 1000),
        (0.0, 0.0, 0.001, 1000),
    ],
)
def test_gimbal_lock_is_named_with_its_remedy(
    damping: float, angle: float, step: float, steps: int
) -> None:
    """Also for a start near the lock, where the energy does not show the wrong attitude."""
    run = galvi.integrate(gimbal(damping, angle, [1e-3, 3.0, 0.0]), method(8), step, steps)
    assert run.outcome.end is not End.COMPLETED
    assert "gimbal lock" in run.status and "Use a ball joint" in run.status
    regular = galvi.integrate(gimbal(1e-12, 0.0, [1.0, 0.3, 0.4]), method(8), 0.01, 100)
    assert regular.outcome.end is End.COMPLETED


def test_another_mass_matrix_that_is_nearly_singular_is_no_gimbal_lock() -> None:
    """A light slide carries a heavy pendulum, which a smaller step solves."""
    slide = """<mujoco><worldbody><body><joint type="slide" axis="1 0 0"/><inertial pos="0 0 0"
    mass="1e-3" diaginertia="1e-6 1e-6 1e-6"/><body><joint axis="0 1 0"/><inertial pos="0 0 -1"
    mass="1" diaginertia="1e-6 1e-6 1e-6"/></body></body></worldbody></mujoco>"""
    problem = galvi.from_mujoco(slide).with_initial_state([0.0, 1.57], [0.0, 0.0])
    run = galvi.integrate(problem, method(8), 0.02, 100)
    assert "lock" not in run.status and "Use a smaller step" in run.status


SPRINGS = """<mujoco><worldbody><site name="top" pos=".3 0 .2"/><body gravcomp="{}">
<joint name="h" axis="0 1 0" stiffness="2 1.5 .7"/>
<inertial pos="0 0 -.4" mass="1" diaginertia=".1 .1 .1"/><body pos="0 0 -.8">
<joint name="k" axis="1 0 0"/><inertial pos="0 0.1 -.4" mass=".5" diaginertia=".1 .1 .1"/>
<site name="tip" pos="0 0 -.5"/></body></body></worldbody><tendon>
<fixed stiffness="200"><joint joint="h" coef="1"/><joint joint="k" coef="-.5"/></fixed>
<spatial stiffness="30 4 2" springlength=".3 .6"><site site="top"/><site site="tip"/></spatial>
</tendon></mujoco>"""


def test_springs_of_tendons_and_held_weights_are_in_the_energy() -> None:
    """Without them the energy would range over 26 J of 20 J."""
    problem = galvi.from_mujoco(SPRINGS.format(0.7)).with_initial_state([0.4, 0.2], [1.0, -0.3])
    run = galvi.integrate(problem, method(8), 0.01, 200)
    energy = galvi.energy(run)
    assert np.ptp(energy) < 1e-12 * abs(energy[0])
    energies_between = galvi.energy(run, np.linspace(0.0, 2.0, 37))
    assert np.ptp(energies_between) < 1e-6 * abs(energy[0])
    assert "the energy changed by" in galvi.integrate(problem, method(2), 0.5, 40).status


def test_energies_of_springs_of_tendons_are_mujocos_also_where_they_are_slack() -> None:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(SPRINGS.format(0.0))
    mj_data, problem = mujoco.MjData(model), galvi.from_mujoco(SPRINGS.format(0.0))
    differences, lengths = [], []
    for q in np.random.default_rng(3).uniform(-3.1, 3.1, (200, 2)):
        mj_data.qpos[:] = q
        mujoco.mj_forward(model, mj_data)
        mujoco.mj_energyPos(model, mj_data)
        differences.append(problem.system.energy(q, 0.0 * q, 0.0) - mj_data.energy[0])
        lengths.append(mj_data.ten_length[1])
    assert np.ptp(differences) < 1e-11 and min(lengths) < 0.3 < 0.6 < max(lengths)


def test_a_force_that_raises_in_the_assessment_is_no_crash() -> None:
    calls = [0]

    def force(q: Any, v: Any) -> Any:
        calls[0] += 1
        if calls[0] > limit:
            raise RuntimeError("no more")
        return np.array([-0.1 * float(v[0])])

    limit = 10**9
    system = galvi.Canonical(1.0, lambda q: 0.5 * q[0] ** 2, lambda q: q, force=force)
    problem = galvi.Problem(system, [1.0], [0.0])
    for _ in range(2):  # the first one checks the functions
        calls[0] = 0
        galvi.integrate(problem, method(2), 0.1, 5, solver="newton")
    needed_calls, calls[0] = calls[0], 0
    limit = needed_calls - 3
    run = galvi.integrate(problem, method(2), 0.1, 5, solver="newton")
    assert "could not be assessed" in run.status and "no more" in run.status


@pytest.mark.parametrize(("s", "z"), [(1, 7.0), (2, 0.1), (4, 1000.0)])
def test_growth_is_what_a_step_does(s: int, z: float) -> None:
    run = galvi.integrate(damped_hinge(z), method(s), 1.0, 1, solver="newton")
    assert run.p[-1, 0] == pytest.approx(work_of_forces.growth(method(s).table, z), abs=1e-10)


def pulse(centre: float, width: float = 1.0) -> galvi.Problem:
    """A free particle, which a short push takes from 1 to 1 + 5 width sqrt(pi)."""
    system = galvi.Canonical(
        1.0,
        lambda q: 0.0 * q[0],
        lambda q: 0.0 * q,
        timed_force=True,
        force=lambda q, v, t: np.array([5.0 * np.exp(-(((t - centre) / width) ** 2))]),
    )
    return galvi.Problem(system, [0.0], [1.0])


@pytest.mark.parametrize(("centre", "save_every"), [(137.0, 1), (30.0, 100), (171.3, 100)])
def test_a_push_between_the_states_that_are_looked_at_is_no_fault(
    centre: float, save_every: int
) -> None:
    run = galvi.integrate(pulse(centre), method(4), 0.1, 2000, save_every=save_every)
    assert run.outcome.end is End.COMPLETED
    assert run.p[-1, 0] == pytest.approx(1.0 + 5.0 * np.sqrt(np.pi), abs=1e-8)


DOUBLE = """<mujoco><worldbody><body><joint axis="0 1 0" damping=".1"/><inertial pos="0 0 -.4"
mass="1" diaginertia=".02 .03 .01"/><body pos="0 0 -.8"><joint axis="0 1 0" damping=".1"/>
<inertial pos="0 0 -.4" mass="1" diaginertia=".02 .03 .01"/></body></body></worldbody></mujoco>"""


@pytest.mark.parametrize(("seed", "steps", "save_every"), [(0, 1, 1), (2, 100, 1), (3, 100, 7)])
def test_a_damped_tree_from_rest_has_no_remark(seed: int, steps: int, save_every: int) -> None:
    q = np.random.default_rng(seed).uniform(-1.5, 1.5, 2)
    problem = galvi.from_mujoco(DOUBLE).with_initial_state(q, [0.0, 0.0])
    run = galvi.integrate(problem, method(8), 0.01, steps, save_every=save_every)
    assert run.outcome.end is End.COMPLETED


def vanishing_damper(q: Any, v: Any, t: float) -> Any:
    return np.array([-20.0 * v[0] if t < 5.5 else 0.0])


def test_a_run_that_was_ruined_stays_so_after_good_steps() -> None:
    system = galvi.Canonical(
        1.0,
        lambda q: 0.0 * q[0],
        lambda q: 0.0 * q,
        timed_force=True,
        force=vanishing_damper,
    )
    start = galvi.Problem(system, [0.0], [1.0])
    run = galvi.integrate(start, method(2, galvi.radau(2)), 1.0, 6)
    for _ in range(2):
        run = galvi.resume(run, 10)
        assert run.outcome.end is End.RUINED and run.failed_step == 1
        assert "had ruined it" in run.outcome.reason


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_mirrored_run_is_assessed_alike(sign: float) -> None:
    """Damping and driving forces, for either sign of the step."""
    for rate, verb in ((-50.0, "damped"), (50.0, "increased")):
        system = galvi.Canonical(
            1.0, galvi.LinearSpring(1.0), force=lambda q, v, rate=sign * rate: rate * v
        )
        problem = galvi.Problem(system, [0.0], [1e-3])
        run = galvi.integrate(problem, method(2), sign * 0.2, 20)
        assert f"forces have {verb} a velocity in 1/10 of a step" in run.status


def test_a_single_step_that_multiplies_the_energy_is_ruined() -> None:
    run = galvi.integrate(damped_hinge(1000.0), method(2, galvi.radau(2)), 1.0, 1)
    assert not run.success and galvi.energy(run)[-1] > 1e5


@pytest.mark.parametrize(("mass", "speed"), [(10.0, 30.0), (500.0, 7500.0)])
def test_a_stiff_wrist_is_named_on_a_base_of_any_energy(mass: float, speed: float) -> None:
    body = WRIST.split("<worldbody>")[1].split("</worldbody>")[0]
    model = WRIST.replace(
        body,
        f"""<body><joint type="slide" axis="1 0 0"/><inertial pos="0 0 0" mass="{mass}"
        diaginertia="1 1 1"/>{body}</body>""",
    )
    start = galvi.from_mujoco(model, ctrl=[0.1]).with_initial_state([0.0, 0.0], [speed, 2.0])
    run = galvi.integrate(start, method(8), 0.02, 10)
    assert "wrong by about 0.4 of its largest value" in run.status


def test_planted_the_work_by_the_rule_itself_sees_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Gauss's method keeps a quadratic energy less the work by its own rule, for any step."""
    problem = wrist(2.0)
    assert galvi.integrate(problem, method(8), 0.02, 10).outcome.end is End.DOUBTFUL
    monkeypatch.setattr(work_of_forces, "unresolved_rate", lambda *arguments: None)
    blind = galvi.integrate(problem, method(8), 0.02, 10)
    assert blind.outcome.end is End.COMPLETED


def test_a_driven_pendulum_is_right_whatever_its_energy_does() -> None:
    """It starts from rest, so that all of its energy is work."""
    system = galvi.Canonical(
        1.0,
        lambda q: 1.0 - np.cos(q[0]),
        force=lambda q, v, t: np.array([2.0 * np.sin(t)]),
        timed_force=True,
    )
    run = galvi.integrate(galvi.Problem(system, [0.0], [0.0]), method(6), 0.1, 400)
    assert run.outcome == galvi.Outcome(End.COMPLETED, steps=400)
    assert np.ptp(galvi.energy(run)) > 1.0
