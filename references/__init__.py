"""Other ways to solve the same problem: closed forms, textbook methods and trusted engines."""

from __future__ import annotations

from references.contender import Contender
from references.euler import EXPLICIT_EULER, SYMPLECTIC_EULER
from references.ias15 import IAS15
from references.implicit_euler import IMPLICIT_EULER
from references.kepler import KEPLER
from references.oscillator import OSCILLATOR
from references.scipy_ivp import DOP853, ODE45
from references.setting import nearest
from references.stormer_verlet import STORMER_VERLET
from references.whfast import WHFAST

REFERENCES: tuple[Contender, ...] = (
    OSCILLATOR,
    KEPLER,
    EXPLICIT_EULER,
    IMPLICIT_EULER,
    SYMPLECTIC_EULER,
    STORMER_VERLET,
    ODE45,
    DOP853,
    IAS15,
    WHFAST,
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
