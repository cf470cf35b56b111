"""The list of agreements: each reference with a problem and the limit on the difference.

The comment beside each limit is the difference measured when the limit was set.
"""

from __future__ import annotations

from benchmarks.claims.agreement import AgreementCase, agreement
from benchmarks.claims.kit import *
from benchmarks.claims.truths import TRUTHS
from benchmarks.test_problems.planets import PAIR
from references.closed_forms.kepler import KEPLER
from references.closed_forms.oscillator import OSCILLATOR
from references.closed_forms.pendulum import PENDULUM
from references.closed_forms.top_motion import FREE_TOP, THROWN_BODY
from references.contender import Contender
from references.heyoka import taylor as heyoka_taylor
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
from references.rebound import bulirsch_stoer, leapfrog, saba, whfast, whfast512
from references.rebound.bulirsch_stoer import BULIRSCH_STOER
from references.rebound.ias15 import IAS15
from references.rebound.leapfrog import LEAPFROG
from references.rebound.mercurius import MERCURIUS
from references.rebound.saba import SABA
from references.rebound.trace import TRACE
from references.rebound.whfast import WHFAST
from references.rebound.whfast512 import WHFAST512
from references.scipy.ivp import DOP853, ODE45, RADAU, TIGHT
from references.scipy.lagrangian_ivp import CHAIN_DOP853, LAGRANGIAN_DOP853
from references.scipy.rigid_ivp import RIGID_DOP853, RIGID_ODE45
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

SPRING, ORBIT = galvi.problems.harmonic_oscillator(), galvi.problems.kepler(0.3)
SWING, TURN = galvi.problems.planar_pendulum(), galvi.problems.free_rigid_body()
HANGING, PLANETS = galvi.problems.pendulum_3d(), galvi.problems.solar_system()
CHAIN = galvi.problems.double_pendulum()
SPRUNG = galvi.problems.elastic_pendulum  # made when asked for, by SymPy
THROWN, ARM = galvi.problems.free_body_se3(), galvi.problems.skew_arm()
OF_SECOND, OF_FIRST = "Its error of second order in its step.", "Its error of first order."
OWN = "Its own error at this setting."
LONG = "Rounding over 500 steps of two days."
POINTS = "Point masses without relativity, Moon and asteroids."

CLOSED = (
    AgreementCase(OSCILLATOR, SPRING, 1.0, 2e-15),  # 1e-16
    AgreementCase(KEPLER, ORBIT, 1.0, 2e-15),  # 1e-16
    AgreementCase(PENDULUM, SWING, 1.0, 2e-15),  # 0
    AgreementCase(FREE_TOP, TURN, 1.0, 4e-15),  # 3e-16
    AgreementCase(THROWN_BODY, THROWN, 1.0, 4e-15),  # 4e-16
)
STORED = (
    AgreementCase(STORED_TRUTH, PLANETS, 1000.0, 2e-13, 500, note=LONG),  # 1e-14
    AgreementCase(STORED_CHAIN, CHAIN, 1.0, 1e-14),  # 5e-16
    AgreementCase(STORED_LAGRANGIAN, SPRUNG, 1.0, 1e-14),  # 2e-16
    AgreementCase(STORED_ATTITUDE, HANGING, 1.0, 2e-15),  # 6e-17
)
REBOUND = (
    AgreementCase(IAS15, PAIR, 1.0, 2e-15),  # 1e-16
    AgreementCase(BULIRSCH_STOER, PAIR, 1.0, 1e-13, setting=bulirsch_stoer.BEST, note=OWN),  # 2e-15
    AgreementCase(WHFAST, PAIR, 1.0, 1e-13, setting={"step": 0.1, **whfast.BEST}),  # 1e-15
    AgreementCase(WHFAST512, PAIR, 1.0, 1e-13, setting={"step": 0.1, **whfast512.BEST}),  # 5e-15
    AgreementCase(SABA, PAIR, 1.0, 1e-13, setting={"step": 0.1, **saba.BEST}),  # 2e-16
    AgreementCase(MERCURIUS, PAIR, 1.0, 1e-11, setting={"step": 1e-4}, note=OF_SECOND),  # 1e-12
    AgreementCase(TRACE, PAIR, 1.0, 1e-11, setting={"step": 1e-4}, note=OF_SECOND),  # 1e-12
    AgreementCase(LEAPFROG, PAIR, 1.0, 1e-13, setting={"step": 0.005, **leapfrog.BEST}),  # 1e-15
)
MUJOCO = (
    AgreementCase(MUJOCO_RK4, TURN, 1.0, 1e-12, setting={"step": 1e-3}, note=OWN),  # 5e-14
    AgreementCase(MUJOCO_EULER, TURN, 1.0, 1e-3, setting={"step": 1e-3}, note=OF_FIRST),  # 3e-4
    AgreementCase(MUJOCO_IMPLICIT, TURN, 1.0, 1e-3, setting={"step": 1e-3}, note=OF_FIRST),  # 4e-4
    AgreementCase(
        MUJOCO_IMPLICITFAST, TURN, 1.0, 1e-3, setting={"step": 1e-3}, note=OF_FIRST
    ),  # 3e-4
    AgreementCase(MUJOCO_DISCRETE, TURN, 1.0, 1e-3, setting={"step": 1e-3}, note=OF_FIRST),  # 3e-4
    AgreementCase(MUJOCO_ACCELERATIONS, ARM, 0.5, 1e-12, note=OWN),  # 1e-14
)
HEYOKAS = (
    AgreementCase(
        HEYOKA, PAIR, 1.0, 2e-15, setting={**heyoka_taylor.BEST, "compact_mode": True}
    ),  # 1e-16
    AgreementCase(HEYOKA_QUADRUPLE, ORBIT, 1.0, 2e-15),  # 1e-16
    AgreementCase(HEYOKA_CHAIN, CHAIN, 1.0, 1e-14),  # 5e-16
    AgreementCase(HEYOKA_CHAIN_QUADRUPLE, CHAIN, 1.0, 1e-14),  # 5e-16
    AgreementCase(HEYOKA_LAGRANGIAN, SPRUNG, 1.0, 1e-14),  # 2e-16
    AgreementCase(HEYOKA_LAGRANGIAN_QUADRUPLE, SPRUNG, 1.0, 1e-14),  # 2e-16
    AgreementCase(HEYOKA_RIGID, TURN, 1.0, 2e-15),  # 2e-16
    AgreementCase(HEYOKA_RIGID_QUADRUPLE, HANGING, 1.0, 2e-15),  # 6e-17
)
SCIPY = (
    AgreementCase(DOP853, ORBIT, 1.0, 2e-13, setting=TIGHT, note=OWN),  # 2e-14
    AgreementCase(ODE45, ORBIT, 1.0, 2e-8, setting={"tolerance": 1e-9}, note=OWN),  # 4e-9
    AgreementCase(RADAU, ORBIT, 1.0, 1e-11, setting={"tolerance": 1e-9}, note=OWN),  # 1e-12
    AgreementCase(CHAIN_DOP853, CHAIN, 1.0, 1e-12, setting={"tolerance": 1e-13}, note=OWN),  # 5e-14
    AgreementCase(
        LAGRANGIAN_DOP853, SPRUNG, 1.0, 1e-12, setting={"tolerance": 1e-13}, note=OWN
    ),  # 5e-14
    AgreementCase(RIGID_DOP853, TURN, 1.0, 1e-13, setting=TIGHT, note=OWN),  # 4e-15
    AgreementCase(RIGID_ODE45, TURN, 1.0, 2e-8, setting={"tolerance": 1e-9}, note=OWN),  # 2e-9
)
TEXTBOOK = (
    AgreementCase(STORMER_VERLET, ORBIT, 1.0, 1e-6, setting={"step": 1e-3}, note=OF_SECOND),  # 5e-7
    AgreementCase(FOREST_RUTH, ORBIT, 1.0, 1e-11, setting={"step": 1e-3}, note=OWN),  # 2e-12
    AgreementCase(RK4, ORBIT, 1.0, 1e-12, setting={"step": 1e-3}, note=OWN),  # 1e-13
    AgreementCase(EXPLICIT_EULER, ORBIT, 1.0, 5e-3, setting={"step": 1e-3}, note=OF_FIRST),  # 2e-3
    AgreementCase(IMPLICIT_EULER, ORBIT, 1.0, 5e-3, setting={"step": 1e-3}, note=OF_FIRST),  # 2e-3
    AgreementCase(
        SYMPLECTIC_EULER, ORBIT, 1.0, 5e-3, setting={"step": 1e-3}, note=OF_FIRST
    ),  # 1e-3
    AgreementCase(
        SEMI_IMPLICIT_EULER, ORBIT, 1.0, 5e-3, setting={"step": 1e-3}, note=OF_FIRST
    ),  # 1e-3
    AgreementCase(MATRIX_EULER, TURN, 1.0, 1e-2, setting={"step": 1e-3}, note=OF_FIRST),  # 4e-3
    AgreementCase(QUATERNION_RK4, TURN, 1.0, 1e-12, setting={"step": 1e-3}, note=OWN),  # 8e-14
    AgreementCase(
        QUATERNION_DOP853, TURN, 1.0, 1e-13, setting={"tolerance": 1e-14}, note=OWN
    ),  # 6e-15
)
TREES = (AgreementCase(PINOCCHIO_ACCELERATIONS, ARM, 0.5, 1e-12, note=OWN),)  # 1e-14
SKY = (AgreementCase(JPL_EPHEMERIS, PLANETS, 100.0, 1e-6, 50, note=POINTS),)  # 1e-7

AGREEMENTS: tuple[Claim, ...] = (
    agreement("A1", "galvi and the closed forms", CLOSED),
    agreement("A2", "galvi and the stored truths in quadruple precision", STORED),
    agreement("A3", "galvi and REBOUND", REBOUND),
    agreement("A4", "galvi and MuJoCo", MUJOCO),
    agreement("A5", "galvi and heyoka", HEYOKAS),
    agreement("A6", "galvi and SciPy", SCIPY),
    agreement("A7", "galvi and the textbook's methods", TEXTBOOK),
    agreement("A8", "galvi and JPL's ephemeris", SKY),
    agreement("A9", "References of the claims, each against a second one", TRUTHS),
    agreement("A10", "galvi and Pinocchio", TREES),
)
CASES = (*CLOSED, *STORED, *REBOUND, *MUJOCO, *HEYOKAS, *SCIPY, *TEXTBOOK, *SKY, *TREES)
# The optional engines, for `verify --require`, by the name of their package.
ENGINES: Mapping[str, Contender] = {
    "rebound": IAS15,
    "mujoco": MUJOCO_RK4,
    "heyoka": HEYOKA,
    "jplephem": JPL_EPHEMERIS,
    "pinocchio": PINOCCHIO_ACCELERATIONS,
}


def engines() -> dict[str, str]:
    """Optional engines: name -> why it cannot be used here, or ""."""
    return {name: contender.missing for name, contender in ENGINES.items()}
