"""The laws of systems for lanes, as code and constants; and functions that trace a user's
functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache, singledispatch
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Rn
from galvi.kernels.forces import potentials
from galvi.kernels.trees import tree
from galvi.systems.canonical import Canonical
from galvi.systems.canonical_on_rn import CanonicalOnRn
from galvi.systems.finite_differences import difference_scales
from galvi.systems.forces.celestial import Force
from galvi.systems.forces.drag import RotorDrag
from galvi.systems.forces.external_force import BuiltinForce, Forced
from galvi.systems.free_body import FreeBody
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.nbody import NBody
from galvi.systems.nbody_on_rn import NBodyOnRn
from galvi.systems.planar_chain import PlanarChain
from galvi.systems.rigid_body import RigidBody
from galvi.systems.traces import Trace, Untraceable, traces
from galvi.systems.trees.joint import JointDamping
from galvi.systems.trees.joint_forces import JointForces
from galvi.systems.trees.rigid_tree import RigidTree
from galvi.tracing import lane_law
from galvi.tracing.from_sympy import SymbolicForce
from galvi.tracing.lane_law import fits
from galvi.tracing.symbolic_lagrangian import SymbolicLagrangian
from galvi.tracing.traced_lagrangian import (
    traced_force,
    traced_gradient,
    traced_kernel,
    traced_lagrangian,
)

LawCode = tuple[str, Array]  # code that defines a law, and its constants
MAX_LANE_VELOCITIES = 40  # largest number of velocities of a tree in lanes


@singledispatch
def law_of(system: Any) -> LawCode | None:
    """The law of a system on a group with its external force; None if it has no law for lanes."""
    return None


@law_of.register
def _(system: Lagrangian) -> LawCode | None:
    trace, L = traces(system).traced.get("L"), system.builtin
    law: LawCode | None = None
    if trace is not None:
        law = trace.law, np.array(trace.constants)
    elif system.slopes is None and L is not None and (lines := lines_of(L)):
        law = lines, L.compiled()[1]
    return _with_force(law, system)


@law_of.register
def _(system: RigidBody) -> LawCode | None:
    if not system.known_potential:
        return law_of(system.lagrangian)
    law = lane_law.built_in("body", 3, system.potential is not None)
    return _with_force((law, system.lagrangian_kernel().constants), system)


@law_of.register
def _(system: FreeBody) -> LawCode | None:
    if system.potential is not None:
        return law_of(system.lagrangian)
    law = lane_law.built_in("body", 6, bool(np.any(system.g)))
    return _with_force((law, system.lagrangian_kernel().constants), system)


@law_of.register
def _(system: CanonicalOnRn) -> LawCode | None:
    d, canonical = system.group.dimension, system.canonical
    slopes = slopes_of(canonical)
    if slopes is None:
        return None
    lines = lane_law.canonical_law(slopes[0], d, bool(canonical.mass.ndim < 2))
    mass = canonical.momentum(np.eye(d))
    return _with_force((lines, np.concatenate([mass.ravel(), slopes[1]])), canonical)


@law_of.register
def _(system: NBodyOnRn) -> LawCode | None:
    bodies, d, force = system.bodies, system.group.dimension, force_of(system.bodies)
    if not fits(d, False) or (bodies.acting.functions and force is None):
        return None
    builtin_only = replace(
        bodies, forces=[term for term in bodies.forces if not isinstance(term, Force)]
    )
    with suppress(Untraceable):
        law = traced_kernel(replace(system, bodies=builtin_only).lagrangian_kernel(), d)
        return lane_law.with_force(law, force) if force else law
    return None


def slopes_of(system: Canonical) -> LawCode | None:
    """Code that defines ``slopes``, dV/dq of a canonical system, and its constants; None if there
    is none for lanes."""
    trace, potential = traces(system).traced.get("dV/dq"), system.builtin
    if trace is not None:
        return trace.lines, np.array(trace.constants)
    if potential is None or system.gradient is not None:
        return None
    name = potential.slopes.__name__
    if getattr(potentials, name, None) is not potential.slopes:
        return None
    head = (
        f"from galvi.lanes.laws import returning_slopes\nfrom {potentials.__name__} import {name}"
    )
    return f"{head}\n\nslopes = returning_slopes({name})\n", potential.constants


def force_of(system: Forced | NBody) -> LawCode | None:
    """Code that defines the external force (q, v, t, constants) -> d values of a system, and its
    constants; None if there is none for lanes."""
    force = getattr(system, "force", None)
    if isinstance(force, BuiltinForce):
        lines = lines_of(force)
        return (lines, force.compiled()[1]) if lines else None
    trace = traces(system).traced.get("force")
    return None if trace is None else (trace.lines, np.array(trace.constants))


def _with_force(law: LawCode | None, system: Forced) -> LawCode | None:
    if system.force is None or law is None:
        return law
    force = force_of(system)
    return lane_law.with_force(law, force) if force else None


@singledispatch
def lines_of(value: Any) -> str:
    """Code that defines the law of a built-in Lagrangian, or a force, for the constants of its
    ``compiled``; "" if there is none for lanes."""
    return ""


@lines_of.register
def _(value: SymbolicLagrangian | SymbolicForce) -> str:
    return value.law


@lines_of.register
def _(value: JointDamping) -> str:
    terms = (
        f"-(c[{i}] * v[{i}])" if c or value.varied else "0.0"
        for i, c in enumerate(value.coefficients.tolist())
    )
    return f"def force(q, v, t, c):\n    return [{', '.join(terms)}]\n"


@lines_of.register
def _(value: PlanarChain) -> str:
    return lane_law.built_in("planar_chain", value.masses.size)


@lines_of.register
def _(value: RotorDrag) -> str:
    rate = value.drag_law.rate.__name__
    head = f"from galvi.kernels.forces.rotor_wind import {rate}, drag_of"
    return f"{head}\n\nforce = drag_of({rate})\n"


@lines_of.register
def _(value: RigidTree) -> str:
    """Numbers 0, 1 and -1 of the geometry are literals in it. "" for more than MAX_LANE_VELOCITIES
    velocities: such a law would take long to compile."""
    if value.dimension > MAX_LANE_VELOCITIES:
        return ""
    return _tree_lines(value)


@lines_of.register
def _(value: JointForces) -> str:
    assert value.tree is not None
    if value.tree.dimension > MAX_LANE_VELOCITIES:
        return ""
    return _force_lines(value.tree, tuple(value.structure.items()))


@lru_cache(maxsize=64)  # for loops in which controls change
def _tree_lines(value: RigidTree) -> str:
    head = "from galvi.kernels.trees.tree import tree"
    return f"{head}\n\nlaw = tree({value.dimension}, {_literals(value)})\n"


@lru_cache(maxsize=64)
def _force_lines(value: RigidTree, structure: tuple[tuple[int, float], ...]) -> str:
    literals = {**_literals(value), **dict(structure)}
    head = "from galvi.kernels.trees.joint_forces import law as forces"
    return f"{head}\n\nforce = forces({value.dimension}, {literals})\n"


def _literals(value: RigidTree) -> dict[int, float]:
    """Index in the constants of a tree -> number, for the numbers that are literals in its law."""
    rows = {
        "masses": range(tree.MASS, tree.ARMATURE),
        "armature": (tree.ARMATURE,),
        "stiffness": (tree.STIFFNESS,),
    }
    varied_numbers = {k for name in value.varied for k in rows.get(name, ())}
    literals = {0: value.numbers[0]}
    for j in range(len(value.joints)):
        first = tree.HEAD + tree.JOINT * j
        row = value.numbers[first : first + tree.JOINT]
        for k, number in enumerate(row.tolist()):
            units = (0.0, 1.0, -1.0) if tree.SHIFT <= k < tree.MASS else (0.0,)
            if k < tree.SHIFT or (number in units and k not in varied_numbers):
                literals[first + k] = number
    mass_indices = range(4, tree.HEAD) if "masses" in value.varied else ()
    gravity_indices = range(1, 4) if "gravity" in value.varied else ()
    for k in range(1, tree.HEAD):
        if value.numbers[k] == 0.0 and k not in (*mass_indices, *gravity_indices):
            literals[k] = 0.0
    return {k: float(x) for k, x in literals.items()}


def finders_of(system: Any, q: Array, v: Array, t: float) -> Mapping[str, Callable[[], Trace]]:
    """Name of a function of the system -> a function that traces it near a state."""
    if isinstance(system, NBody):
        space, function = Rn(q.size), system.acting.pushes(q.shape[1])
        q, v = q.ravel(), v.ravel()
        scales = difference_scales(space, q, v)
        return {"force": lambda: traced_force(function, space, q, v, t, True, scales)}
    if not isinstance(system, Canonical | Lagrangian):
        return {}
    group = Rn(q.size) if isinstance(system, Canonical) else system.group
    scales, force = difference_scales(group, q, v), system.force
    finders: dict[str, Callable[[], Trace]] = {}
    if force is not None and not isinstance(force, BuiltinForce):
        finders["force"] = lambda: traced_force(force, group, q, v, t, system.timed_force, scales)
    if isinstance(system, Canonical):
        written_out = force is not None or fits(q.size, system.mass.ndim == 2)
        if written_out and (system.gradient is not None or system.builtin is None):
            finders["dV/dq"] = lambda: traced_gradient(
                system.potential, system.gradient, q, t, system.explicit_time, scales[0]
            )
    elif system.slopes is not None or not system.brings_slopes:
        finders["L"] = lambda: traced_lagrangian(
            system.function, system.slopes, system.group, q, v, t, system.explicit_time, scales
        )
    return finders
