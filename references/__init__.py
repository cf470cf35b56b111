"""Independent solvers of a `galvi.Problem`: closed forms, textbook methods and other engines."""

from __future__ import annotations

from collections.abc import Mapping

from galvi import Problem
from references.closed_forms.kepler import KEPLER
from references.closed_forms.oscillator import OSCILLATOR
from references.closed_forms.pendulum import PENDULUM
from references.closed_forms.top_motion import FREE_TOP, THROWN_BODY
from references.contender import Contender, EngineMissing, Reference, missing_engine, refusal
from references.heyoka.lagrangian import (
    HEYOKA_CHAIN,
    HEYOKA_CHAIN_QUADRUPLE,
    HEYOKA_LAGRANGIAN,
    HEYOKA_LAGRANGIAN_QUADRUPLE,
)
from references.heyoka.rigid import HEYOKA_RIGID, HEYOKA_RIGID_QUADRUPLE
from references.heyoka.taylor import HEYOKA, HEYOKA_QUADRUPLE
from references.jpl.ephemeris import JPL_EPHEMERIS
from references.mujoco.accelerations_ivp import MUJOCO_ACCELERATIONS
from references.mujoco.steps import (
    MUJOCO_DISCRETE,
    MUJOCO_EULER,
    MUJOCO_IMPLICIT,
    MUJOCO_IMPLICITFAST,
    MUJOCO_RK4,
)
from references.pinocchio.tree import PINOCCHIO_ACCELERATIONS
from references.rebound.bulirsch_stoer import BULIRSCH_STOER
from references.rebound.ias15 import IAS15
from references.rebound.leapfrog import LEAPFROG
from references.rebound.mercurius import MERCURIUS
from references.rebound.saba import SABA
from references.rebound.trace import TRACE
from references.rebound.whfast import WHFAST
from references.rebound.whfast512 import WHFAST512
from references.scipy.ivp import DOP853, ODE45, RADAU
from references.scipy.lagrangian_ivp import CHAIN_DOP853, LAGRANGIAN_DOP853
from references.scipy.rigid_ivp import RIGID_DOP853, RIGID_ODE45
from references.setting import nearest
from references.stored.attitude import STORED_ATTITUDE
from references.stored.chain import STORED_CHAIN
from references.stored.lagrangian import STORED_LAGRANGIAN
from references.stored.planets import STORED_TRUTH
from references.textbook.euler import (
    EXPLICIT_EULER,
    MATRIX_EULER,
    SEMI_IMPLICIT_EULER,
    STORMER_VERLET,
    SYMPLECTIC_EULER,
)
from references.textbook.fourth_order import FOREST_RUTH, RK4
from references.textbook.implicit_euler import IMPLICIT_EULER
from references.textbook.quaternions import QUATERNION_DOP853, QUATERNION_RK4

REFERENCES: tuple[Reference, ...] = (
    OSCILLATOR,
    KEPLER,
    PENDULUM,
    FREE_TOP,
    THROWN_BODY,
    STORED_TRUTH,
    STORED_ATTITUDE,
    STORED_CHAIN,
    STORED_LAGRANGIAN,
    JPL_EPHEMERIS,
    EXPLICIT_EULER,
    IMPLICIT_EULER,
    SYMPLECTIC_EULER,
    SEMI_IMPLICIT_EULER,
    STORMER_VERLET,
    FOREST_RUTH,
    RK4,
    ODE45,
    DOP853,
    RADAU,
    IAS15,
    BULIRSCH_STOER,
    WHFAST,
    WHFAST512,
    SABA,
    MERCURIUS,
    TRACE,
    LEAPFROG,
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
    LAGRANGIAN_DOP853,
    HEYOKA_LAGRANGIAN,
    HEYOKA_LAGRANGIAN_QUADRUPLE,
    MUJOCO_EULER,
    MUJOCO_RK4,
    MUJOCO_IMPLICIT,
    MUJOCO_IMPLICITFAST,
    MUJOCO_DISCRETE,
    MUJOCO_ACCELERATIONS,
    PINOCCHIO_ACCELERATIONS,
)


# Code and method -> contenders, of which `named` takes the first that supports the problem; there
# are several where types of systems need different equations.
CODES: Mapping[str, tuple[Reference, ...]] = {
    "rebound.whfast": (WHFAST,),
    "rebound.whfast512": (WHFAST512,),
    "rebound.saba": (SABA,),
    "rebound.mercurius": (MERCURIUS,),
    "rebound.trace": (TRACE,),
    "rebound.leapfrog": (LEAPFROG,),
    "rebound.ias15": (IAS15,),
    "rebound.bs": (BULIRSCH_STOER,),
    "mujoco.rk4": (MUJOCO_RK4,),
    "mujoco.euler": (MUJOCO_EULER,),
    "mujoco.implicit": (MUJOCO_IMPLICIT,),
    "mujoco.implicitfast": (MUJOCO_IMPLICITFAST,),
    "mujoco.discrete": (MUJOCO_DISCRETE,),
    "scipy.dop853": (
        DOP853,
        CHAIN_DOP853,
        LAGRANGIAN_DOP853,
        RIGID_DOP853,
        MUJOCO_ACCELERATIONS,
        PINOCCHIO_ACCELERATIONS,
    ),
    "scipy.rk45": (ODE45, RIGID_ODE45),
    "scipy.radau": (RADAU,),
    "heyoka.taylor": (HEYOKA, HEYOKA_CHAIN, HEYOKA_LAGRANGIAN, HEYOKA_RIGID),
    "heyoka.quadruple": (
        HEYOKA_QUADRUPLE,
        HEYOKA_CHAIN_QUADRUPLE,
        HEYOKA_LAGRANGIAN_QUADRUPLE,
        HEYOKA_RIGID_QUADRUPLE,
    ),
    "textbook.explicit_euler": (EXPLICIT_EULER, MATRIX_EULER),
    "textbook.implicit_euler": (IMPLICIT_EULER,),
    "textbook.symplectic_euler": (SYMPLECTIC_EULER,),
    "textbook.stormer_verlet": (STORMER_VERLET,),
    "textbook.forest_ruth": (FOREST_RUTH,),
    "textbook.rk4": (RK4,),
    "textbook.quaternion_rk4": (QUATERNION_RK4,),
    "textbook.quaternion_dop853": (QUATERNION_DOP853,),
}


def reference(name: str) -> Contender:
    """The reference of this name.

    Raises
    ------
    ValueError
        For an unknown name; the message suggests the most similar one.
    TypeError
        For a name that is no string.
    """
    if not isinstance(name, str):
        raise TypeError(f"the name of a reference must be a string; received {name!r}.")
    contenders = {contender.name: contender for contender in REFERENCES}
    if name not in contenders:
        raise ValueError(
            f"a reference is one of {', '.join(map(repr, contenders))}; received {name!r}. "
            f"Did you mean {nearest(name, contenders)!r}?"
        )
    return contenders[name]


def named(name: str, problem: Problem) -> Reference:
    """The first contender of a code that supports the problem.

    The name is that of a code in CODES, "heyoka" for "heyoka.taylor", or the full name of a
    reference. The contender's engine may be ``missing``.

    Raises
    ------
    ValueError
        For an unknown name; the message suggests the most similar one. Where no contender supports
        the problem, with the reason if it is known.
    TypeError
        For a name that is no string.
    """
    if not isinstance(name, str):
        raise TypeError(f"the name of a code must be a string; received {name!r}.")
    full = {contender.name: (contender,) for contender in REFERENCES}
    choices = {**full, **CODES, "heyoka": CODES["heyoka.taylor"]}
    if name not in choices:
        raise ValueError(
            f"a code is one of {', '.join(CODES)}, or the full name of a reference, such as "
            f"'REBOUND WHFast'; received {name!r}. Did you mean {nearest(name, CODES)!r}?"
        )
    for contender in choices[name]:
        if contender.supports(problem):
            return contender
    raise ValueError(refusal(name, choices[name], problem, "Take another code."))


__all__ = [
    "CODES",
    "REFERENCES",
    "Contender",
    "EngineMissing",
    "Reference",
    "missing_engine",
    "named",
    "reference",
]
