"""Random problems, methods and steps: the fast engines against the general kernel, or said; and a
remark in a status means something: right runs have none, but for one in a hundred."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import galvi

ready = galvi.problems
MANY, STEPS = 500, 40
NUDGE = 1e-13  # relative, of the start: how much an error of rounding grows in a run
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


def distance(one: Any, other: Any) -> float:
    """Of two ends, relative to the size of the states."""
    return float(
        max(
            np.max(np.abs(a[-1] - b[-1])) / np.max(np.abs(b))
            for a, b in ((one.q, other.q), (one.p, other.p))
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


def outcome(number: int) -> tuple[str, str]:
    """How one random run compares: "alike", "said", "not compared" or "WRONG", and what it was."""
    name, problem, method, step = drawn(number)
    clock, rule = method.clock, method.rule
    words = f"{number}: {name}, degree {method.space.degree}, {rule.name}, {clock}, step {step!r}"
    fast = ended(problem, method, step)
    if fast is None or not fast.status.startswith("Completed.") or fast.engine == "general":
        return "said" if fast is None or fast.engine != "general" else "not compared", words
    slow = ended(problem, method, step, solver="newton")
    on_space = problem.q0.shape == problem.v0.shape
    q0 = problem.q0 * (1.0 + NUDGE) if on_space else problem.q0
    nudged = problem.with_initial_state(q0, problem.v0 * (1.0 + NUDGE))
    near = ended(nudged, method, step, solver="newton")
    if slow is None or near is None or not (slow.success and near.success):
        return "not compared", words
    allowed = ALIKE * max(distance(near, slow), NUDGE)
    if name == "three bodies" and clock is not None:  # a light body: other equations, H - E0 alike
        finer = galvi.Galerkin(galvi.Polynomials(20), galvi.gauss(20), clock=clock)
        true = galvi.integrate(problem, finer, 0.1 * np.sign(step), duration=abs(fast.t[-1]))
        allowed += 100.0 * distance(fast, true) if true.success else np.inf
        slow = true if true.success else slow
    off = distance(fast, slow)
    if off > allowed and clock is None:  # a step so long that its equations have several solutions
        finer = galvi.Galerkin(galvi.Polynomials(16), galvi.gauss(16))
        true = galvi.integrate(problem, finer, step / 8, 8 * STEPS)
        if 0.1 < distance(fast, true) <= 2.0 * distance(slow, true):
            return "not compared", words
    return "alike" if off <= allowed else "WRONG", f"{words}: {off:.1e}, allowed {allowed:.1e}"


@pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
@pytest.mark.slow(beside="tests/agreement/test_agreement.py::test_drawn_cells_agree")
def test_random_runs_are_those_of_the_general_kernel_or_say_that_they_are_not() -> None:
    found = [outcome(number) for number in range(MANY)]
    assert [words for how, words in found if how == "WRONG"] == []
    counts = Counter(how for how, _ in found)
    assert counts["alike"] > 0.6 * MANY and counts["said"] < 0.3 * MANY, counts


# ---------------------------------------------------------------- remarks

RIGHT = 1e-6  # error at all steps, of places and momenta, relative to their largest size in the run
SHARES = (0.03, 0.1, 0.3, 1.0)  # of the time in which a problem moves
DEGREES = (2, 4, 8, 12)

TREE = """<mujoco><option {medium}/><worldbody><site name="top" pos=".2 0 .3"/><body {weight}>
<joint name="hip" axis="0 1 0" {joint}/>
<inertial pos="0 0 -.3" mass="1.2" diaginertia=".05 .04 .02"/>
<body pos="0 0 -.6"><joint name="knee" axis="0 1 0" {joint}/>
<inertial pos="0 0 -.2" mass=".6" diaginertia=".02 .02 .01"/><site name="tip" pos="0 0 -.4"/>
</body></body></worldbody>{more}</mujoco>"""
PARTS = {
    "damping": {"joint": 'damping=".3"'},
    "strong damping": {"joint": 'damping="20"'},
    "a polynomial spring": {"joint": 'stiffness="5 1 2"'},
    "a medium": {"medium": 'density="500" viscosity=".1"'},
    "held weight": {"weight": 'gravcomp=".8"', "joint": 'damping=".1"'},
    "motors": {"more": '<actuator><motor joint="hip"/><motor joint="knee" gear="2"/></actuator>'},
    "servos": {"more": """<actuator><position joint="hip" kp="40" kv="4"/>
<position joint="knee" kp="20" kv="2"/></actuator>"""},
    "stiff servos": {"more": """<actuator><position joint="hip" kp="800" kv="80"/>
<position joint="knee" kp="400" kv="40"/></actuator>"""},
    "a speed servo": {"more": '<actuator><velocity joint="hip" kv="3"/></actuator>'},
    "tendons": {"more": """<tendon><fixed stiffness="30" damping=".5"><joint joint="hip" coef="1"/>
<joint joint="knee" coef="-1"/></fixed><spatial stiffness="20" springlength=".3"><site site="top"/>
<site site="tip"/></spatial></tendon>"""},
}  # fmt: skip


def of_tree(parts: dict[str, str], at_rest: bool) -> galvi.Problem:
    text = TREE.format(**{**dict.fromkeys(("medium", "weight", "joint", "more"), ""), **parts})
    controls = [0.3, -0.2][
        : text.count("<motor") + text.count("<position") + text.count("<velocity")
    ]
    problem = galvi.from_mujoco(text, ctrl=controls) if controls else galvi.from_mujoco(text)
    return problem.with_initial_state([0.7, -0.4], [0.0, 0.0] if at_rest else [0.5, 1.0])


def forced() -> dict[str, galvi.Problem]:
    spring, drag = galvi.LinearSpring(1.0), lambda q, v: -0.2 * np.sqrt(v @ v) * v
    pull = galvi.Canonical(
        1.0, lambda q: 1.0 - np.cos(q[0]), force=lambda q, v, t: 1.5 * np.sin(0.7 * t) - 0.1 * v,
        timed_force=True,
    )  # fmt: skip
    top = galvi.RigidBody((1.0, 2.0, 2.5), force=lambda R, w: -0.1 * w)
    return {
        "drag": galvi.Problem(galvi.Canonical(1.0, spring, force=drag), [1.0, 0.0], [0.0, 0.7]),
        "a driven pendulum": galvi.Problem(pull, [0.0], [0.0]),
        "a damped body": galvi.Problem(top, np.eye(3), [1.0, 0.2, 2.0]),
        "a grain": galvi.problems.brownout(1e-4),
    }


def cases() -> Iterator[tuple[str, galvi.Problem, float, Any]]:
    for name, (make, unit) in PROBLEMS.items():
        for x in (0.2, 0.7):
            yield name, make(x), unit, None
            if name in CLOCKS:
                yield f"{name} in a clock", make(x), 1.0, CLOCKS[name]
    for name, parts in PARTS.items():
        for at_rest in (False, True):
            yield name, of_tree(parts, at_rest), 0.15, None
    for name, problem in forced().items():
        yield name, problem, 0.5, None


def is_right(run: Any, problem: galvi.Problem, step: float, clock: Any) -> bool:
    """Against a run of higher degree and a quarter of the step."""
    finer = galvi.Galerkin(galvi.Polynomials(14), galvi.gauss(14), clock=clock)
    if clock is None:
        true = galvi.integrate(problem, finer, step / 4, 4 * (len(run.t) - 1))
    else:
        true = galvi.integrate(problem, finer, step / 4, duration=abs(run.t[-1] - run.t[0]))
    if not (run.t[-1] == pytest.approx(true.t[-1], abs=1e-12) and true.success):
        return False
    rows = slice(None, None, 4) if clock is None else slice(-1, None)  # all steps, or the end
    own = slice(None) if clock is None else rows
    return all(
        np.max(np.abs(a[own] - b[rows])) <= RIGHT * np.max(np.abs(b))
        for a, b in ((run.q, true.q), (run.p, true.p))
    )


def statuses() -> Iterator[tuple[str, str]]:
    """(what it was, status) of right runs."""
    for name, problem, unit, clock in cases():
        for degree in DEGREES:
            method = galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree), clock=clock)
            for share in SHARES:
                how = {"steps": 40} if clock is None else {"duration": 10.0 * share * unit}
                try:
                    run = galvi.integrate(problem, method, share * unit, **how)
                except ValueError:  # a step that a clock refuses
                    continue
                if np.isfinite(run.q[-1]).all() and is_right(run, problem, share * unit, clock):
                    yield f"{name}, degree {degree}, step {share * unit:g}", run.status


@pytest.mark.slow(
    beside="test_clock_runs.py::test_runs_backwards_and_from_rest_have_no_false_remarks"
)
def test_at_most_one_right_run_in_a_hundred_has_a_remark() -> None:
    found = list(statuses())
    said = [(what, status) for what, status in found if not status.startswith("Completed.")]
    assert len(found) > 300
    assert len(said) <= 0.01 * len(found), said
