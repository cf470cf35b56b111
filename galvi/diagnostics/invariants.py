"""Energy and momenta of a run, and the balance of momentum under forces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.diagnostics import group_momenta
from galvi.diagnostics.symplecticity import stage_states
from galvi.groups.group import SE2, SE3, SO2, SO3, Group, Rn
from galvi.groups.product import Product
from galvi.input_checks import flag, shown
from galvi.systems.canonical import Canonical
from galvi.systems.forces.external_force import force_at
from galvi.systems.lagrangian import Lagrangian, kinetic_energy, momentum_at, velocity_at
from galvi.systems.multibody import Multibody
from galvi.systems.nbody import NBody
from galvi.systems.rigid_body import RigidBody
from galvi.systems.system import VectorSystem
from galvi.trajectory import Trajectory

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


def energy(run: Trajectory, t: Any = None) -> Array:
    """The energy of a run at its saved times, or on its curves.

    Parameters
    ----------
    run : galvi.Trajectory
        of any system
    t : float or array, optional
        times on the curves of the steps; None: the saved times

    Returns
    -------
    array, shape (saved,) or that of t
        kinetic plus potential energy, in units of mass length^2 / time^2; for a Lagrangian
        v dL/dv - L. NaN past a failed step

    Raises
    ------
    ValueError
        When t is outside the run.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> run = galvi.integrate(galvi.problems.kepler(0.3), method, step=0.25, steps=40)
    >>> bool(abs(galvi.energy(run) + 0.5).max() < 1e-12), galvi.energy(run, t=[0.1, 0.2]).shape
    (True, (2,))
    """
    times, q, p = _states(run, t)
    system = run.problem.system
    if isinstance(system, Lagrangian):
        v = velocity_at(system, q, p, times, run.problem.v0) if t is None else run.velocity(t)
        return system.energy(q, v, times)
    flat_kinetic = kinetic_energy(system, p.reshape(-1, *run.problem.v0.shape))
    kinetic = flat_kinetic.reshape(times.shape)
    return kinetic + cast(VectorSystem, system).potential_energy(q, times)


def momentum_map(run: Trajectory, t: Any = None) -> Array:
    """Angular momentum about the origin.

    It is the momentum map J of the rotations of space: J . w = d/de L(q, v + e xi), with xi the
    velocity of q while space turns with angular velocity w. Summed over bodies and points, it is

    - x cross p of a point at x: of a Canonical system of one body whose mass is a number, of each
      body of an NBody system, of a factor Rn(2) or Rn(3) of a Product;
    - R mu_rot + x cross R mu_lin of a body [[R, x], [0, 1]]: of a FreeBody, or on SE(3);
    - R mu of a RigidBody about its fixed point, or on SO(3);
    - mu_rot + x cross R mu_lin on SE(2), and mu on SO(2),

    where mu = (mu_rot, mu_lin) is a body's part of run.p: left-trivialised, that is, about x and in
    the body's axes. That of a Multibody is the sum over its bodies. On a group, the system may be
    any, such as a `galvi.Lagrangian`: J is conserved where L does not change as space turns, and
    only there; it changes by the moment of forces otherwise. At steps it is conserved to round-off,
    along the curve to the accuracy of the curve.

    Source: Marsden and Ratiu, Introduction to Mechanics and Symmetry, chapters 11 and 12; for
    integrators on groups Hall and Leok, Lie group variational integrators, section 3.

    Parameters
    ----------
    run : galvi.Trajectory
        a run of a system in the list above
    t : float or array, optional
        times on the curves of the steps; None: the saved times

    Returns
    -------
    array, shape (...,) in the plane, (..., 3) in space
        one value or vector for each time

    Raises
    ------
    ValueError
        When it is not known how rotations of space act on the system: a Lagrangian on Rn(n), other
        factors of a Product, and a Product with factors both in the plane and in space.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> run = galvi.integrate(galvi.problems.kepler(0.6), method, step=0.1, steps=100)
    >>> np.allclose(galvi.momentum_map(run), 0.8, rtol=1e-13)
    True
    """
    times, q, p = _states(run, t)
    group = _group(run)
    if isinstance(run.problem.system, Multibody):
        return _tree_momenta(run, times, q, p, t)[..., :3]
    if group is not None:
        return group_momenta.angular_momentum(group, q, p)
    _require_space(run)
    moments = group_momenta.moment(q, p)
    in_space = q.shape[-1] == 3
    return moments if moments.ndim == times.ndim + in_space else np.sum(moments, axis=-1 - in_space)


def linear_momentum(run: Trajectory, t: Any = None) -> Array:
    """Total linear momentum, in the axes of space.

    That of a point is p, that of a body on SE(2) or SE(3) is R mu_lin. Factors SO(2) and SO(3) of a
    Product contribute nothing, since translations do not act on them. It is conserved where L is
    invariant under translations.

    Parameters
    ----------
    run : galvi.Trajectory
        of a system as in `momentum_map`
    t : float or array, optional
        times on the curves of the steps; None: the saved times

    Returns
    -------
    array, shape (..., 2) or (..., 3)
        one vector for each time

    Raises
    ------
    ValueError
        As `momentum_map`, and for a system without positions: a RigidBody, or another on SO(2),
        SO(3) or a Product of these.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> run = galvi.integrate(galvi.problems.free_body_se3(mass=2.0), method, step=0.1, steps=10)
    >>> galvi.linear_momentum(run)[-1].round(9)
    array([ 0.6,  0.4, -0.2])
    """
    times, q, p = _states(run, t)
    group = _group(run)
    if isinstance(run.problem.system, Multibody):
        return _tree_momenta(run, times, q, p, t)[..., 3:]
    if group is not None and not isinstance(run.problem.system, RigidBody):
        return group_momenta.linear_momentum(group, q, p)
    _require_space(run)
    return p if p.ndim == times.ndim + 1 else np.sum(p, axis=-2)


def _group(run: Trajectory) -> Group | None:
    """The group of a system whose configurations are not points of R^n alone; else None."""
    group: Group | None = getattr(run.problem.system, "group", None)
    return None if isinstance(group, Rn) else group


def _tree_momenta(run: Trajectory, times: Array, q: Array, p: Array, t: Any) -> Array:
    """Angular momentum and momentum (..., 6) of a Multibody."""
    system = cast(Multibody, run.problem.system)
    v = velocity_at(system, q, p, times, run.problem.v0) if t is None else run.velocity(t)
    momenta = system.tree.momenta(q.reshape(-1, run.problem.q0.size), v.reshape(-1, v.shape[-1]))
    return momenta.reshape(*times.shape, 6)


def _states(run: Trajectory, t: Any) -> tuple[Array, Array, Array]:
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a galvi.Trajectory; received {shown(run)}.")
    if t is None:
        return run.t, run.q, run.p
    q, times = run(t), np.asarray(t, dtype=np.float64)
    return times, q, momentum_at(run.problem.system, q, run.velocity(t), times)


def _require_space(run: Trajectory) -> None:
    system, q0 = run.problem.system, run.problem.q0
    if isinstance(system, Lagrangian):
        raise ValueError(
            "a Lagrangian does not say how rotations and translations of space act on its group; "
            "compute their momenta from run.q and run.p, or use a galvi.Canonical, RigidBody or "
            "FreeBody system, or a galvi.Product, whose factors galvi.Rn(2) or Rn(3) are points."
        )
    if isinstance(system, RigidBody):
        raise ValueError(
            "a galvi.RigidBody rotates about a point and has no linear momentum of its own; use "
            "galvi.momentum_map for its angular momentum, or a galvi.FreeBody, which moves."
        )
    in_space = isinstance(system, NBody) or (
        isinstance(system, Canonical) and q0.size in (2, 3) and system.mass.ndim == 0
    )
    if not in_space:
        raise ValueError(
            f"momentum of rotations and translations needs bodies in the plane or in space with "
            f"scalar masses; received a {type(system).__name__} system with q of shape {q0.shape}."
        )


@dataclass(frozen=True, eq=False)
class MomentumBalance:
    """A momentum at each step and the impulses that changed it; arrays of the same shape.

    Attributes
    ----------
    t : array, shape (steps + 1,)
    momentum : array, shape (steps + 1, ...)
        as `galvi.momentum_map` or `galvi.linear_momentum` gives it
    potential
        impulse of the potential since the start
    force
        impulse of the external force since the start

    Notes
    -----
    momentum - momentum[0] - potential - force is ``defect``: round-off for every space and rule,
    since the stage equations hold for the variations that translate or rotate a curve (the forced
    discrete theorem of Noether: Marsden and West, Acta Numerica 10 (2001), 3.2.3); with degrees
    for each component a rotation is no such variation, and the defect says how much that matters.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> run = galvi.integrate(galvi.problems.pendulum_3d(), method, step=0.1, steps=20)
    >>> balance = galvi.momentum_balance(run)
    >>> balance.momentum.shape, balance.potential.shape, bool(balance.force.any())
    ((21, 3), (21, 3), False)
    """

    t: Array
    momentum: Array
    potential: Array
    force: Array

    @property
    def defect(self) -> Array:
        """The change of momentum that neither impulse explains, in momentum's shape."""
        return self.momentum - self.momentum[0] - self.potential - self.force


def momentum_balance(run: Trajectory, *, linear: bool = False) -> MomentumBalance:
    """The momentum after each step of a run, and the impulses that change it.

    Parameters
    ----------
    run : galvi.Trajectory
        a run of a Canonical system of one body in the plane or in space, or of a RigidBody, with
        its curves
    linear : bool
        whether to balance the linear momentum instead of the angular momentum about the origin; not
        for a RigidBody

    Returns
    -------
    galvi.MomentumBalance
        the momentum and the impulses of potential and force, one value for each step

    Raises
    ------
    ValueError
        For another system and for a run without curves at every step.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> run = galvi.integrate(galvi.problems.pendulum_3d(), method, step=0.1, steps=20)
    >>> bool(abs(galvi.momentum_balance(run).defect).max() < 1e-12)
    True
    """
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a galvi.Trajectory; received {shown(run)}.")
    system: Any = run.problem.system
    if not isinstance(system, Canonical | RigidBody):
        raise ValueError(
            f"the balance of momentum is for a Canonical system of one body or a RigidBody; "
            f"received a {type(system).__name__} system."
        )
    momentum = linear_momentum(run) if flag("linear", linear) else momentum_map(run)
    t, q, v, weights = stage_states(run)
    if len(momentum) != len(t) + 1:
        raise ValueError("the balance of momentum needs every step; integrate with save_every=1.")
    potential_forces, external_forces = np.zeros((2, *q.shape[:2], run.problem.v0.size))
    for step, stage in np.ndindex(q.shape[:2]):
        state = q[step, stage], float(t[step, stage])
        if not np.all(np.isfinite(q[step, stage])):
            potential_forces[step, stage] = external_forces[step, stage] = np.nan
            continue
        potential_forces[step, stage] = _potential_force(system, *state)
        external_forces[step, stage] = force_at(system, state[0], v[step, stage], state[1])
    impulses = [_impulse(part, q, weights, linear) for part in (potential_forces, external_forces)]
    return MomentumBalance(run.t, momentum, *impulses)


def _potential_force(system: Canonical | RigidBody, q: Array, t: float) -> Array:
    if isinstance(system, RigidBody):
        return system.torque(q, t)
    return -system.potential_gradient(q, t)


def _impulse(forces: Array, q: Array, weights: Array, linear: bool) -> Array:
    """Accumulated impulse (steps + 1, ...) of forces (steps, s, d) at configurations q."""
    if q.ndim == 4:
        momentum_rates = np.einsum("ksab,ksb->ksa", q, forces)
    elif linear:
        momentum_rates = forces
    else:
        momentum_rates = group_momenta.moment(q, forces)
    step_impulses = np.tensordot(momentum_rates, weights, axes=(1, 0))
    return read_only(
        np.concatenate([np.zeros((1, *step_impulses.shape[1:])), np.cumsum(step_impulses, axis=0)])
    )


def rotations(run: Trajectory, t: Any = None) -> Rotation:
    """The attitudes of a rigid body, from body to space.

    Parameters
    ----------
    run : galvi.Trajectory
        on SO(3) or SE(3)
    t : float or array, optional
        times on the curves of the steps; None: the saved times

    Returns
    -------
    scipy.spatial.transform.Rotation
        which converts further: ``.as_quat(scalar_first=True)``, ``.as_euler("zyx")``,
        ``.magnitude()``

    Raises
    ------
    ValueError
        For a run on another group, with the remedy on a Product and in the plane; for states past
        a failed step.
    TypeError
        When run is not a Trajectory.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> run = galvi.integrate(galvi.problems.free_rigid_body(), method, step=0.1, steps=10)
    >>> galvi.rotations(run).as_quat(scalar_first=True).shape
    (11, 4)
    """
    group, q = _group_and_configurations(run, t)
    if not isinstance(group, SO3 | SE3):
        raise ValueError(
            f"attitudes need a run on SO(3) or SE(3), such as of a galvi.RigidBody; received "
            f"{run!r}.{_conversion_hint(group)}"
        )
    R = q[..., :3, :3]
    if not np.all(np.isfinite(R)):
        raise ValueError(
            "the run failed, and its states past the failure are NaN; take them out first, e.g. "
            "with t up to the failed step."
        )
    from scipy.spatial.transform import Rotation  # a fifth of galvi's import

    return Rotation.from_matrix(R)


def _conversion_hint(group: Any) -> str:
    """How attitudes come from configurations of a Product or in the plane; else empty."""
    if isinstance(group, Product):
        return (
            " Take a factor's matrices from run.problem.system.group.parts(run.q), and give them "
            "to scipy.spatial.transform.Rotation.from_matrix."
        )
    if isinstance(group, SO2 | SE2):
        return " The angle in the plane is np.arctan2(run.q[:, 1, 0], run.q[:, 0, 0])."
    return ""


def orthogonality_defect(run: Trajectory, t: Any = None) -> Array:
    """The largest entry of ``|R^T R - I|``.

    Parameters
    ----------
    run : galvi.Trajectory
        on SO(2), SE(2), SO(3), SE(3) or a Product with such a factor
    t : float or array, optional
        times on the curves of the steps; None: the saved times

    Returns
    -------
    array, shape (saved,) or that of t
        the largest entry over all rotations of the configuration

    Raises
    ------
    ValueError
        For a system without rotations.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> run = galvi.integrate(galvi.problems.free_rigid_body(), method, step=0.1, steps=100)
    >>> bool(galvi.orthogonality_defect(run).max() < 1e-13)
    True
    """
    group, q = _group_and_configurations(run, t)
    attitudes = [] if group is None else group_momenta.attitudes(group, q)
    if not attitudes:
        raise ValueError(
            f"the defect of rotation matrices needs a run on SO(2), SE(2), SO(3), SE(3) or a "
            f"galvi.Product with such a factor; received {run!r}."
        )
    squares = (np.einsum("...ki,...kj->...ij", R, R) - np.eye(R.shape[-1]) for R in attitudes)
    return np.max([np.max(np.abs(square), axis=(-2, -1)) for square in squares], axis=0)


def _group_and_configurations(run: Trajectory, t: Any) -> tuple[Group | None, Array]:
    """The group of a run, None if it has none, and its configurations."""
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a galvi.Trajectory; received {shown(run)}.")
    return _group(run), run.q if t is None else run(t)
