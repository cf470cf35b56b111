"""Lagrangians, potentials and forces from SymPy."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.systems.user_functions import sympy_module
from galvi.tracing import code as symbolic_code
from galvi.tracing import kinks, lane_law
from galvi.tracing.expression import Expressions, expressions
from galvi.tracing.lane_law import printed_force
from galvi.tracing.symbolic_lagrangian import SymbolicLagrangian


@dataclass(frozen=True)
class SymbolicForce:
    """f(q, v, t), (d,), from `galvi.Lagrangian.from_sympy`; its repr is the expressions.

    Attributes
    ----------
    text
        the expressions in the user's notation
    source
        generated code with a function force
    constants
        values of the parameters
    law
        the code that defines it for lanes, see `BuiltinForce`; "" if lanes lack a function of it
    names
        the parameters in the user's notation, in the order of the constants
    """

    text: str
    source: str
    constants: tuple[float, ...]
    law: str = ""
    names: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return self.text

    def __call__(self, q: Array, v: Array, t: float) -> Array:
        out = np.zeros((2, len(v)))
        numbers = np.array(self.constants)
        try:
            with np.errstate(all="ignore"):
                symbolic_code.functions(self.source)["force"].py_func(
                    q, v, np.float64(t), numbers, out
                )
        except (ArithmeticError, ValueError):  # math's functions raise where numpy's are NaN
            out[...] = np.nan
        return out[1]

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """Compiled function (q, v, t, constants, out (2, d)) that adds the force to the second row
        of out, and its constants."""
        return symbolic_code.functions(self.source)["force"], np.array(self.constants)


def symbolic_force(parsed: Expressions) -> SymbolicForce:
    """The generalised forces of the expressions, as generated code."""
    assert parsed.forces is not None
    lines = symbolic_code.code_lines(
        parsed.forces, parsed.places, lambda k, code: f"out[1, {k}] += {code}"
    )
    text = symbolic_code.source({"force": ("q, v, t, c, out", lines)})
    readable = f"[{', '.join(map(parsed.text, parsed.forces))}]"
    law = printed_force(parsed.forces, parsed.places)
    return SymbolicForce(readable, text, parsed.values, law, parsed.names)


METHOD_CLASS = "LagrangesMethod"


def is_lagranges_method(value: Any) -> bool:
    """Whether a value is a ``sympy.physics.mechanics.LagrangesMethod``, without importing that."""
    return any(
        kind.__name__ == METHOD_CLASS and kind.__module__.startswith("sympy.")
        for kind in type(value).mro()
    )


def read_lagranges_method(method: Any) -> tuple[Any, list[Any], list[Any] | None]:
    """L, the coordinates, and the generalised forces of the loads, None without loads.

    A load F on a point or a frame gives the forces F . dv/dq', where v is the velocity of the
    point, or the angular velocity of the frame.

    Raises
    ------
    ValueError
        For a method with constraints.
    """
    if len(method.coneqs):
        raise ValueError(
            f"a LagrangesMethod with constraints cannot be used; received {len(method.coneqs)} of "
            f"them. Choose coordinates that fulfil them."
        )
    (lagrangian,) = method._L
    coordinates = list(method.q)
    if not method.forcelist:
        return lagrangian, coordinates, None
    time = coordinates[0].args[0]
    rates = [x.diff(time) for x in coordinates]
    forces: list[Any] = [0] * len(coordinates)
    for target, load in method.forcelist:
        velocity = getattr(target, "ang_vel_in" if hasattr(target, "ang_vel_in") else "vel")
        target_velocity = velocity(method.inertial)
        for k, rate in enumerate(rates):
            partial_velocity = target_velocity.diff(rate, method.inertial, var_in_dcm=False)
            forces[k] += partial_velocity.dot(load)
    return lagrangian, coordinates, forces


def symbolic(
    L: Any, q: Any, v: Any, t: Any, parameters: Any, force: Any
) -> tuple[SymbolicLagrangian, bool, SymbolicForce | None]:
    """The Lagrangian, whether it depends on the time, and the force, None without one.

    Warns of a Lagrangian that is not twice differentiable somewhere.

    Raises
    ------
    ImportError
        Without SymPy.
    TypeError, ValueError
        For unusable input.
    """
    sympy = sympy_module()
    if is_lagranges_method(L):
        if not (q is None and v is None and force is None):
            raise ValueError(
                "a LagrangesMethod brings its coordinates and forces; give only parameters, and t "
                "when it depends on the time."
            )
        L, q, force = read_lagranges_method(L)
    elif q is None:
        raise TypeError("q must hold the coordinates of the expression; received none.")
    parsed = expressions(L, q, v, t, parameters, force)
    surfaces = kinks.surfaces(parsed.L, {*parsed.q, *parsed.v, parsed.t})
    lagrangian = SymbolicLagrangian(
        parsed.text(parsed.L),
        _source(parsed, surfaces),
        parsed.values,
        len(parsed.q),
        tuple(map(parsed.text, surfaces)),
        ""
        if surfaces
        else lane_law.printed_law(
            parsed.q, parsed.v, parsed.t, parsed.L, parsed.places, kinks.derivative_off_kinks
        ),
        sympy.srepr(parsed.L),
        parsed.names,
    )
    for k, surface in enumerate(lagrangian.switching):
        discontinuity = kinks.find_kink(lagrangian, k)
        if discontinuity:
            warnings.warn(
                f"the Lagrangian is not twice differentiable where {surface} changes its sign: its "
                f"{discontinuity} there. Steps across lose their order; smooth it, or end the run "
                f"there.",
                stacklevel=3,
            )
    external = None if parsed.forces is None else symbolic_force(parsed)
    return lagrangian, parsed.t in parsed.L.free_symbols, external


def _source(parsed: Expressions, surfaces: tuple[Any, ...]) -> str:
    d, places = len(parsed.q), parsed.places
    slopes = [kinks.derivative_off_kinks(parsed.L, x) for x in (*parsed.v, *parsed.q)]
    bodies = {
        "law": (slopes, lambda k, code: f"out[{k // d}, {k % d}] = {code}"),
        "value": ([parsed.L], lambda k, code: f"out[{k}] = {code}"),
        "switches": (surfaces, lambda k, code: f"out[{k}] = {code}"),
    }
    return symbolic_code.source(
        {
            name: ("q, v, t, c, out", symbolic_code.code_lines(formulas, places, store))
            for name, (formulas, store) in bodies.items()
            if formulas
        }
    )
