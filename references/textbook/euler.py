"""Explicit and symplectic Euler, order 1 (H figure 1.1)."""

from __future__ import annotations

from references.textbook.nystrom import Nystrom

EXPLICIT_EULER = Nystrom(
    "explicit Euler", order=1, stages=((0.0,),), nodes=(0.0,), position=(0.0,), velocity=(1.0,)
)
SYMPLECTIC_EULER = Nystrom(
    "symplectic Euler", order=1, stages=((0.0,),), nodes=(0.0,), position=(1.0,), velocity=(1.0,)
)
