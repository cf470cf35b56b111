"""The effect of relativity on a planet about the Sun alone: the Schwarzschild term."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from galvi.arrays import Array

LIGHT = 299_792.458 * 86_400.0 / 149_597_870.7  # au / day
TIGHT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}


def path(gm: float, q0: Array, v0: Array, times: Array, light: float = LIGHT) -> Array:
    """Positions of a light body about a mass gm at times from 0, (times, 3); light=inf: Newton.

    q'' = -gm q / r^3 + gm / (c^2 r^3) ((4 gm / r - v^2) q + 4 (q v) v), harmonic coordinates: the
    pericentre advances by 6 pi gm / (c^2 a (1 - e^2)) per revolution.
    """

    per_light = 1.0 / light**2

    def slope(t: float, state: Array) -> Any:
        x, y, z, u, v, w = state.tolist()
        r = math.sqrt(x * x + y * y + z * z)
        pull = gm / r**3
        along = pull * per_light * (4.0 * gm / r - (u * u + v * v + w * w)) - pull
        drag = pull * per_light * 4.0 * (x * u + y * v + z * w)
        return [u, v, w, along * x + drag * u, along * y + drag * v, along * z + drag * w]

    start = np.concatenate([q0, v0])
    solved = solve_ivp(slope, (0.0, times[-1]), start, t_eval=times, **TIGHT)
    places: Array = solved.y[:3].T
    return places


def displacement(gm: float, q0: Array, v0: Array, times: Array) -> Array:
    """Distance between the relativistic and the Newtonian path from the same start, (times,)."""
    apart = path(gm, q0, v0, times) - path(gm, q0, v0, times, np.inf)
    distance: Array = np.linalg.norm(apart, axis=-1)
    return distance
