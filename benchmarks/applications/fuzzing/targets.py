"""What is called: public functions with one or two odd arguments, problems drawn at random, files.

A target is a function of hypothesis' ``data`` that draws arguments and returns a call without
arguments, with a text that shows them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

import galvi
from benchmarks.applications.fuzzing import events, files, forces
from benchmarks.applications.fuzzing.arguments import (
    CHARTS,
    CLOCKS,
    COUNTS,
    MEETING,
    METHODS,
    ODD,
    PROBLEMS,
    RULES,
    RUNS,
    SMALL,
    SPACES,
    STEPS,
    spoilt,
)
from benchmarks.applications.fuzzing.judgement import Call
from galvi.input_checks import LARGEST

Target = Callable[[Any], Call]
SHOWN = 600  # characters of the arguments
MOST_STEPS = 100_000  # that a call is asked for

POSITIVE = st.floats(1e-3, 1e3)
VECTORS = st.lists(st.floats(-3, 3), min_size=3, max_size=3)
DEGREES = st.integers(1, 8)


def square(q: Any) -> Any:
    """A potential."""
    return float(np.sum(np.asarray(q) ** 2))


def free(q: Any, v: Any) -> Any:
    """A Lagrangian."""
    return 0.5 * (v @ v) - 0.5 * (q @ q)


# name -> (function, good values of its parameters: strategies or values)
FUNCTIONS: Mapping[str, tuple[Callable[..., Any], Mapping[str, Any]]] = {
    "Polynomials": (galvi.Polynomials, {"degree": DEGREES}),
    "Fourier": (galvi.Fourier, {"harmonics": st.integers(1, 4), "frequency": POSITIVE}),
    "PiecewisePolynomials": (galvi.PiecewisePolynomials, {"degree": DEGREES, "pieces": DEGREES}),
    "PiecewiseHermite": (galvi.PiecewiseHermite, {"pieces": DEGREES}),
    "PolynomialFourier": (
        galvi.PolynomialFourier,
        {"degree": DEGREES, "harmonics": DEGREES, "frequency": POSITIVE},
    ),
    "ComponentPolynomials": (
        galvi.ComponentPolynomials,
        {"degrees": st.lists(DEGREES, min_size=1, max_size=4).map(tuple)},
    ),
    "gauss": (galvi.gauss, {"points": st.integers(1, 20)}),
    "lobatto": (galvi.lobatto, {"points": st.integers(2, 20)}),
    "radau": (galvi.radau, {"points": st.integers(1, 12), "left": st.booleans()}),
    "newton_cotes": (galvi.newton_cotes, {"points": st.integers(2, 12)}),
    "clenshaw_curtis": (galvi.clenshaw_curtis, {"points": st.integers(2, 20)}),
    "composite": (galvi.composite, {"rule": RULES, "pieces": st.integers(1, 4)}),
    "Rule": (
        galvi.Rule,
        {"name": "mine", "degree": 1, "exact_nodes": (0.5,), "exact_weights": (1.0,)},
    ),
    "Galerkin": (galvi.Galerkin, {"space": SPACES, "rule": RULES, "chart": CHARTS}),
    "KeplerFrame": (galvi.KeplerFrame, {"passes": st.integers(1, 6), "even": st.booleans()}),
    "HarmonicFrame": (galvi.HarmonicFrame, {"stiffness": None, "passes": st.integers(1, 6)}),
    "Sundman": (galvi.Sundman, {"power": POSITIVE}),
    "Clock": (galvi.Clock, {"function": st.just(square), "gradient": st.none()}),
    "Rn": (galvi.Rn, {"n": st.integers(1, 4)}),
    "Product": (galvi.Product, {"factors": st.just((galvi.SO3(), galvi.Rn(2)))}),
    "Canonical": (
        galvi.Canonical,
        {
            "mass": st.one_of(POSITIVE, st.lists(POSITIVE, min_size=2, max_size=2)),
            "potential": st.just(square),
        },
    ),
    "Lagrangian": (galvi.Lagrangian, {"function": st.just(free), "group": st.just(galvi.Rn(2))}),
    "NBody": (galvi.NBody, {"masses": st.lists(POSITIVE, min_size=2, max_size=5), "G": POSITIVE}),
    "RigidBody": (
        galvi.RigidBody,
        {"inertia": st.just([1.0, 1.2, 1.4]), "potential": st.just(None)},
    ),
    "FreeBody": (
        galvi.FreeBody,
        {"mass": POSITIVE, "inertia": st.just([1.0, 1.2, 1.4]), "g": VECTORS},
    ),
    "PlanarChain": (
        galvi.PlanarChain,
        {
            "masses": st.just([1.0, 2.0]),
            "lengths": st.just([1.0, 0.5]),
            "gravity": POSITIVE,
            "rods": st.booleans(),
        },
    ),
    "Joint": (
        galvi.Joint,
        {
            "type": st.sampled_from(["hinge", "slide", "ball", "free"]),
            "axis": VECTORS,
            "anchor": VECTORS,
            "zero": POSITIVE,
            "armature": POSITIVE,
            "stiffness": POSITIVE,
            "damping": POSITIVE,
        },
    ),
    "Link": (
        galvi.Link,
        {
            "joints": st.just((galvi.Joint("hinge"),)),
            "mass": POSITIVE,
            "centre": VECTORS,
            "inertia": POSITIVE,
            "place": VECTORS,
        },
    ),
    "Multibody": (
        galvi.Multibody,
        {
            "links": st.just((galvi.Link((galvi.Joint("hinge"),), 1.0, (0, 0, -1), 0.1),)),
            "gravity": VECTORS,
        },
    ),
    "UniformGravity": (galvi.UniformGravity, {"mass": POSITIVE, "centre": VECTORS, "g": POSITIVE}),
    "UniformField": (galvi.UniformField, {"force": VECTORS}),
    "CentralForce": (galvi.CentralForce, {"mu": POSITIVE}),
    "LinearSpring": (galvi.LinearSpring, {"stiffness": POSITIVE}),
    "SpringChain": (galvi.SpringChain, {"alpha": POSITIVE, "beta": POSITIVE}),
    "RotorDrag": (galvi.RotorDrag, {"factor": POSITIVE}),
    "integrate": (
        galvi.integrate,
        {
            "problem": PROBLEMS,
            "method": METHODS,
            "step": STEPS,
            "steps": COUNTS,
            "save_every": COUNTS,
            "curves": st.sampled_from([None, True, False]),
            "solver": st.sampled_from(["auto", "newton"]),
            "tolerance": st.sampled_from([None, 1e-9]),
        },
    ),
    "integrate_many": (
        galvi.integrate_many,
        {
            "problems": st.lists(st.just(SMALL["kepler"]), max_size=3),
            "method": METHODS,
            "step": STEPS,
            "steps": COUNTS,
        },
    ),
    "integrate_ensemble": (
        galvi.integrate_ensemble,
        {
            "problem": st.just(SMALL["kepler"]),
            "q0": st.just(SMALL["kepler"].q0 * np.ones((3, 1))),
            "v0": st.just(SMALL["kepler"].v0 * np.ones((3, 1))),
            "method": METHODS,
            "step": STEPS | st.just([0.1, 0.2, 0.1]),
            "steps": COUNTS,
            "parameters": st.none(),
            "keep": st.sampled_from([galvi.FinalStates(), len]),
        },
    ),
    "recommend": (
        galvi.recommend,
        {
            "problem": st.just(SMALL["harmonic_oscillator"]),
            "error": st.just(1e-4),
            "duration": st.just(1.0),
            "by": st.just("evaluations"),
            "degrees": st.just((4,)),
        },
    ),
    "resume": (
        galvi.resume,
        {"run": RUNS, "steps": COUNTS, "save_every": st.sampled_from([None, 1, 2])},
    ),
    "states_at": (galvi.states_at, {"run": RUNS, "times": st.just([0.005, 0.01])}),
    "theory": (galvi.theory, {"method": METHODS}),
    "energy": (galvi.energy, {"run": RUNS, "t": st.just(0.005)}),
    "momentum_map": (galvi.momentum_map, {"run": RUNS, "t": st.just(0.005)}),
    "linear_momentum": (galvi.linear_momentum, {"run": RUNS, "t": st.just(0.005)}),
    "momentum_balance": (galvi.momentum_balance, {"run": RUNS}),
    "orbital_elements": (galvi.orbital_elements, {"run": RUNS, "centre": st.just(0)}),
    "heliocentric": (galvi.heliocentric, {"run": RUNS, "centre": st.just(0)}),
    "rotations": (galvi.rotations, {"run": RUNS}),
    "orthogonality_defect": (galvi.orthogonality_defect, {"run": RUNS}),
    "nearest_rotation": (galvi.nearest_rotation, {"matrix": st.just(np.eye(3))}),
    "round_trip_error": (
        galvi.round_trip_error,
        {"problem": PROBLEMS, "method": METHODS, "step": STEPS, "steps": COUNTS},
    ),
    "step_derivative": (
        galvi.step_derivative,
        {"problem": PROBLEMS, "method": METHODS, "step": STEPS},
    ),
    "symplecticity_defect": (
        galvi.symplecticity_defect,
        {"problem": PROBLEMS, "method": METHODS, "step": STEPS},
    ),
    "cite": (galvi.cite, {"run": RUNS}),
    "from_rebound": (galvi.from_rebound, {"source": None, "snapshot": st.just(-1)}),
    "from_mujoco": (
        galvi.from_mujoco,
        {"model": st.just("<mujoco/>"), "ignore": st.just(())},
    ),
    "kepler": (galvi.problems.kepler, {"eccentricity": st.floats(0, 0.9)}),
    "planar_chain": (galvi.problems.planar_chain, {}),
    "solar_system": (galvi.problems.solar_system, {"pluto": st.booleans()}),
    "run(t)": (lambda self, t: self(t), {"self": RUNS, "t": st.just(0.005)}),
    "run.velocity(t)": (lambda self, t: self.velocity(t), {"self": RUNS, "t": st.just(0.005)}),
    "run.to_scipy": (lambda self: self.to_scipy(), {"self": RUNS}),
    "run.to_frame": (lambda self: self.to_frame(), {"self": RUNS}),
    **events.FUNCTIONS,
    **forces.VALUES,
}


def function(name: str) -> Target:
    """The target that calls FUNCTIONS[name] with up to two odd arguments."""
    called, parameters = FUNCTIONS[name]
    spoilable = sorted(set(parameters) - {"self"})

    def target(data: Any) -> Call:
        odd = (
            data.draw(st.lists(st.sampled_from(spoilable), max_size=2, unique=True))
            if spoilable
            else []
        )
        given = {}
        for parameter, good in parameters.items():
            value = data.draw(good) if isinstance(good, st.SearchStrategy) else good
            if parameter in odd:
                numeric = isinstance(value, float | list) and value
                value = data.draw(spoilt(value) | ODD if numeric and _is_numeric(value) else ODD)
                assume(parameter != "steps" or not _is_long(value))
            given[parameter] = value
        return partial(called, **given), shown(name, given)

    return target


def start(data: Any) -> Call:
    """A problem of galvi's whose start or time is odd, and a short run of it."""
    good = data.draw(PROBLEMS)
    given = {"q0": good.q0, "v0": good.v0, "t0": good.t0}
    for name in data.draw(st.lists(st.sampled_from(sorted(given)), max_size=2, unique=True)):
        given[name] = data.draw(spoilt(given[name]) | ODD)
    method, step, steps = data.draw(METHODS), data.draw(STEPS), data.draw(COUNTS)

    def call() -> Any:
        return galvi.integrate(
            galvi.Problem(good.system, name=good.name, **given), method, step, steps
        )

    return call, shown(f"Problem of {good.name}, {method!r}, {step}, {steps}", given)


def bodies(data: Any) -> Call:
    """Point masses of any size anywhere, also in the Kepler frame and in a clock."""
    n, dimension = data.draw(st.integers(1, 6)), data.draw(st.sampled_from([2, 3]))
    places = st.floats(-10, 10) | st.floats(-1e-3, 1e-3) | st.sampled_from([0.0, 1e8, 1e-160])
    sizes = st.floats(1e-12, 10) | st.sampled_from([0.0, 1e30, 1e-30])
    masses = data.draw(st.lists(sizes, min_size=n, max_size=n))
    q0, v0 = (
        np.array(
            data.draw(st.lists(places, min_size=n * dimension, max_size=n * dimension))
        ).reshape(n, dimension)
        for _ in range(2)
    )
    charts = [{"chart": galvi.Cayley()}, {"chart": galvi.KeplerFrame()},
              {"clock": galvi.DynamicalTime()}]  # fmt: skip
    chart = data.draw(st.sampled_from(charts))
    step, steps, s = (
        data.draw(STEPS | st.sampled_from([1e-8, 1e6])),
        data.draw(COUNTS),
        data.draw(DEGREES),
    )

    def call() -> Any:
        problem = galvi.Problem(galvi.NBody(masses), q0, v0)
        method = galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s), **chart)
        return galvi.integrate(problem, method, step, steps)

    given = {
        "masses": masses,
        "q0": q0,
        "v0": v0,
        "chart": chart,
        "step": step,
        "steps": steps,
        "s": s,
    }
    return call, shown("bodies", given)


def clocks(data: Any) -> Call:
    """A system in a clock that may suit it or not, over a duration, and a state on the way."""
    problem = data.draw(st.sampled_from([*SMALL.values(), *MEETING, *MEETING, *MEETING]))
    clock, space, rule = data.draw(CLOCKS), data.draw(SPACES), data.draw(RULES)
    if data.draw(st.booleans()):
        s = data.draw(DEGREES)
        space, rule = galvi.Polynomials(s), galvi.gauss(s)
    given = {
        "step": data.draw(st.sampled_from([0.05, 0.3, 1.0, -0.3, 2.9, 1e-9])),
        "steps": data.draw(COUNTS),
        "duration": data.draw(st.none() | st.floats(1e-9, 3.0)),
        "save_every": data.draw(COUNTS),
        "solver": data.draw(st.sampled_from(["auto", "auto", "newton", "fixed_point"])),
    }
    if data.draw(st.integers(0, 3)) == 0:
        odd = data.draw(st.sampled_from(["step", "duration", "save_every"]))
        given[odd] = data.draw(st.floats() | ODD)
    share = data.draw(st.floats(0.0, 1.0))

    def call() -> Any:
        method = galvi.Galerkin(space, rule, clock=clock)
        run = galvi.integrate(problem, method, **given)
        if run.success:
            t = min(max(run.t[0] + share * (run.t[-1] - run.t[0]), run.t.min()), run.t.max())
            for value in (run(t), run.velocity(t), *galvi.states_at(run, t)):
                if not np.isfinite(value).all():
                    raise AssertionError(f"not finite at {t!r}")
        return run

    named = {"clock": clock, "space": space, "rule": rule, **given, "share": share}
    return call, shown(f"in a clock: {problem.name}", named)


TARGETS: Mapping[str, Target] = {
    **{name: function(name) for name in FUNCTIONS},
    "a start": start,
    "bodies at random": bodies,
    "clocks": clocks,
    "events": events.events,
    "forces": forces.forced,
    "a saved run": files.saved_run,
    "a model of MuJoCo's": files.mujoco_model,
    "an archive of REBOUND's": files.rebound_file,
}


def shown(name: str, given: Mapping[str, Any]) -> str:
    """The call as text, cut short."""
    return f"{name}({', '.join(f'{key}={_text(value)}' for key, value in given.items())})"[:SHOWN]


def _text(value: Any) -> str:
    try:
        return " ".join(repr(value).split())
    except Exception as error:
        return f"<{type(value).__name__}, whose repr raises {type(error).__name__}>"


def _is_long(steps: Any) -> bool:
    """Whether a call may take long because it was asked for so many steps."""
    numbers = int | float | np.integer | np.floating
    return isinstance(steps, numbers) and MOST_STEPS < steps <= LARGEST


def _is_numeric(value: Any) -> bool:
    try:
        return bool(np.asarray(value).dtype.kind in "fiu")
    except ValueError:
        return False
