"""Other ways to solve the same problem: closed forms, textbook methods and trusted engines."""

from __future__ import annotations

from references.bulirsch_stoer import BULIRSCH_STOER
from references.chain_ivp import CHAIN_DOP853
from references.contender import Contender
from references.ephemeris import JPL_EPHEMERIS
from references.euler import EXPLICIT_EULER, SYMPLECTIC_EULER
from references.free_top import FREE_TOP
from references.heyoka_chain import HEYOKA_CHAIN, HEYOKA_CHAIN_QUADRUPLE
from references.heyoka_rigid import HEYOKA_RIGID, HEYOKA_RIGID_QUADRUPLE
from references.heyoka_taylor import HEYOKA, HEYOKA_QUADRUPLE
from references.ias15 import IAS15
from references.implicit_euler import IMPLICIT_EULER
from references.janus import JANUS
from references.kepler import KEPLER
from references.leapfrog import LEAPFROG
from references.matrix_euler import MATRIX_EULER
from references.mujoco_steps import (
    MUJOCO_DISCRETE,
    MUJOCO_EULER,
    MUJOCO_IMPLICIT,
    MUJOCO_IMPLICITFAST,
    MUJOCO_RK4,
)
from references.oscillator import OSCILLATOR
from references.pendulum import PENDULUM
from references.quaternion_dop853 import QUATERNION_DOP853
from references.quaternion_rk4 import QUATERNION_RK4
from references.rigid_ivp import RIGID_DOP853, RIGID_ODE45
from references.saba import SABA
from references.scipy_ivp import DOP853, ODE45, RADAU
from references.semi_implicit_euler import SEMI_IMPLICIT_EULER
from references.setting import nearest
from references.stored_attitude import STORED_ATTITUDE
from references.stored_chain import STORED_CHAIN
from references.stormer_verlet import STORMER_VERLET
from references.truth import STORED_TRUTH
from references.whfast import WHFAST
from references.whfast512 import WHFAST512

REFERENCES: tuple[Contender, ...] = (
    OSCILLATOR,
    KEPLER,
    PENDULUM,
    FREE_TOP,
    STORED_TRUTH,
    STORED_ATTITUDE,
    STORED_CHAIN,
    JPL_EPHEMERIS,
    EXPLICIT_EULER,
    IMPLICIT_EULER,
    SYMPLECTIC_EULER,
    SEMI_IMPLICIT_EULER,
    STORMER_VERLET,
    ODE45,
    DOP853,
    RADAU,
    IAS15,
    BULIRSCH_STOER,
    WHFAST,
    WHFAST512,
    SABA,
    LEAPFROG,
    JANUS,
    HEYOKA,
    HEYOKA_QUADRUPLE,
    MATRIX_EULER,
    RIGID_ODE45,
    RIGID_DOP853,
    QUATERNION_RK4,
    QUATERNION_DOP853,
    HEYOKA_RIGID,
    HEYOKA_RIGID_QUADRUPLE,
    CHAIN_DOP853,
    HEYOKA_CHAIN,
    HEYOKA_CHAIN_QUADRUPLE,
    MUJOCO_EULER,
    MUJOCO_RK4,
    MUJOCO_IMPLICIT,
    MUJOCO_IMPLICITFAST,
    MUJOCO_DISCRETE,
)


def reference(name: str) -> Contender:
    """The reference of this name; ValueError, with the nearest known one, when there is none."""
    known = {contender.name: contender for contender in REFERENCES}
    if name not in known:
        raise ValueError(
            f"a reference is one of {', '.join(known)}; received {name!r}. "
            f"Did you mean {nearest(name, known)!r}?"
        )
    return known[name]


__all__ = ["REFERENCES", "Contender", "reference"]
