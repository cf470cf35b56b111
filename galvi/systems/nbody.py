"""Point masses under Newtonian gravity."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.forces import force_kinds, nbody
from galvi.kernels.forces.pair_potential import compiled_pair_potential
from galvi.systems.system import ForceKernel

COUPLED = 4


@dataclass(frozen=True, eq=False)
class NBody:
    """L = sum m_i |v_i|^2 / 2 + sum over pairs G m_i m_j / |q_i - q_j|.

    masses  (bodies,), finite, at least one positive and none negative. Massless bodies, in any
            order, are attracted and attract nothing; each costs one pair for every body with a
            mass
    G       gravitational constant in the units of the problem, finite and positive

    Configurations have shape (bodies, 2) or (bodies, 3); p = masses[:, None] * v. That of a
    massless body is 0 at any velocity, which is kept as `galvi.Trajectory.v`.
    Raises ValueError for masses or shapes that do not fit and for coincident bodies.
    """

    masses: Array
    G: float = 1.0

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

    def velocity_shape(self, shape: tuple[int, ...]) -> tuple[int, ...]:
        """The shape of a configuration: velocities and momenta are like q."""
        return shape

    def check_state(self, q: Array, v: Array) -> None:
        """ValueError unless q is (bodies, 2 or 3) with all bodies apart."""
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
        """-sum over pairs G m_i m_j / |q_i - q_j|, for q of shape (..., bodies, dimension)."""
        places = np.ascontiguousarray(q, dtype=np.float64).reshape(-1, *q.shape[-2:])
        found = np.empty(len(places))
        compiled_pair_potential()(places, self.masses, self.G, found)
        return found.reshape(q.shape[:-2])

    def acceleration(self, q: Array, t: float) -> Array:
        """Gravitational accelerations, (bodies, dimension)."""
        out = np.empty((q.size, 1))
        constants = self._constants(q.shape[1])
        nbody.accelerations(np.ascontiguousarray(q).reshape(-1, 1), np.array([t]), constants, out)
        return out.reshape(q.shape)

    def acceleration_jacobian(self, q: Array, t: float) -> Array:
        """Derivative of all accelerations by all positions, (d, d) with d = bodies * dimension."""
        bodies, dimension = q.shape
        gap = q[None, :, :] - q[:, None, :]
        square = np.sum(gap**2, axis=-1) + np.eye(bodies)
        square[square == 0.0] = 1.0  # of massless bodies, which do not pull
        outer = 3.0 * gap[..., :, None] * gap[..., None, :] / square[..., None, None]
        pull = self.G * self.masses[None, :] / square**1.5 * (1.0 - np.eye(bodies))
        coupling = -pull[..., None, None] * (outer - np.eye(dimension))
        own = np.arange(bodies)
        coupling[own, own] = -np.sum(coupling, axis=1)
        return np.ascontiguousarray(coupling.transpose(0, 2, 1, 3)).reshape(q.size, q.size)

    def force_kernel(self, dimension: int) -> ForceKernel:
        """Accelerations for the kernels; Newton's blocks are whole for up to ``COUPLED`` bodies,
        else one for each body."""
        coupled = self.masses.size <= COUPLED
        return ForceKernel(
            nbody.accelerations,
            nbody.all_jacobians if coupled else nbody.own_jacobians,
            force_kinds.BUILT_IN,
            constants=self._constants(dimension),
            inverse_mass=np.zeros((0, 0)),
            width=self.masses.size * dimension if coupled else dimension,
        )

    def _constants(self, dimension: int) -> Array:
        return np.concatenate([[float(dimension)], self.G * self.masses])
