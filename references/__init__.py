"""Other ways to solve the same problem: closed forms, textbook methods and trusted engines."""

from __future__ import annotations

from references.bulirsch_stoer import BULIRSCH_STOER
from references.contender import Contender
from references.ephemeris import JPL_EPHEMERIS
from references.euler import EXPLICIT_EULER, SYMPLECTIC_EULER
from references.heyoka_taylor import HEYOKA, HEYOKA_QUADRUPLE
from references.ias15 import IAS15
from references.implicit_euler import IMPLICIT_EULER
from references.janus import JANUS
from references.kepler import KEPLER
from references.leapfrog import LEAPFROG
from references.oscillator import OSCILLATOR
from references.saba import SABA
from references.scipy_ivp import DOP853, ODE45
from references.setting import nearest
from references.stormer_verlet import STORMER_VERLET
from references.truth import STORED_TRUTH
from references.whfast import WHFAST
from references.whfast512 import WHFAST512

REFERENCES: tuple[Contender, ...] = (
    OSCILLATOR,
    KEPLER,
    STORED_TRUTH,
    JPL_EPHEMERIS,
    EXPLICIT_EULER,
    IMPLICIT_EULER,
    SYMPLECTIC_EULER,
    STORMER_VERLET,
    ODE45,
    DOP853,
    IAS15,
    BULIRSCH_STOER,
    WHFAST,
    WHFAST512,
    SABA,
    LEAPFROG,
    JANUS,
    HEYOKA,
    HEYOKA_QUADRUPLE,
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
