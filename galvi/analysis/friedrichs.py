"""The constant of Friedrichs' inequality on an interval."""

from __future__ import annotations

Z0 = 0.860333589019379762
"""The smallest positive root of 1 = z tan z, 0.860: the integral of |u|^2 over a step of h is at
most (h / z0)^2 times that of |u'|^2 plus |u(h)|^2 / h, with equality for cos(z0 t / h) (M section
2)."""
