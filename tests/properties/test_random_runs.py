"""Random problems, methods and steps: the fast engines against the general kernel, or said; and a
remark in a status means something: right runs have none, but for one in a hundred."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import galvi

ready = galvi.problems
MANY, STEPS = 500, 40
NUDGE = 1e-13  # relative, of the start: how much an error of rounding grows in a run
RIGHT = 1e-6  # error of the end, relative, of a run of which nothing need be said
ALIKE = 300.0  # times that growth: what rounding in each of the steps may add to


def pair(e: float) -> galvi.Problem:
    orbit, share = ready.kepler(e), np.array([1.0, 2.0]) / 3.0
    way = np.array([-share[1], share[0]])
    return galvi.Problem(galvi.NBody(share), np.outer(way, orbit.q0), np.outer(way, orbit.v0))


def moon(e: float) -> galvi.Problem:
    """Three bodies of which one is light, boosted."""
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


# name -> (of a random number in [0, 1), the problem), and about the time in which it moves
PROBLEMS: dict[str, tuple[Callable[[float], galvi.Problem], float]] = {
    "Kepler": (lambda x: ready.kepler(0.95 * x), 1.0),
    "a pair": (lambda x: pair(0.9 * x), 1.0),
    "three bodies": (lambda x: moon(0.5 * x), 0.05),
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


def ended(problem: galvi.Problem, method: Any, step: float, **options: Any) -> Any:
    try:
        return galvi.integrate(problem, method, step, STEPS, **options)
    except ValueError:  # a step that a clock refuses
        return None


def distance(left: Any, right: Any) -> float:
    """Of two ends, relative to the size of the states."""
    return float(
        max(
            np.max(np.abs(a[-1] - b[-1])) / np.max(np.abs(b))
            for a, b in ((left.q, right.q), (left.p, right.p))
        )
    )


def drawn(number: int) -> tuple[str, galvi.Problem, galvi.Galerkin, float]:
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


def true_run(problem: galvi.Problem, step: float, clock: Any, run: Any) -> galvi.Trajectory:
    """Another one to the same end, of higher degree and in smaller steps."""
    points = 16 if clock is None else 20
    finer = galvi.Galerkin(galvi.Polynomials(points), galvi.gauss(points), clock=clock)
    if clock is None:
        return galvi.integrate(problem, finer, step / 8, 8 * STEPS)
    return galvi.integrate(problem, finer, 0.1 * np.sign(step), duration=abs(run.t[-1]))


def outcome(number: int) -> tuple[str, str]:
    """How one random run compares, and what it was: "alike", "said", "false alarm", where something
    is said of a right run, "not compared" or "WRONG"."""
    name, problem, method, step = drawn(number)
    clock, rule = method.clock, method.rule
    description = (
        f"{number}: {name}, degree {method.space.degree}, {rule.name}, {clock}, step {step!r}"
    )
    fast = ended(problem, method, step)
    if fast is None or fast.engine == "general":
        return "said" if fast is None else "not compared", description
    if not fast.status.startswith("Completed."):
        alarm = is_right(problem, step, clock, fast)
        return "false alarm" if alarm else "said", f"{description}: {fast.status}"
    slow = ended(problem, method, step, solver="newton")
    moved = nudged_end(problem, method, step)
    if slow is None or moved is None or not (slow.success and moved.success):
        return "not compared", description
    allowed = ALIKE * max(distance(moved, slow), NUDGE)
    if name == "three bodies" and clock is not None:  # a light body: other equations, H - E0 alike
        true = true_run(problem, step, clock, fast)
        allowed += 100.0 * distance(fast, true) if true.success else np.inf
        slow = true if true.success else slow
    off = distance(fast, slow)
    if off > allowed and clock is None:  # a step so long that its equations have several solutions
        true = true_run(problem, step, clock, fast)
        if 0.1 < distance(fast, true) <= 2.0 * distance(slow, true):
            return "not compared", description
    return (
        "alike" if off <= allowed else "WRONG",
        f"{description}: {off:.1e}, allowed {allowed:.1e}",
    )


def is_right(problem: galvi.Problem, step: float, clock: Any, run: Any) -> bool:
    """Whether the run's end is that of a finer one."""
    if not np.isfinite(run.q[-1]).all():
        return False
    true = true_run(problem, step, clock, run)
    return true.success and distance(run, true) < RIGHT


def nudged_end(problem: galvi.Problem, method: galvi.Galerkin, step: float) -> Any:
    """The run by the general kernel from a start that is off by NUDGE."""
    on_space = problem.q0.shape == problem.v0.shape
    q0 = problem.q0 * (1.0 + NUDGE) if on_space else problem.q0
    nudged = problem.with_initial_state(q0, problem.v0 * (1.0 + NUDGE))
    return ended(nudged, method, step, solver="newton")


@pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
@pytest.mark.slow(beside="tests/agreement/test_agreement.py::test_drawn_cells_agree")
def test_random_runs_are_those_of_the_general_kernel_or_say_that_they_are_not() -> None:
    outcomes = [outcome(number) for number in range(MANY)]
    assert [description for how, description in outcomes if how == "WRONG"] == []
    counts = Counter(how for how, _ in outcomes)
    assert counts["alike"] > 0.6 * MANY and counts["said"] < 0.3 * MANY, counts
    alarms = [description for how, description in outcomes if how == "false alarm"]
    assert len(alarms) <= 0.01 * counts["alike"], alarms
