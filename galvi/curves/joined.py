"""The curves of a run that actions changed: one after another, each with steps of its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array


@dataclass(frozen=True, eq=False)
class JoinedCurves:
    """Curves of a run's parts, as `galvi.curves.curves.Curves` or another kind.

    times  (parts + 1,) from which, and until which, each is the run's
    parts  the curves; that of the last step of one may go on beyond its time
    """

    times: Array
    parts: tuple[Any, ...]

    def position(self, t: Any) -> Array:
        """q at t: its shape for a scalar t, (k, ...) for (k,). ValueError outside the run."""
        return self._each(t, "position")

    def velocity(self, t: Any) -> Array:
        """dq/dt at t, on a group the body velocity; at an action that after it."""
        return self._each(t, "velocity")

    def _each(self, t: Any, name: str) -> Array:
        times = input_checks.array("t", t)
        if times.ndim > 1:
            raise ValueError(f"t must be a scalar or of shape (k,); received shape {times.shape}.")
        sign = 1.0 if self.times[-1] > self.times[0] else -1.0
        grid, wanted = sign * self.times, np.atleast_1d(times)
        if not np.all((sign * wanted >= grid[0]) & (sign * wanted <= grid[-1])):
            raise ValueError(
                f"t must lie inside the run, from {float(self.times[0])!r} to "
                f"{float(self.times[-1])!r}; received {input_checks.shown(t)}."
            )
        index = np.searchsorted(grid, sign * wanted, side="right") - 1
        index = np.minimum(index, len(self.parts) - 1)
        order = np.argsort(index, kind="stable")
        cuts = np.flatnonzero(np.diff(index[order])) + 1
        found = [
            getattr(self.parts[index[rows[0]]], name)(wanted[rows])
            for rows in np.split(order, cuts)
            if rows.size
        ]
        values: Array = np.concatenate(found)[np.argsort(order)] if found else np.zeros(0)
        return values[0] if times.ndim == 0 else values
