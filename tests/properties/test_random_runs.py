"""Random problems, methods and steps: runs of the fast engines agree with the general kernel, or
their status has a remark; and few runs that are right have a remark."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import galvi

ready = galvi.problems
RUNS, STEPS = 500, 40
NUDGE = 1e-13  # relative change of the start, which shows how rounding errors grow in a run
RIGHT_ERROR = 1e-6  # relative error of the end below which a remark is a false alarm
ALLOWED_GROWTH = (
    300.0  # allowed difference, in units of that growth: each step adds rounding errors
)


def pair(e: float) -> galvi.Problem:
    orbit, mass_fractions = ready.kepler(e), np.array([1.0, 2.0]) / 3.0
    weights = np.array([-mass_fractions[1], mass_fractions[0]])
    return galvi.Problem(
        galvi.NBody(mass_fractions), np.outer(weights, orbit.q0), np.outer(weights, orbit.v0)
    )


def three_bodies(e: float) -> galvi.Problem:
    """Three bodies, one of them light, whose centre of mass moves."""
    masses = np.array([1.0, 0.3, 1e-4])
    q = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.05 * (1.0 + e)]])
    speed = np.sqrt(0.3 / 0.05 * (1.0 - e) / (1.0 + e))
    v = np.array([[0.5, 0.0], [0.5, 1.1], [0.5 - speed, 1.1]])
    return galvi.Problem(galvi.NBody(masses), q, v)


SERVOS = """<mujoco><worldbody><body>
<joint name="hip" axis="0 1 0" damping=".3"/>
<inertial pos="0 0 -.3" mass="1.2" diaginertia=".05 .04 .02"/>
<body pos="0 0 -.6"><joint name="knee" axis="0 1 0"/>
<inertial pos="0 0 -.2" mass=".6" diaginertia=".02 .02 .01"/></body></body></worldbody>
<actuator><position joint="hip" kp="40" kv="4"/><position joint="knee" kp="20" kv="2"/></actuator>
</mujoco>"""
DRAGGED = galvi.Canonical(
    1.0, galvi.LinearSpring(1.0), force=lambda q, v: -0.2 * np.sqrt(v @ v) * v
)
DRIVEN = galvi.Canonical(
    1.0,
    lambda q: 1.0 - np.cos(q[0]),
    force=lambda q, v, t: 1.5 * np.sin(0.7 * t) - 0.1 * v,
    timed_force=True,
)
DAMPED = galvi.RigidBody((1.0, 2.0, 2.5), force=lambda R, w: -0.1 * w)


@cache
def servos() -> galvi.Problem:
    return galvi.from_mujoco(SERVOS, ctrl=[0.3, -0.2])


def arm(knee: float) -> galvi.Problem:
    return servos().with_initial_state([0.7, knee], [0.5, 1.0])


# Name -> function of a random number in [0, 1) to the problem, and the time scale of its motion.
PROBLEMS: dict[str, tuple[Callable[[float], galvi.Problem], float]] = {
    "Kepler": (lambda x: ready.kepler(0.95 * x), 1.0),
    "a pair": (lambda x: pair(0.9 * x), 1.0),
    "three bodies": (lambda x: three_bodies(0.5 * x), 0.05),
    "outer planets": (lambda x: ready.outer_solar_system(), 690.0),
    "Henon-Heiles": (lambda x: ready.henon_heiles(0.02 + 0.13 * x), 1.0),
    "oscillator": (lambda x: ready.harmonic_oscillator(), 1.0),
    "lattice": (lambda x: ready.fermi_pasta_ulam_tsingou(8, 0.1 + x), 0.5),
    "elastic pendulum": (lambda x: ready.elastic_pendulum(extended=1.0 + x), 0.15),
    "double pendulum": (lambda x: ready.double_pendulum(angles=(2.5 * x, 1.0)), 0.2),
    "chain": (lambda x: ready.planar_chain(3, angle=0.2 + 1.2 * x), 0.15),
    "polar Kepler": (lambda x: ready.kepler_polar(0.5 * x), 1.0),
    "free body": (lambda x: ready.free_rigid_body(velocity=(2.0, -2.0 * x, 1.0)), 0.4),
    "pendulum on SO(3)": (lambda x: ready.pendulum_3d(3.0 + 7.0 * x), 0.3),
    "top": (lambda x: ready.heavy_top(4.0 + 6.0 * x), 0.1),
    "servos": (lambda x: arm(-0.4 * x), 0.15),
    "drag": (lambda x: galvi.Problem(DRAGGED, [1.0, 0.0], [0.0, 0.3 + x]), 0.5),
    "a driven pendulum": (lambda x: galvi.Problem(DRIVEN, [x], [0.0]), 0.5),
    "a damped body": (lambda x: galvi.Problem(DAMPED, np.eye(3), [1.0, x, 2.0]), 0.5),
    "a grain": (lambda x: ready.brownout(1e-4 * (1.0 + x)), 0.5),
}
CLOCKS = {
    "Kepler": galvi.Sundman(),
    "a pair": galvi.DynamicalTime(),
    "three bodies": galvi.DynamicalTime(),
}
RULES = (lambda s: galvi.gauss(s), lambda s: galvi.gauss(2 * s), lambda s: galvi.lobatto(s + 1))


def run_or_none(problem: galvi.Problem, method: Any, step: float, **options: Any) -> Any:
    try:
        return galvi.integrate(problem, method, step, STEPS, **options)
    except ValueError:  # a step that a clock refuses
        return None


def distance(left: Any, right: Any) -> float:
    """The largest difference of the last states, relative to the largest entry of a state."""
    return float(
        max(
            np.max(np.abs(a[-1] - b[-1])) / np.max(np.abs(b))
            for a, b in ((left.q, right.q), (left.p, right.p))
        )
    )


def random_case(number: int) -> tuple[str, galvi.Problem, galvi.Galerkin, float]:
    """A random problem with its name, a method and a step."""
    rng = np.random.Generator(np.random.Philox(number))
    name = list(PROBLEMS)[rng.integers(len(PROBLEMS))]
    make, unit = PROBLEMS[name]
    problem, degree = make(rng.random()), int(rng.integers(2, 21))
    rule, step = RULES[rng.integers(len(RULES))](degree), unit * 10.0 ** rng.uniform(-2.0, 0.3)
    clock = CLOCKS.get(name) if rng.random() < 0.5 else None
    step *= -1.0 if rng.random() < 0.2 else 1.0
    if clock is not None:
        step *= 0.5 / unit
    method = galvi.Galerkin(galvi.Polynomials(degree), rule, clock=clock)
    return name, problem, method, step


def finer_run(problem: galvi.Problem, step: float, clock: Any, run: Any) -> galvi.Trajectory:
    """The run to the same time with a higher degree, and in smaller steps."""
    points = 16 if clock is None else 20
    method = galvi.Galerkin(galvi.Polynomials(points), galvi.gauss(points), clock=clock)
    if clock is None:
        return galvi.integrate(problem, method, step / 8, 8 * STEPS)
    return galvi.integrate(problem, method, 0.1 * np.sign(step), duration=abs(run.t[-1]))


def compared(number: int) -> tuple[str, str]:
    """The verdict on one random run, and its description.

    The verdicts are "alike", "said" for a remark, "false alarm" for a remark on a right run, "not
    compared" and "WRONG".
    """
    name, problem, method, step = random_case(number)
    clock, rule = method.clock, method.rule
    description = (
        f"{number}: {name}, degree {method.space.degree}, {rule.name}, {clock}, step {step!r}"
    )
    fast = run_or_none(problem, method, step)
    if fast is None or fast.engine == "general":
        return "said" if fast is None else "not compared", description
    if not fast.status.startswith("Completed."):
        run_is_right = is_right(problem, step, clock, fast)
        return "false alarm" if run_is_right else "said", f"{description}: {fast.status}"
    slow = run_or_none(problem, method, step, solver="newton")
    nudged = nudged_run(problem, method, step)
    if slow is None or nudged is None or not (slow.success and nudged.success):
        return "not compared", description
    allowed_difference = ALLOWED_GROWTH * max(distance(nudged, slow), NUDGE)
    if name == "three bodies" and clock is not None:  # a light body: other equations, H - E0 alike
        finer = finer_run(problem, step, clock, fast)
        allowed_difference += 100.0 * distance(fast, finer) if finer.success else np.inf
        slow = finer if finer.success else slow
    difference = distance(fast, slow)
    if (
        difference > allowed_difference and clock is None
    ):  # a step so long that its equations have several solutions
        finer = finer_run(problem, step, clock, fast)
        if 0.1 < distance(fast, finer) <= 2.0 * distance(slow, finer):
            return "not compared", description
    return (
        "alike" if difference <= allowed_difference else "WRONG",
        f"{description}: {difference:.1e}, allowed {allowed_difference:.1e}",
    )


def is_right(problem: galvi.Problem, step: float, clock: Any, run: Any) -> bool:
    """Whether the end of the run agrees with that of a finer one to RIGHT_ERROR."""
    if not np.isfinite(run.q[-1]).all():
        return False
    finer = finer_run(problem, step, clock, run)
    return finer.success and distance(run, finer) < RIGHT_ERROR


def nudged_run(problem: galvi.Problem, method: galvi.Galerkin, step: float) -> Any:
    """The run by the general kernel from a start times 1 + NUDGE; None where it is refused."""
    on_space = problem.q0.shape == problem.v0.shape
    q0 = problem.q0 * (1.0 + NUDGE) if on_space else problem.q0
    nudged = problem.with_initial_state(q0, problem.v0 * (1.0 + NUDGE))
    return run_or_none(nudged, method, step, solver="newton")


@pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
@pytest.mark.slow(beside="tests/agreement/test_agreement.py::test_drawn_cells_agree")
def test_random_runs_are_those_of_the_general_kernel_or_say_that_they_are_not() -> None:
    comparisons = [compared(number) for number in range(RUNS)]
    assert [description for verdict, description in comparisons if verdict == "WRONG"] == []
    counts = Counter(verdict for verdict, _ in comparisons)
    assert counts["alike"] > 0.6 * RUNS and counts["said"] < 0.3 * RUNS, counts
    alarms = [description for verdict, description in comparisons if verdict == "false alarm"]
    assert len(alarms) <= 0.01 * counts["alike"], alarms
