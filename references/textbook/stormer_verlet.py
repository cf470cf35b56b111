"""The method of Stormer and Verlet in its velocity form, order 2, symmetric and symplectic."""

from __future__ import annotations

from references.textbook.nystrom import Nystrom

STORMER_VERLET = Nystrom(
    "Stormer-Verlet",
    order=2,
    stages=((0.0, 0.0), (0.5, 0.0)),
    nodes=(0.0, 1.0),
    position=(0.5, 0.0),
    velocity=(0.5, 0.5),
)
