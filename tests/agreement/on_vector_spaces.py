"""Systems on vector spaces: canonical ones, chains, Lagrangians from SymPy and of functions."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numba
import numpy as np
import sympy as sp

import galvi
from tests.agreement.row import Row
from tests.properties.forced_systems import START
from tests.properties.forced_systems import SYSTEMS as FORCED_SPRINGS

# ---------------------------------------------------------------- built-in potentials

POTENTIALS: dict[
    str, tuple[Callable[[int], Any], tuple[int, ...]]
] = {  # potential of d coordinates, its values of d
    "centre": (lambda d: galvi.CentralForce(0.8), (3, 2)),
    "cosine": (lambda d: galvi.CosinePotential(1.2), (4, 1, 2, 7)),
    "spring": (lambda d: galvi.LinearSpring(2.0), (1, 2, 4, 7)),
    "springs": (lambda d: galvi.SpringChain(0.3, 0.5), (7, 1, 2, 4)),
    "field": (lambda d: galvi.UniformField(np.linspace(-0.8, 0.5, d)), (2, 1, 4, 7)),
}
MASSES: dict[str, Callable[[np.random.Generator, int], Any]] = {
    "one mass": lambda random, d: 1.3,
    "masses": lambda random, d: random.uniform(0.5, 2.0, d),
    "coupled masses": lambda random, d: np.eye(d) + np.cov(random.normal(size=(d, d + 2))),
}


def in_potential(potential: str, masses: str, size: int, seed: int) -> galvi.Problem:
    """A canonical system with a built-in potential, from a random start.

    `size` is an index of the potential's dimensions.
    """
    random = np.random.default_rng(seed)
    make, sizes = POTENTIALS[potential]
    d = sizes[size % len(sizes)]
    system = galvi.Canonical(MASSES[masses](random, d), make(d))
    return galvi.Problem(system, random.uniform(0.6, 1.0, d), 0.3 * random.normal(size=d))


def from_the_origin(V: Any, speed: float) -> galvi.Problem:
    return galvi.Problem(galvi.Canonical(1.0, V), [0.0, 0.0], [speed, 0.0])


# ---------------------------------------------------------------- functions of a canonical system

HENON = galvi.problems.henon_heiles().system
COUPLED = [[1.2, 0.3], [0.3, 0.9]]
GAP_BOUNDS = {False: 16.0, True: 2000.0}  # by whether the general kernel has to difference V


def morse(q: Any) -> Any:
    return sum((1.0 - math.exp(-0.7 * x)) ** 2 for x in q) + 0.2 * (q[0] - q[1]) ** 2


def morse_gradient(q: Any) -> Any:
    stretch = np.exp(-0.7 * q)
    pull = 0.4 * (q[0] - q[1])
    return 1.4 * stretch * (1.0 - stretch) + np.array([pull, -pull])


def driven(q: Any, t: float) -> Any:
    return 0.5 * q @ q * (1.0 + 0.1 * math.sin(2.0 * t)) + q[0] ** 2 * q[1] / 5.0


@numba.njit
def driven_gradient(q, t):
    out = q * (1.0 + 0.1 * math.sin(2.0 * t))
    out[0] += 0.4 * q[0] * q[1]
    out[1] += 0.2 * q[0] ** 2
    return out


def uniform(q: Any) -> Any:
    return 9.81 * q[1]


CANONICAL: dict[str, tuple[Any, Any]] = {  # V and dV/dq
    "compiled": (HENON.potential, HENON.gradient),
    "compiled, no gradient": (HENON.potential, None),
    "Python": (morse, morse_gradient),
    "Python, no gradient": (morse, None),
    "driven": (driven, driven_gradient),
    "driven, no gradient": (driven, None),
    "constant, no gradient": (uniform, None),
}


def problem_of_functions(name: str, mass: Any = 1.3, wrap: Any = lambda function: function) -> Any:
    """A problem with the functions of a row of CANONICAL, each passed through `wrap`."""
    V, gradient = CANONICAL[name]
    system = galvi.Canonical(
        mass, wrap(V), gradient and wrap(gradient), explicit_time=name.startswith("driven")
    )
    return galvi.Problem(system, [0.3, 0.2], [0.1, -0.2], 0.4)


# ---------------------------------------------------------------- Lagrangians from SymPy

x, y, vx, vy, t = sp.symbols("x y v_x v_y t", real=True)
r, phi, vr, vphi = sp.symbols("r phi v_r v_phi", real=True)
drag_rate = sp.Symbol("drag_rate", positive=True)
PLANE, POLAR = ((x, y), (vx, vy)), ((r, phi), (vr, vphi))
SYMBOLIC: dict[str, tuple[Any, ...]] = {  # L, (q, v), q0, v0
    "elastic pendulum": (
        (vr**2 + r**2 * vphi**2) / 2 - 5 * (r - 1) ** 2 + 3 * r * sp.cos(phi),
        POLAR,
        [1.1, 0.7],
        [0.0, 0.3],
    ),
    "polar Kepler": ((vr**2 + r**2 * vphi**2) / 2 + 1 / r, POLAR, [0.8, 0.2], [0.1, 1.5]),
    "relativistic": (
        -sp.sqrt(1 - vx**2 - vy**2) - (x**2 + 2 * y**2) / 5,
        PLANE,
        [0.5, 0.3],
        [0.4, 0.2],
    ),
    "driven": (
        vx**2 / 2 + sp.exp(x / 5) * vy**2 / 2 - x**2 - sp.log(2 + y**2) + x * sp.sin(2 * t),
        PLANE,
        [0.4, -0.2],
        [0.1, 0.6],
    ),
    "from rest at the origin": (
        (vx**2 + vy**2) / 2 + x * sp.sin(2 * t + 1) - y * x,
        PLANE,
        [0.0, 0.0],
        [0.0, 0.0],
    ),
    "free": ((vx**2 + 3 * vy**2) / 2, PLANE, [0.4, -0.7], [0.5, 0.2]),
}
PUSHES: dict[str, tuple[str, Callable[[Any, Any], Any]]] = {  # L, force of one coordinate
    "linear drag": ("elastic pendulum", lambda q, v: -drag_rate * v),
    "quadratic drag": ("relativistic", lambda q, v: -drag_rate * sp.Abs(v) * v),
    "driven force": (
        "elastic pendulum",
        lambda q, v: sp.cos(3 * t) * sp.exp(-drag_rate * q**2) - v**3,
    ),
    "no force": ("driven", lambda q, v: sp.Integer(0)),
}


def symbolic(name: str, push: Callable[[Any, Any], Any] | None = None) -> galvi.Problem:
    """A problem of SYMBOLIC, with an external force on each coordinate."""
    L, (q, v), q0, v0 = SYMBOLIC[name]
    depends_on_time = push is not None or L.has(t)
    force = [push(*pair) for pair in zip(q, v, strict=True)] if push else None
    system = galvi.Lagrangian.from_sympy(
        L,
        q,
        v,
        t if depends_on_time else None,
        parameters={drag_rate: 0.3} if push else None,
        force=force,
    )
    return galvi.Problem(system, q0, v0)


# ---------------------------------------------------------------- Lagrangians of functions

M, K, G = np.array([[2.0, 0.3], [0.3, 1.0]]), (1.5, 2.5, 0.7), 9.81


@numba.njit
def spring_energy(stretch, k):
    return 0.5 * k * stretch * stretch


@numba.njit
def masses_and_springs(q, v):
    potential = spring_energy(q[0], K[0]) + spring_energy(q[-1], K[-1])
    for i in range(1, q.size):
        potential += spring_energy(q[i] - q[i - 1], K[i]) + 0.1 * (q[i] - q[i - 1]) ** 4
    return 0.5 * np.sum(v**2) - potential


def elastic_pendulum(q: Any, v: Any) -> Any:
    (length, angle), position = q, np.zeros(2)
    position[:] = length * math.sin(angle), -length * math.cos(angle)
    kinetic = 0.5 * (v[0] ** 2 + (length * v[1]) ** 2)
    return kinetic - G * position[1] - 20.0 * (length - 1.0) ** 2


def with_mass_matrix(q: Any, v: Any) -> Any:
    return 0.5 * v @ M @ v * (1.0 + 0.2 * np.cos(q).sum()) - 0.5 * q @ q


def in_a_well(q: Any, v: Any, t: float) -> Any:
    return 0.5 * v @ v - np.linalg.norm(q - np.array([2.0, 0.0])) ** 1.5 + q[0] * math.sin(2.0 * t)


@numba.njit
def magnetic_slopes(q, v):
    out = np.empty(4)
    out[0], out[1] = v[0] - 0.4 * q[1], v[1] + 0.4 * q[0]
    out[2], out[3] = 0.4 * v[1] - q[0], -0.4 * v[0] - q[1]
    return out


def magnetic(q: Any, v: Any) -> Any:
    return 0.5 * v @ v - 0.5 * q @ q + 0.4 * (q[0] * v[1] - q[1] * v[0])


PLANE_STATE = [0.4, 0.7], [0.5, -0.3]
LAGRANGIANS: dict[str, tuple[Any, ...]] = {  # system, q0, v0
    "masses and springs": (
        galvi.Lagrangian(masses_and_springs, galvi.Rn(3)),
        [0.3, -0.2, 0.5],
        [0.1, 0.4, -0.3],
    ),
    "elastic pendulum": (
        galvi.Lagrangian(elastic_pendulum, galvi.Rn(2)),
        [1.1, 0.7],
        [0.0, 0.3],
    ),
    "mass matrix": (galvi.Lagrangian(with_mass_matrix, galvi.Rn(2)), *PLANE_STATE),
    "driven": (galvi.Lagrangian(in_a_well, galvi.Rn(2), explicit_time=True), *PLANE_STATE),
    "magnetic": (galvi.Lagrangian(magnetic, galvi.Rn(2), magnetic_slopes), *PLANE_STATE),
    "slopes of Python": (
        galvi.Lagrangian(magnetic, galvi.Rn(2), magnetic_slopes.py_func),
        *PLANE_STATE,
    ),
    "braked": (
        galvi.Lagrangian(
            magnetic,
            galvi.Rn(2),
            magnetic_slopes,
            force=lambda q, v, t: -0.2 * v * math.cos(t),
            timed_force=True,
        ),
        *PLANE_STATE,
    ),
}
FORCED: dict[str, Any] = {  # systems with a user's force beside functions of every kind
    "a gradient of the time": galvi.Canonical(
        M,
        lambda q, t: 0.5 * q @ q + t * q[0],
        lambda q, t: q + t * np.array([1.0, 0.0]),
        force=numba.njit(lambda q, v: -0.3 * v),
        explicit_time=True,
    ),
    "a chain": galvi.Lagrangian(
        galvi.PlanarChain([1.0, 0.5], [1.0, 0.8]), galvi.Rn(2), force=lambda q, v: -0.1 * v
    ),
    "SymPy": dataclasses.replace(
        galvi.Lagrangian.from_sympy((vx**2 + vy**2 - x**2 * y**2) / 2, (x, y), (vx, vy)),
        force=lambda q, v, t: np.array([math.sin(3.0 * t), -0.2 * v[1]]),
        timed_force=True,
    ),
}


def chain(links: int, rods: bool = False) -> galvi.Problem:
    """A chain of unequal links."""
    masses, lengths = np.random.default_rng(links).uniform(0.5, 1.5, (2, links))
    system = galvi.Lagrangian(galvi.PlanarChain(masses, lengths, rods=rods), galvi.Rn(links))
    return galvi.Problem(system, 0.3 * np.arange(links) - 0.4, np.full(links, 0.2))


ROWS: dict[str, Row] = {
    "Kepler": Row(partial(galvi.problems.kepler, 0.3), 0.1),
    **{
        f"{name} from the origin, v = {speed}": Row(partial(from_the_origin, V, speed), 0.1)
        for name, V in (
            ("field", galvi.UniformField([0.0, -9.81])),
            ("spring", galvi.LinearSpring(2.0)),
        )
        for speed in (0.0, 0.5)
    },
    **{
        f"V: {name}": Row(
            partial(problem_of_functions, name), 0.1, gap_bound=GAP_BOUNDS[gradient is None]
        )
        for name, (_, gradient) in CANONICAL.items()
    },
    "V: driven, masses": Row(partial(problem_of_functions, "driven", [0.8, 1.7]), 0.1),
    "V: Python, coupled masses": Row(partial(problem_of_functions, "Python", COUPLED), 0.1),
    **{
        f"grain of {round(1e6 * size)} um, C = {coefficient}": Row(
            partial(galvi.problems.brownout, size, drag_coefficient=coefficient), 0.005
        )
        for size, coefficient in ((10e-6, 0.44), (400e-6, 0.44), (50e-6, None))
    },
    **{
        f"spring and force: {name}": Row(
            partial(galvi.Problem, FORCED_SPRINGS[name][0], *START), 0.1
        )
        for name in ("a potential known to galvi", "a compiled gradient", "a Lagrangian")
    },
    **{f"SymPy: {name}": Row(partial(symbolic, name), 0.05) for name in SYMBOLIC},
    **{f"SymPy: {name}": Row(partial(symbolic, *push), 0.04) for name, push in PUSHES.items()},
    **{
        f"L: {name}": Row(partial(galvi.Problem, *lagrangian), 0.05)
        for name, lagrangian in LAGRANGIANS.items()
    },
    **{
        f"force: {name}": Row(partial(galvi.Problem, system, *PLANE_STATE), 0.05)
        for name, system in FORCED.items()
    },
    "double pendulum": Row(galvi.problems.double_pendulum, 0.02),
    "three points": Row(partial(chain, 3), 0.02),
    "five rods": Row(partial(chain, 5, rods=True), 0.02),
}
