"""Semi-implicit symplectic Euler, order 1, with forces that depend on the velocity (M 6.2).

v' = v + h a(q, v, t),   q' = q + h v'

M's reference of low order. It is symplectic Euler of `references.textbook.euler`, under M's name.
"""

from __future__ import annotations

from dataclasses import replace

from references.textbook.euler import SYMPLECTIC_EULER

SEMI_IMPLICIT_EULER = replace(SYMPLECTIC_EULER, name="semi-implicit Euler")
