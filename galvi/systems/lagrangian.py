"""Any regular Lagrangian on a vector space or a Lie group."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.charts.chart import Exponential, place
from galvi.groups.group import Group, Rn, is_group
from galvi.input_checks import shown
from galvi.kernels.forces import lagrangian_derivatives
from galvi.systems import legendre_transform
from galvi.systems.derivative_check import Curve, check_derivatives, direction
from galvi.systems.finite_differences import (
    CALLS,
    STEPS,
    Differencing,
    difference_scales,
    differences,
)
from galvi.systems.forces.external_force import check_force, check_force_at, with_force
from galvi.systems.system import BuiltinLagrangian, KnownMass, LagrangianKernel, System
from galvi.systems.traces import reasons, refuse, trace, traces
from galvi.systems.user_functions import (
    Function,
    arguments,
    check_call_signatures,
    check_callables,
    compiles,
    returned_array,
)

CHART = Exponential()
NEIGHBOUR_DISTANCE = 0.1  # of the lengths of coordinates and velocities, to a state near another
TAYLOR_TERMS = 16  # of the Taylor series of a curve in a group; the last is 1e-20 of the first
DIFFERENCED_MOMENTUM_ERROR = 2.0**-38  # relative error of a differenced momentum
# Of momenta, for a mass matrix that is only tested for its rank and used in Newton's method.
MASS_DIFFERENCING = Differencing(weights=(0.5,), steps=STEPS[:2], good=1e-3, usable=1e-2)


@dataclass(frozen=True, eq=False)
class Lagrangian:
    """L(q, v), or L(q, v, t) when ``explicit_time`` is set, of a configuration q in ``group``.

    Parameters
    ----------
    function
        L of one configuration of group.shape and one velocity (d,), a number
    group
        e.g. ``Rn(2)``, ``SO3()`` or ``Product((SO3(), Rn(1)))``; velocities are left-trivialised,
        q' = q hat(v)
    slopes
        both derivatives in one vector, (d + entries of q,): dL/dv and the Euclidean dL/dq by rows.
        None: those of L itself where it has ``slopes``, as ``galvi.PlanarChain``; else traced from
        L (see ``untraced``) or, where it cannot be traced, differenced
    force
        an external force of (q, v), (d,), left-trivialised; see galvi.systems.forces.external_force
    explicit_time
        function and slopes take (q, v, t) instead of (q, v)
    timed_force
        the force takes (q, v, t)
    check
        compare slopes with differences of L when a `Problem` is made

    Raises
    ------
    TypeError
        For a function that is not callable, a group that is no group and flags that are no bools.

    Notes
    -----
    L must be regular: d2L/dv2 invertible. L or its slopes, and a force, are traced and run in
    vector instructions where they do not branch. Where they do, slopes and a force compiled with
    ``numba.njit`` run inside the kernel, other functions are called from Python; an L without
    slopes always is. Where no two difference steps agree, the derivative is NaN.

    Examples
    --------
    >>> def bead(q, v):  # on a parabola z = x^2 / 2, in gravity 1
    ...     return v[0] ** 2 * (1 + q[0] ** 2) / 2 - q[0] ** 2 / 2
    >>> problem = galvi.Problem(galvi.Lagrangian(bead, galvi.Rn(1)), q0=[1.0], v0=[0.0])
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> galvi.integrate(problem, method, step=0.2, steps=20).status
    'Completed.'
    """

    function: Function
    group: Group
    slopes: Function | None = None
    force: Function | None = None
    explicit_time: bool = field(default=False, kw_only=True)
    timed_force: bool = field(default=False, kw_only=True)
    check: bool = field(default=True, kw_only=True, compare=False)

    def __post_init__(self) -> None:
        check_force(self)
        check_callables(self, ("function", "slopes"), "q, v", needed="function")
        if not is_group(self.group):
            raise TypeError(
                f"group must be a group such as galvi.SO3(); received {shown(self.group)}."
            )
        check_call_signatures(self, ("function", "slopes"), "q, v", "explicit_time")

    @classmethod
    def from_sympy(
        cls,
        L: Any,
        q: Any = None,
        v: Any = None,
        t: Any = None,
        parameters: Any = None,
        force: Any = None,
    ) -> Lagrangian:
        """A Lagrangian from a SymPy expression; its derivatives are symbolic and compiled.

        Parameters
        ----------
        L
            the expression, or a ``sympy.physics.mechanics.LagrangesMethod`` without constraints,
            which has coordinates and loads
        q, v
            symbols of coordinates and velocities; without v, q are functions of the time, such as
            SymPy's dynamicsymbols, and velocities are their derivatives
        t
            the symbol of the time, when L or a force depends on it
        parameters
            symbol -> number, for all other symbols
        force
            generalised forces, an expression for each coordinate

        Raises
        ------
        ImportError
            Without SymPy.
        TypeError, ValueError
            For unusable input; warns of a Lagrangian that is not twice differentiable somewhere.

        Notes
        -----
        Compiled once for each expression, independently of the parameters, and cached on disk.
        """
        from galvi.tracing.from_sympy import symbolic  # tracing stands on systems

        function, timed, given_force = symbolic(L, q, v, t, parameters, force)
        forces: dict[str, Any] = (
            {} if given_force is None else {"force": given_force, "timed_force": True}
        )
        return cls(function, Rn(function.dimension), explicit_time=timed, **forces)

    def velocity_shape(self, shape: tuple[int, ...]) -> tuple[int, ...]:
        """(d,), d the dimension of the group."""
        return (self.group.dimension,)

    def check_state(self, q: Array, v: Array, t: float) -> None:
        """ValueError unless q is an element of the group."""
        self.group.check("q0", q)

    def check_functions(self, q: Array, v: Array, t: float) -> None:
        """ValueError unless L is a finite number, has finite slopes of the right size and is
        regular, and the force is finite."""
        check_force_at(self, q, v, t)
        value = input_checks.returned("the Lagrangian", self.function(*arguments(self, q, v, t)))
        if not np.isfinite(value):
            raise ValueError(
                f"the Lagrangian must return a finite number; received {value} at the start. "
                f"Check it, or start elsewhere."
            )
        left = self._left(q, v, t)
        if not np.all(np.isfinite(left)):
            remedy = "Rewrite L" if hasattr(self.function, "check_start") else "Check slopes"
            raise ValueError(
                f"the derivatives of the Lagrangian must be finite at the start; received "
                f"{left.tolist()}. {'Give slopes' if self._slopes is None else remedy}, or start "
                f"elsewhere."
            )
        if hasattr(self.function, "check_start"):  # from SymPy
            self.function.check_start(q, v, t)
        legendre_transform.check_regular(self.mass(q, v, t))

    def check_degenerate(self, q: Array, v: Array, t: float) -> None:
        """ValueError where d2L/dv2 is singular at a state and near it; none where it cannot be
        computed, which `check_functions` reports."""
        if self.has_known_mass:
            return
        by_q, by_v = difference_scales(self.group, q, v)
        moved = self._curve(q, by_q * direction(v.size, 1))(NEIGHBOUR_DISTANCE)
        masses = []
        for x, w in ((q, v), (moved, v + NEIGHBOUR_DISTANCE * by_v * direction(v.size, 2))):
            try:
                with np.errstate(all="ignore"):
                    mass = self.mass(x, w, t)
            except Exception:  # raised by a user's function; check_functions lets it through
                return
            if not np.all(np.isfinite(mass)) or not legendre_transform.is_singular(mass):
                return
            masses.append(mass)
        legendre_transform.check_regular(masses[0])

    def check_derivatives(self, q: Array, v: Array, t: float) -> None:
        """ValueError unless given slopes are derivatives of L, at a state and near it."""
        if not self.check or self.slopes is None:
            return
        d = self.group.dimension
        by_q, by_v = difference_scales(self.group, q, v)

        def through(distance: float, row: int) -> Curve:
            g = self._curve(q, by_q * direction(d, 1))(distance)
            w = v + distance * by_v * direction(d, 2)
            then = t + distance * (abs(t) or 1.0) * self.explicit_time
            steps = difference_scales(self.group, g, w)[1 - row] * direction(d)
            moved = self._curve(g, steps)

            def state(s: float) -> tuple[Array, Array, float]:
                return (moved(s), w, then) if row else (g, w + s * steps, then)

            def value(s: float) -> float:
                L = self.function(*arguments(self, *state(s)))
                return input_checks.returned("the Lagrangian", L)

            def terms(s: float) -> Array:
                return self._left(*state(s))[row] * steps

            return Curve(value, terms, steps, {"q": g, "v": w})

        check_derivatives(
            self,
            {
                "slopes dL/dv of the Lagrangian": lambda distance: through(distance, 0),
                "slopes dL/dq of the Lagrangian": lambda distance: through(distance, 1),
            },
        )

    def _curve(self, q: Array, xi: Array) -> Callable[[float], Array]:
        """The curve s -> q exp(s hat(xi)), for |s| up to 1/8.

        q hat(xi) is affine in q on matrix groups and on vector spaces, so that each Taylor term
        follows from the one before; its entries are the left-trivialised derivatives of those of q.
        """
        d, size, layout = self.group.dimension, q.size, self.group.layout
        rows, out = np.concatenate([np.zeros((size, d)), np.eye(size)], axis=1), np.empty((2, d))

        def rate(flat: Array) -> Array:
            rates = np.empty(size)
            for k, row in enumerate(rows):
                lagrangian_derivatives.enter_slopes(
                    row, lagrangian_derivatives.EUCLIDEAN, layout, flat, out
                )
                rates[k] = out[1] @ xi
            return rates

        start = np.array(q, dtype=np.float64).ravel()
        start_rate, terms = rate(start), [start]
        terms.append(start_rate)
        for k in range(2, TAYLOR_TERMS):
            terms.append((rate(start + terms[-1]) - start_rate) / k)
        terms_by_power = np.stack(terms)
        powers = np.arange(TAYLOR_TERMS)
        return lambda s: (s**powers @ terms_by_power).reshape(self.group.shape)

    def trace(self, q: Array, v: Array, t: float, anew: bool = False) -> None:
        """Trace L or its slopes, and the force, near a state.

        Parameters
        ----------
        anew
            trace again if a function no longer returns what its trace does
        """
        trace(self, q, v, t, anew)
        L_trace = None if anew else traces(self).traced.get("L")
        if L_trace is not None and self.slopes is None and not L_trace.defined(q, v, t):
            refuse(self, "L", "its derivatives are not finite at a start")

    @property
    def untraced(self) -> str:
        """Why functions are called one state at a time; "" where they are traced or built in, and
        where tracing was not tried: before the first `Problem`, and with GALVI_FAST=0."""
        return reasons(self)

    @property
    def builtin(self) -> BuiltinLagrangian | None:
        """L with derivatives of its own or traced ones; None without."""
        if self.brings_slopes:
            return cast(BuiltinLagrangian, self.function)
        L_trace = traces(self).traced.get("L")
        return None if L_trace is None else L_trace.lagrangian

    def momentum(self, v: Array, q: Array | None = None, t: Any = 0.0) -> Array:
        """dL/dv, (..., d), at velocities (..., d), configurations and times with the same axes."""
        L_and_p = legendre_transform.values_and_momenta(self, q, v, t)
        return self._at_each_state(self._momentum, q, v, t) if L_and_p is None else L_and_p[1]

    def velocity(
        self, p: Array, q: Array | None = None, t: Any = 0.0, near: Array | None = None
    ) -> Array:
        """v with dL/dv = p, (..., d), by Newton's method; NaN where it does not converge.

        Parameters
        ----------
        near : array, shape (d,)
            a velocity near the first one, from which the iteration starts; 0 without. State by
            state, each later iteration starts from the velocity before
        """
        start = [np.zeros(self.group.dimension) if near is None else near]
        velocities = legendre_transform.velocities(self, q, p, t, start[0])
        if velocities is not None:
            return velocities

        def velocity_at_state(x: Array, momentum: Array, s: float) -> Array:
            if self.has_known_mass and self.slopes is None:
                return legendre_transform.solved(self.mass(x, momentum, s), momentum)
            w = legendre_transform.velocity_with_momentum(
                momentum, start[0], lambda v: self._momentum(x, v, s), lambda v: self.mass(x, v, s)
            )
            start[0] = w if np.all(np.isfinite(w)) else start[0]
            return w

        return self._at_each_state(velocity_at_state, q, p, t)

    def value(self, q: Array, v: Array, t: float) -> float:
        """L at one state; NaN where that is not finite."""
        if not (np.isfinite(q).all() and np.isfinite(v).all()):
            return np.nan
        return float(self.function(*arguments(self, q, v, t)))

    def energy(self, q: Array, v: Array, t: Any) -> Array:
        """The energy v . dL/dv - L, (...)."""

        def energy_at_state(x: Array, w: Array, s: float) -> Array:
            return np.array([w @ self._momentum(x, w, s) - self.value(x, w, s)])

        L_and_p = legendre_transform.values_and_momenta(self, q, v, t)
        if L_and_p is not None and np.all(np.isfinite(L_and_p[0])):
            return (v * L_and_p[1]).sum(axis=-1) - L_and_p[0]
        return self._at_each_state(energy_at_state, q, v, t, 1)[..., 0]

    def mass(self, q: Array, v: Array, t: float) -> Array:
        """d2L/dv2 at one state, (d, d): that of L itself if it has ``mass`` and the user gives no
        slopes, else differenced, with 0 for entries below their error."""
        if self.has_known_mass and self.slopes is None:
            return cast(KnownMass, self.function).mass(q)
        mass, error = differences(
            lambda w: self._momentum(q, w, t),
            v,
            difference_scales(self.group, q, v)[1],
            way=MASS_DIFFERENCING
            if self._slopes
            else MASS_DIFFERENCING._replace(noise=DIFFERENCED_MOMENTUM_ERROR),
        )
        return np.where(np.abs(mass) <= error, 0.0, mass)

    def euclidean_slopes(self, q: Array, v: Array, t: float) -> Function | None:
        """dL/dv and the Euclidean dL/dq as a function of (q, v) or (q, v, t): the user's, those
        traced near a state, or on a
        vector space differenced; None elsewhere."""
        if self.slopes is None and not self.brings_slopes:
            self.trace(q, v, t)
        if self._slopes is not None or q.ndim != 1:
            return self._slopes
        return lambda q, v, *t: self._left(q, v, *(t or (0.0,))).ravel()

    def force_at_rest(self, q: Array, t: float) -> Array:
        """The left-trivialised dL/dq at one configuration and zero velocity, (d,)."""
        return self._left(q, np.zeros(self.group.dimension), t)[1]

    def lagrangian_kernel(self) -> LagrangianKernel:
        """Derivatives of L for the kernels, compiled or differenced."""
        side = self.group.shape[0] if len(self.group.shape) == 2 else 0
        if self.slopes is None and self.builtin is not None:
            evaluate, constants = self.builtin.compiled()
            kernel = LagrangianKernel(lagrangian_derivatives.LAW, evaluate, constants=constants)
            return with_force(kernel, self, side)
        timed, compiled, function = self.explicit_time, False, self.slopes
        if function is None:
            kind, function = (
                lagrangian_derivatives.LEFT,
                lambda *qvt: self._differenced(*qvt).ravel(),
            )
        else:
            kind = lagrangian_derivatives.EUCLIDEAN
            compiled = compiles(function, lagrangian_derivatives.signature(kind, timed, side))
            function = function if compiled else self._checked
        return with_force(
            LagrangianKernel(kind, function, timed, side, compiled=compiled), self, side
        )

    @property
    def potential_calls_per_force(self) -> int:
        """Smallest number of evaluations of L, for each component, to difference its slopes; 0
        where these are not differenced."""
        return 0 if self._slopes is not None else 2 * CALLS

    @cached_property  # isinstance with a protocol takes ten microseconds
    def brings_slopes(self) -> bool:
        """Whether the function has derivatives of its own."""
        return isinstance(self.function, BuiltinLagrangian)

    @cached_property
    def has_known_mass(self) -> bool:
        """Whether the function is a `KnownMass`."""
        return isinstance(self.function, KnownMass)

    @property
    def _slopes(self) -> Function | None:
        if self.slopes is not None or self.builtin is None:
            return self.slopes
        return self.builtin.slopes

    def _checked(self, *qvt: Any) -> Array:
        slopes = self._slopes
        assert slopes is not None
        size = self.group.dimension + int(np.prod(self.group.shape))
        expected = f"dL/dv and dL/dq in an array of shape ({size},)"
        return returned_array("slopes", slopes(*qvt), (size,), expected)

    def _left(self, q: Array, v: Array, t: float) -> Array:
        """dL/dv and the left-trivialised dL/dq, whose entry a is the derivative along q hat(e_a);
        (2, d)."""
        if self._slopes is None:
            return self._differenced(*arguments(self, q, v, t))
        out = np.empty((2, self.group.dimension))
        values = self._checked(*arguments(self, q, v, t))
        flat = np.ascontiguousarray(q, dtype=np.float64).ravel()
        lagrangian_derivatives.enter_slopes(
            values, lagrangian_derivatives.EUCLIDEAN, self.group.layout, flat, out
        )
        return out

    def _momentum(self, q: Array, v: Array, t: float) -> Array:
        if self._slopes is None:
            return self._differenced_momentum(*arguments(self, q, v, t))
        return self._left(q, v, t)[0]

    def _differenced_momentum(self, q: Array, v: Array, *time: float) -> Array:
        def moving(w: Array) -> Array:
            return np.array([float(self.function(q, w, *time))])

        return differences(moving, v, difference_scales(self.group, q, v)[1])[0][0]

    def _differenced(self, q: Array, v: Array, *time: float) -> Array:
        def moved(xi: Array) -> Array:
            return np.array([float(self.function(place(CHART, self.group, q, xi), v, *time))])

        by_v = self._differenced_momentum(q, v, *time)
        size = float(np.abs(v @ by_v)) if np.all(np.isfinite(by_v)) else 0.0
        scale = difference_scales(self.group, q, v)[0]
        return np.stack([by_v, differences(moved, np.zeros(v.size), scale, size=size)[0][0]])

    def _at_each_state(
        self, function: Function, q: Array | None, v: Array, t: Any, width: int | None = None
    ) -> Array:
        """function(q, v, t), (width,), at each state; NaN where the state is not finite."""
        if q is None:
            raise ValueError("a Lagrangian's momentum depends on the configuration; give q.")
        lead, d = v.shape[:-1], self.group.dimension
        times = np.broadcast_to(t, lead).ravel()
        configurations, rates = q.reshape(-1, *self.group.shape), v.reshape(-1, d)
        out = np.full((len(rates), width or d), np.nan)
        for row, (x, w, s) in enumerate(zip(configurations, rates, times, strict=True)):
            if np.all(np.isfinite(x)) and np.all(np.isfinite(w)):
                out[row] = function(x, w, float(s))
        return out.reshape(*lead, width or d)


def momentum_at(system: System, q: Array, v: Array, t: Any) -> Array:
    """dL/dv at configurations q, velocities v (..., d) and times t (...)."""
    return system.momentum(v, q, t) if isinstance(system, Lagrangian) else system.momentum(v)


def velocity_at(system: System, q: Array, p: Array, t: Any, guess: Array | None = None) -> Array:
    """The velocities (..., d) with the momenta p (..., d) at configurations q and times t (...).

    Parameters
    ----------
    guess : array, shape (d,)
        a velocity near the first one; used for a `Lagrangian` only
    """
    return system.velocity(p, q, t, guess) if isinstance(system, Lagrangian) else system.velocity(p)


def kinetic_energy(system: System, p: Array) -> Array:
    """p . v / 2 at momenta p (n, ...) of a system whose v is linear in p, (n,).

    A massless body, whose p is 0, contributes 0.
    """
    twice = np.where(p == 0.0, 0.0, p * system.velocity(p))
    return 0.5 * twice.sum(axis=tuple(range(1, p.ndim)))
