"""Runs with forces: outer planets by galvi and with REBOUNDx, and an arm with actuators."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

import galvi
from references.rebound import extras

STEP, ARM_STEP = 200.0, 0.01  # days, and seconds of the arm
OTHER_COORDINATES: Mapping[str, tuple[float, dict[str, Any]]] = {
    "Kepler frame": (400.0, {"chart": galvi.KeplerFrame()}),  # days
    "clock": (0.4, {"clock": galvi.DynamicalTime()}),
}
STEPS, ARM_STEPS, SLOW_STEPS = 10_000, 200, 20
LIGHT_SPEED = 173.14463  # of light, au / day
NONE = "none"
Call = tuple[Callable[[], Any], int]  # a call and its number of steps
JOINT = '<joint name="{0}" type="hinge" axis="0 1 0" damping="0.2" armature="0.05"/>'
LINK = '<geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.04" mass="{1}" contype="0"/>'
ARM = (
    '<mujoco><option gravity="0 0 -9.81"/><worldbody>'
    + "".join(
        f'<body pos="0 0 {-0.4 * (k > 0)}">{JOINT.format(name, mass)}{LINK.format(name, mass)}'
        for k, (name, mass) in enumerate((("a", 2.0), ("b", 1.5), ("c", 1.0)))
    )
    + "</body></body></body></worldbody><actuator>{}</actuator></mujoco>"
)
ACTUATORS = {
    NONE: "",
    "motors": "".join(f'<motor joint="{name}" gear="2"/>' for name in "abc"),
    "servos": "".join(f'<position joint="{name}" kp="20" kv="1"/>' for name in "abc"),
}


def position_forces() -> dict[str, Any]:
    """Forces of positions, which SIMD kernels add to the gravity of the outer planets."""
    return {
        NONE: (),
        "J2": galvi.Oblateness(0, 2e-7, 4.65e-3),
        "potential": galvi.Relativity(LIGHT_SPEED, form="potential"),
        "power law": galvi.PowerLaw(0, 1e-12, -2.5),
    }


def velocity_forces() -> dict[str, Any]:
    """Forces of velocities on the outer planets: built-in ones and a user's function."""
    coefficients, masses = [0.0, *[1e-12] * 5], outer_planets(()).system.masses[:, None]
    return {
        "one source": galvi.Relativity(LIGHT_SPEED),
        "EIH": galvi.Relativity(LIGHT_SPEED, form="EIH"),
        "radiation": galvi.Radiation(coefficients, LIGHT_SPEED),
        "drag": galvi.Drag(coefficients),
        "tides": galvi.Tides(0, 0.03, 4.65e-3, 1e-3),
        "a function": galvi.Force(lambda q, v: -1e-12 * masses * v, takes_velocity=True),
    }


def outer_planets(forces: Any) -> galvi.Problem:
    """The outer planets with these forces."""
    outer: Any = galvi.problems.outer_solar_system()
    system = galvi.NBody(outer.system.masses, outer.system.G, forces)
    return galvi.Problem(system, outer.q0, outer.v0)


def arm(actuators: str) -> galvi.Problem:
    """Three hinges with these actuators, their controls at 0.3."""
    count = actuators.count("<motor") + actuators.count("<position")
    return galvi.from_mujoco(ARM.format(actuators), ctrl=[0.3] * count)


def _run(
    problem: galvi.Problem, step: float, steps: int, degree: int = 8, **method_options: Any
) -> Any:
    method = galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree), **method_options)
    return galvi.integrate(problem, method, step, steps, save_every=steps)


def _whfast(steps: int, *force: Any) -> Any:
    """States by WHFast, without its warning about forces of velocities."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return extras.states(
            outer_planets(()), "whfast", STEP, np.array([0.0, STEP * steps]), *force
        )


def calls() -> Mapping[str, Mapping[str, Call]]:
    """The calls of the runs and their numbers of steps, by group and by name."""
    galvi_calls: dict[str, Call] = {
        name: (partial(_run, outer_planets(force), STEP, STEPS), STEPS)
        for name, force in {**position_forces(), **velocity_forces()}.items()
    }
    groups: dict[str, dict[str, Call]] = {"galvi, outer planets": galvi_calls}
    for label, (step, method_options) in OTHER_COORDINATES.items():
        groups[f"galvi, {label}"] = {
            name: (partial(_run, outer_planets(force), step, STEPS, **method_options), STEPS)
            for name, force in position_forces().items()
        }
    dragged = outer_planets(velocity_forces()["drag"])
    step, method_options = OTHER_COORDINATES["clock"]
    groups["galvi, clock"]["drag"] = (
        partial(_run, dragged, step, SLOW_STEPS, **method_options),
        SLOW_STEPS,
    )
    if not extras.missing():
        rebound_forces: dict[str, tuple[Any, ...]] = {
            NONE: ("", {}, {}),
            "J2": ("gravitational_harmonics", {}, {0: {"J2": 2e-7, "R_eq": 4.65e-3}}),
            "potential": ("gr_potential", {"c": LIGHT_SPEED}, {}),
            "one source": ("gr", {"c": LIGHT_SPEED}, {}),
            "EIH": ("gr_full", {"c": LIGHT_SPEED}, {}),
        }
        groups["REBOUND WHFast, REBOUNDx"] = {
            name: (partial(_whfast, STEPS, *force), STEPS) for name, force in rebound_forces.items()
        }
    groups["galvi, arm of three hinges"] = {
        name: (partial(_run, arm(xml), ARM_STEP, ARM_STEPS, 4), ARM_STEPS)
        for name, xml in ACTUATORS.items()
    }
    return groups
