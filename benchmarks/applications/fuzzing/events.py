"""Events of short runs at random: where a function changes its sign from one step to the next it
has an odd number of roots, else an even one, and each is a root, wherever states are kept."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st

import galvi
from benchmarks.applications.fuzzing.arguments import METHODS, ODD, SMALL, a_run
from benchmarks.applications.fuzzing.judgement import Call

IN_CLOCK = galvi.Galerkin(galvi.Polynomials(5), galvi.gauss(5), clock=galvi.DynamicalTime())
STEPS, MOST = 12, 4  # of a run; and between states that are kept
SMALLEST = 1e-6  # of the largest value at a step's end: below it, a sign there may be round-off
KINDS = ("a place", "a rate", "a wave", "a product", "a branch", "odd")
ACTIONS = ("none", "none", "none", "back", "slower", "odd", "odd velocity")
ROOT = 1e-6  # value at a root, relative to the largest


def _actions(kind: str, odd: Any) -> Any:
    return {
        "none": None,
        "back": lambda q, v, t: (q, -v),
        "slower": lambda q, v, t: (q, 0.5 * v),
        "odd": lambda q, v, t: odd,
        "odd velocity": lambda q, v, t: (q, odd),
    }[kind]


def _functions(kind: str, level: float, odd: Any) -> Any:
    """Traced, called one state after another, or wrong."""
    return {
        "a place": lambda q, v, t: q.reshape(-1)[0] - level,
        "a rate": lambda q, v, t: v[-1] if v.ndim == 1 else v[-1][0] - level,
        "a wave": lambda q, v, t: np.sin(9.0 * t + level) + 0.1 * q.reshape(-1)[0],
        "a product": lambda q, v, t: (q.reshape(-1)[0] - level) * (t - 0.31),
        "a branch": lambda q, v, t: float(q.reshape(-1)[0]) - level if t < 9 else 1.0,
        "odd": lambda q, v, t: odd,
    }[kind]


def events(data: Any) -> Call:
    """A run with an event, and the same event sought when it is done."""
    problem = data.draw(st.sampled_from(list(SMALL.values())))
    method = data.draw(METHODS)
    if problem.name == SMALL["outer_solar_system"].name and data.draw(st.booleans()):
        method = IN_CLOCK
    odd = data.draw(ODD)
    kind = data.draw(
        st.sampled_from(["a place", "a rate", "a wave", "a product", "a branch", "odd"])
    )
    act = data.draw(
        st.sampled_from(["none", "none", "none", "back", "slower", "odd", "odd velocity"])
    )
    share = data.draw(st.floats(-0.2, 0.2))
    level = float(problem.q0.ravel()[0]) * (1.0 + share)
    given = {
        "direction": data.draw(st.sampled_from([-1, 0, 0, 0, 1])),
        "terminal": act == "none" and data.draw(st.sampled_from([False, False, True])),
        "action": _actions(act, odd),
    }
    step = data.draw(st.sampled_from([0.01, 0.1, -0.1, 0.3]))
    apart = data.draw(st.integers(2, MOST))

    def call() -> Any:
        event = galvi.Event(_functions(kind, level, odd), name=kind, **given)
        run = galvi.integrate(problem, method, step, STEPS, events=event)
        if run.success and act == "none" and kind != "odd" and not given["terminal"]:
            _check(run, event)
            few = galvi.integrate(problem, method, step, STEPS, events=event, save_every=apart)
            if len(few.events) != len(run.events):
                raise AssertionError(f"{len(few.events)} events, {len(run.events)} kept all")
        return run

    named = {"method": method, "step": step, "level": level, "act": act, **given}
    told = ", ".join(f"{name}={value!r}" for name, value in named.items())
    return call, f"events of {problem.name}: {kind}, {told}, odd={type(odd).__name__}"


def _check(run: Any, event: Any) -> None:
    found, sign = run.events, np.sign(run.step)
    at_ends = np.array([event.function(*one) for one in zip(run.q, run.v, run.t, strict=True)])
    size = np.abs(at_ends).max()
    if np.any(np.diff(sign * found.t) < 0.0) or np.any(sign * (found.t - run.t[-1]) > 1e-9):
        raise AssertionError("events are not in order, or after the run")
    clear = np.abs(at_ends) > SMALLEST * size
    if event.direction == 0 and not found.status:
        for k in np.flatnonzero(clear[1:] & clear[:-1]).tolist():
            inside = int(np.sum(found.step == k + 1))
            if inside % 2 != int(at_ends[k] * at_ends[k + 1] < 0.0):
                raise AssertionError(f"{inside} roots in step {k + 1}, of {at_ends[k : k + 2]}")
            value = np.abs(found.value[found.step == k + 1])
            if inside == 1 and value[0] > ROOT * max(size, 1.0):
                raise AssertionError(f"a value of {value[0]:.3g} at the root in step {k + 1}")


FUNCTIONS: dict[str, tuple[Any, dict[str, Any]]] = {
    "Event": (
        galvi.Event,
        {
            "function": st.just(_functions("a place", 0.0, None)),
            "direction": st.sampled_from([-1, 0, 1]),
            "terminal": st.booleans(),
            "action": st.none(),
        },
    ),
    "find_events": (
        galvi.find_events,
        {
            "run": st.builds(
                a_run, st.sampled_from([SMALL["kepler"], SMALL["outer_solar_system"]]), METHODS,
                st.just(0.1), st.integers(1, 8),
            ).filter(lambda run: run is not None),
            "events": st.sampled_from([
                galvi.events.closest_approach(1, 2), galvi.events.within(1, 0, 5.0),
                galvi.events.plane_crossing((0.0, 1.0)), galvi.events.angle(0, 0.5),
                galvi.events.transit(1, 0, (1.0, 0.0, 0.0)), (),
            ]),
        },
    ),
    "events.within": (
        galvi.events.within, {"i": st.integers(0, 2), "j": st.integers(0, 2), "distance": 1.0},
    ),
    "events.transit": (
        galvi.events.transit, {"i": 1, "j": 0, "observer": st.just((1.0, 0.0, 0.0))},
    ),
    "events.plane_crossing": (
        galvi.events.plane_crossing, {"normal": st.just((1.0, 0.0)), "offset": 0.0, "body": None},
    ),
    "events.angle": (galvi.events.angle, {"joint": 0, "value": 0.5}),
}  # fmt: skip
