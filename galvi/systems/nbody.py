"""Point masses under Newtonian gravity."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.forces import celestial, force_kinds, nbody
from galvi.systems.finite_differences import differenced_hessian
from galvi.systems.forces.acting import Acting
from galvi.systems.system import ForceKernel
from galvi.systems.traces import reasons, trace

MAX_COUPLED_BODIES = 4  # largest number of bodies that one Newton block couples


@dataclass(frozen=True, eq=False)
class NBody:
    """``L = sum m_i |v_i|^2 / 2 + sum over pairs G m_i m_j / |q_i - q_j|``, and other forces.

    Parameters
    ----------
    masses : array, shape (bodies,)
        finite, at least one positive and none negative. Massless bodies, in any order, are
        attracted and attract nothing; each costs one pair for every body with a mass
    G
        gravitational constant in the units of the problem, finite and positive
    forces
        further forces: `Relativity`, `Oblateness`, `PowerLaw`, `Radiation`, `Drag`, `Tides` and
        `Force` values, any number of them. With one that depends on velocities every body needs a
        mass

    Raises
    ------
    ValueError
        For masses that are negative or all 0 and for forces that cannot act on these bodies; by
        `galvi.Problem` for shapes that do not fit and for coincident bodies.
    TypeError
        For a force that is not one of these values.

    Notes
    -----
    Configurations have shape (bodies, 2) or (bodies, 3); ``p = masses[:, None] * v``. The momentum
    of a massless body is 0 at any velocity; `galvi.Trajectory.v` has its velocity.

    Examples
    --------
    >>> pair = galvi.NBody(masses=[3.0, 1.0], G=1.0)
    >>> problem = galvi.Problem(pair, q0=[[-0.25, 0], [0.75, 0]], v0=[[0, -0.5], [0, 1.5]])
    >>> problem.p0.sum(axis=0)
    array([0., 0.])
    """

    masses: Array
    G: float = 1.0
    forces: Any = ()

    def __post_init__(self) -> None:
        masses = input_checks.array("masses", self.masses, remedy="Give one for each body.")
        if masses.ndim != 1 or masses.size == 0:
            raise ValueError(f"masses must have shape (bodies,); received shape {masses.shape}.")
        if np.any(masses < 0.0) or not np.any(masses > 0.0):
            lightest = int(np.argmin(masses))
            raise ValueError(
                f"masses must not be negative, and one must be positive; received "
                f"{masses[lightest]} for body {lightest}. Massless bodies feel and do not pull."
            )
        object.__setattr__(self, "masses", masses)
        object.__setattr__(self, "G", input_checks.positive("G", self.G))
        object.__setattr__(self, "forces", self.acting.forces)

    def __reduce__(self) -> tuple[Any, ...]:
        return NBody, (self.masses, self.G, self.forces)

    @cached_property
    def acting(self) -> Acting:
        """The forces, as kernels take them."""
        return Acting(self.forces, self.masses, self.G)

    def velocity_shape(self, shape: tuple[int, ...]) -> tuple[int, ...]:
        """The shape of a configuration: velocities and momenta are like q."""
        return shape

    def check_state(self, q: Array, v: Array, t: float) -> None:
        """ValueError unless q is (bodies, 2) or (bodies, 3), no body coincides with one that has a
        mass, and the forces can act at this state."""
        bodies = self.masses.size
        if q.shape not in ((bodies, 2), (bodies, 3)):
            raise ValueError(
                f"q0 must have shape ({bodies}, 2) or ({bodies}, 3), one row for each of the "
                f"{bodies} masses; received shape {q.shape}."
            )
        for i in range(bodies):
            pulls = self.masses[i] + self.masses[i + 1 :] > 0.0
            with np.errstate(over="ignore"):
                square = np.sum((q[i + 1 :] - q[i]) ** 2, axis=1)  # 0 below 1e-162 too
            same = np.flatnonzero(pulls & (square == 0.0))
            if same.size:
                raise ValueError(
                    f"bodies must start at different places; received bodies {i} and "
                    f"{i + 1 + int(same[0])} at the same point. Move one of them or merge the two."
                )
        self.acting.check_state(q, v, t)

    def trace(self, q: Array, v: Array, t: float, anew: bool = False) -> None:
        """As `Lagrangian.trace`, for users' functions; nothing where no force depends on
        velocities."""
        if self.acting.of_velocity and self.acting.functions:
            trace(self, q, v, t, anew)

    @property
    def untraced(self) -> str:
        """As `Lagrangian.untraced`."""
        return reasons(self)

    def momentum(self, v: Array) -> Array:
        """p = m v."""
        return self.masses[:, None] * v

    def velocity(self, p: Array) -> Array:
        """v = p / m; NaN for a massless body."""
        return p / np.where(self.masses > 0.0, self.masses, np.nan)[:, None]

    @cached_property
    def has_massless(self) -> bool:
        """Whether some bodies are massless, so that momenta do not determine velocities."""
        return bool(np.any(self.masses == 0.0))

    @property
    def pairs(self) -> int:
        """Pairs of bodies that attract one another, or one the other."""
        n, heavy = self.masses.size, int(np.count_nonzero(self.masses))
        return heavy * (heavy - 1) // 2 + heavy * (n - heavy)

    def potential_energy(self, q: Array, t: Array) -> Array:
        """``-sum over pairs G m_i m_j / |q_i - q_j|`` plus the potentials of the forces, (...), for
        q of shape (..., bodies, dimension)."""
        positions = np.ascontiguousarray(q, dtype=np.float64).reshape(-1, *q.shape[-2:])
        potentials = np.empty(len(positions))
        nbody.compiled_pair_potential()(positions, self.masses, self.G, potentials)
        total = potentials.reshape(q.shape[:-2])
        acting = self.acting
        return total + celestial.pulls(acting.terms, acting.poles, q)[1] if acting.forces else total

    def acceleration(self, q: Array, t: float, v: Array | None = None) -> Array:
        """Accelerations (bodies, dimension), at rest unless v (bodies, dimension) is given."""
        acting, total = self.acting, self.fall(q)
        return (
            total
            if acting.conserve
            else total + acting.extra_accelerations(q, 0.0 * q if v is None else v, t)
        )

    def fall(self, q: Array) -> Array:
        """Accelerations (bodies, dimension) by gravity and the forces that have a potential."""
        acting, out, size = self.acting, np.empty((q.size, 1)), q.shape[1]
        positions = np.ascontiguousarray(q).reshape(-1, 1)
        kernel = celestial.accelerations if len(acting.terms) else nbody.accelerations
        kernel(positions, np.zeros(1), acting.constants(size), out)
        return out.reshape(q.shape)

    def acceleration_jacobian(self, q: Array, t: float) -> Array:
        """Derivative of all accelerations with respect to all positions at zero velocity, (d, d)
        with d = bodies * dimension; of `Force` functions and forces of velocity by differences."""
        bodies, dimension = q.shape
        gap = q[None, :, :] - q[:, None, :]
        square = np.sum(gap**2, axis=-1) + np.eye(bodies)
        square[square == 0.0] = 1.0  # of massless bodies, which do not pull
        outer = 3.0 * gap[..., :, None] * gap[..., None, :] / square[..., None, None]
        pull = self.G * self.masses[None, :] / square**1.5 * (1.0 - np.eye(bodies))
        coupling = -pull[..., None, None] * (outer - np.eye(dimension))
        diagonal = np.arange(bodies)
        coupling[diagonal, diagonal] = -np.sum(coupling, axis=1)
        slope = np.ascontiguousarray(coupling.transpose(0, 2, 1, 3)).reshape(q.size, q.size)
        acting = self.acting
        if acting.forces:
            slope += celestial.pulls_slope(acting.terms, acting.poles, q)
        if not acting.conserve:
            slope += differenced_hessian(
                lambda x: acting.extra_accelerations(x.reshape(q.shape), 0.0 * q, t).ravel()
            )(q.ravel())
        return slope

    def force_kernel(self, dimension: int) -> ForceKernel:
        """Accelerations for the kernels; one Newton block for up to ``MAX_COUPLED_BODIES`` bodies,
        else one for each body."""
        coupled, acting = self.masses.size <= MAX_COUPLED_BODIES, self.acting
        width = self.masses.size * dimension if coupled else dimension
        if acting.functions:
            return ForceKernel(
                acting.accelerations(dimension),
                None,
                force_kinds.TIMED_GRADIENT,
                np.zeros((0, 0)),
                width,
                acting.constants(dimension),
                acting.compiled,
            )
        slope: Any = nbody.all_jacobians if coupled else nbody.own_jacobians
        return ForceKernel(
            celestial.accelerations if len(acting.terms) else nbody.accelerations,
            None if len(acting.terms) else slope,
            force_kinds.BUILT_IN,
            np.zeros((0, 0)),
            width,
            acting.constants(dimension),
        )
