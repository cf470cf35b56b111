"""Which reference galvi is held against, on what, and how near they must be; every one of them.

Beside each limit stands what was measured when it was set.
"""

from __future__ import annotations

from collections.abc import Mapping

import galvi
from benchmarks.agreement import Meeting, agreement
from benchmarks.claim import Claim
from references import bulirsch_stoer, heyoka_taylor, leapfrog, saba, whfast, whfast512
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
from references.scipy_ivp import DOP853, ODE45, RADAU, TIGHT
from references.semi_implicit_euler import SEMI_IMPLICIT_EULER
from references.stored_attitude import STORED_ATTITUDE
from references.stored_chain import STORED_CHAIN
from references.stormer_verlet import STORMER_VERLET
from references.truth import STORED_TRUTH
from references.whfast import WHFAST
from references.whfast512 import WHFAST512

SPRING, ORBIT = galvi.problems.harmonic_oscillator(), galvi.problems.kepler(0.3)
SWING, TURN = galvi.problems.planar_pendulum(), galvi.problems.free_rigid_body()
HANGING, PLANETS = galvi.problems.pendulum_3d(), galvi.problems.solar_system()
CHAIN = galvi.problems.double_pendulum()
PAIR = galvi.Problem(
    galvi.NBody([1e-3, 0.9], G=1.2),
    [[1.0, 0.2, 0.0], [0.0, 0.1, 0.0]],
    [[0.0, 0.9, 0.1], [0.0, 0.0, 0.0]],
    name="two bodies, the light one first",
)
OF_SECOND, OF_FIRST = "Its error of second order in its step.", "Its error of first order."
OWN = "Its own error at this setting."

CLOSED = (
    Meeting(OSCILLATOR, SPRING, 1.0, 2e-15),  # 1e-16
    Meeting(KEPLER, ORBIT, 1.0, 2e-15),  # 1e-16
    Meeting(PENDULUM, SWING, 1.0, 2e-15),  # 0
    Meeting(FREE_TOP, TURN, 1.0, 4e-15),  # 3e-16
)
STORED = (
    Meeting(STORED_TRUTH, PLANETS, 1000.0, 2e-13, 500,
            note="Rounding over 500 steps of two days."),  # 1e-14
    Meeting(STORED_CHAIN, CHAIN, 1.0, 1e-14),  # 5e-16
    Meeting(STORED_ATTITUDE, HANGING, 1.0, 2e-15),  # 6e-17
)  # fmt: skip
REBOUND = (
    Meeting(IAS15, PAIR, 1.0, 2e-15),  # 1e-16
    Meeting(BULIRSCH_STOER, PAIR, 1.0, 1e-13, setting=bulirsch_stoer.BEST, note=OWN),  # 2e-15
    Meeting(WHFAST, PAIR, 1.0, 1e-13, setting={"step": 0.1, **whfast.BEST}),  # 1e-15
    Meeting(WHFAST512, PAIR, 1.0, 1e-13, setting={"step": 0.1, **whfast512.BEST}),  # 5e-15
    Meeting(SABA, PAIR, 1.0, 1e-13, setting={"step": 0.1, **saba.BEST}),  # 2e-16
    Meeting(LEAPFROG, PAIR, 1.0, 1e-13, setting={"step": 0.005, **leapfrog.BEST}),  # 1e-15
    Meeting(JANUS, PAIR, 1.0, 1e-12, setting={"step": 0.005, "order": 8}, note=OWN),  # 4e-14
)
MUJOCO = (
    Meeting(MUJOCO_RK4, TURN, 1.0, 1e-12, setting={"step": 1e-3}, note=OWN),  # 5e-14
    Meeting(MUJOCO_EULER, TURN, 1.0, 1e-3, setting={"step": 1e-3}, note=OF_FIRST),  # 3e-4
    Meeting(MUJOCO_IMPLICIT, TURN, 1.0, 1e-3, setting={"step": 1e-3}, note=OF_FIRST),  # 4e-4
    Meeting(MUJOCO_IMPLICITFAST, TURN, 1.0, 1e-3, setting={"step": 1e-3}, note=OF_FIRST),  # 3e-4
    Meeting(MUJOCO_DISCRETE, TURN, 1.0, 1e-3, setting={"step": 1e-3}, note=OF_FIRST),  # 3e-4
)
HEYOKAS = (
    Meeting(
        HEYOKA, PAIR, 1.0, 2e-15, setting={**heyoka_taylor.BEST, "compact_mode": True}
    ),  # 1e-16
    Meeting(HEYOKA_QUADRUPLE, ORBIT, 1.0, 2e-15),  # 1e-16
    Meeting(HEYOKA_CHAIN, CHAIN, 1.0, 1e-14),  # 5e-16
    Meeting(HEYOKA_CHAIN_QUADRUPLE, CHAIN, 1.0, 1e-14),  # 5e-16
    Meeting(HEYOKA_RIGID, TURN, 1.0, 2e-15),  # 2e-16
    Meeting(HEYOKA_RIGID_QUADRUPLE, HANGING, 1.0, 2e-15),  # 6e-17
)
SCIPY = (
    Meeting(DOP853, ORBIT, 1.0, 2e-13, setting=TIGHT, note=OWN),  # 2e-14
    Meeting(ODE45, ORBIT, 1.0, 2e-8, setting={"tolerance": 1e-9}, note=OWN),  # 4e-9
    Meeting(RADAU, ORBIT, 1.0, 1e-11, setting={"tolerance": 1e-9}, note=OWN),  # 1e-12
    Meeting(CHAIN_DOP853, CHAIN, 1.0, 1e-12, setting={"tolerance": 1e-13}, note=OWN),  # 5e-14
    Meeting(RIGID_DOP853, TURN, 1.0, 1e-13, setting=TIGHT, note=OWN),  # 4e-15
    Meeting(RIGID_ODE45, TURN, 1.0, 2e-8, setting={"tolerance": 1e-9}, note=OWN),  # 2e-9
)
TEXTBOOK = (
    Meeting(STORMER_VERLET, ORBIT, 1.0, 1e-6, setting={"step": 1e-3}, note=OF_SECOND),  # 5e-7
    Meeting(EXPLICIT_EULER, ORBIT, 1.0, 5e-3, setting={"step": 1e-3}, note=OF_FIRST),  # 2e-3
    Meeting(IMPLICIT_EULER, ORBIT, 1.0, 5e-3, setting={"step": 1e-3}, note=OF_FIRST),  # 2e-3
    Meeting(SYMPLECTIC_EULER, ORBIT, 1.0, 5e-3, setting={"step": 1e-3}, note=OF_FIRST),  # 1e-3
    Meeting(SEMI_IMPLICIT_EULER, ORBIT, 1.0, 5e-3, setting={"step": 1e-3}, note=OF_FIRST),  # 1e-3
    Meeting(MATRIX_EULER, TURN, 1.0, 1e-2, setting={"step": 1e-3}, note=OF_FIRST),  # 4e-3
    Meeting(QUATERNION_RK4, TURN, 1.0, 1e-12, setting={"step": 1e-3}, note=OWN),  # 8e-14
    Meeting(QUATERNION_DOP853, TURN, 1.0, 1e-13, setting={"tolerance": 1e-14}, note=OWN),  # 6e-15
)
SKY = (
    Meeting(JPL_EPHEMERIS, PLANETS, 100.0, 1e-6, 50,
            note="Point masses without relativity, Moon and asteroids."),  # 1e-7
)  # fmt: skip

AGREEMENTS: tuple[Claim, ...] = (
    agreement("A1", "galvi and the closed forms", CLOSED),
    agreement("A2", "galvi and the stored truths in quadruple precision", STORED),
    agreement("A3", "galvi and REBOUND", REBOUND),
    agreement("A4", "galvi and MuJoCo", MUJOCO),
    agreement("A5", "galvi and heyoka", HEYOKAS),
    agreement("A6", "galvi and SciPy", SCIPY),
    agreement("A7", "galvi and the textbook's methods", TEXTBOOK),
    agreement("A8", "galvi and JPL's ephemeris", SKY),
)
MEETINGS = (*CLOSED, *STORED, *REBOUND, *MUJOCO, *HEYOKAS, *SCIPY, *TEXTBOOK, *SKY)
# What `verify --require` knows: the engines that may be absent, by the name of what is installed.
ENGINES: Mapping[str, Contender] = {
    "rebound": IAS15,
    "mujoco": MUJOCO_RK4,
    "heyoka": HEYOKA,
    "jplephem": JPL_EPHEMERIS,
}


def engines() -> dict[str, str]:
    """Each engine with why it cannot be used here, or nothing."""
    return {name: contender.missing for name, contender in ENGINES.items()}


def unavailable() -> tuple[str, ...]:
    """What contenders say whose engine is absent."""
    said = (meeting.contender.missing for meeting in MEETINGS)
    return tuple(dict.fromkeys(sentence for sentence in said if sentence))
