"""One line of a convergence figure: its errors, the fit of its rate, and the claimed rate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from benchmarks.statistics import convergence_fits
from benchmarks.statistics.convergence_fits import Fit
from benchmarks.store.frames import pick


@dataclass(frozen=True)
class Rate:
    """A series of errors under refinement.

    study, quantity  which rows of the claim's frame
    label            text beside the line
    floor            level of round-off, as the claim states it
    claimed          base of n or power of h; None where the paper gives no number
    n                the n whose h-refinement this is; None for an n-refinement
    start            first n of the fit, where the claim concerns large n only
    until            largest h of the fit, where the claim concerns small h only
    algebraic        of an n-refinement: errors fall like a power of the degree N = n - 1
    power            exponent of a known factor n^-power, and its error
    """

    study: str
    quantity: str
    label: str
    floor: float
    claimed: float | None = None
    n: int | None = None
    start: int = 0
    until: float = np.inf
    algebraic: bool = False
    power: tuple[float, float] = (0.0, 0.0)

    def measured(self, frame: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
        """(n, h or 1 / N, error), coarse to fine; runs that failed have the error NaN."""
        rows = pick(frame, study=self.study, quantity=self.quantity)
        if self.n is None:
            rows = rows.sort_values("n")
            n, error = rows["n"].to_numpy(float), rows["value"].to_numpy(float)
            return (1.0 / (n - 1.0) if self.algebraic else n), error
        rows = pick(rows, n=self.n).sort_values("step", ascending=False)
        return rows["step"].to_numpy(float), rows["value"].to_numpy(float)

    def fit(self, frame: pd.DataFrame) -> Fit:
        """The fit that the claim's verdict rests on."""
        x, error = self.measured(frame)
        if self.n is None and not self.algebraic:
            late = x >= self.start
            return convergence_fits.geometric(
                x[late], error[late], floor=self.floor, power=self.power
            )
        used = x <= self.until
        return convergence_fits.algebraic(x[used], error[used], floor=self.floor)


def inside(fit: Fit, x: np.ndarray) -> np.ndarray:
    """Mask of the n or h inside the window of a fit; all False when there is no window."""
    low, high = min(fit.window), max(fit.window)
    return (x >= low * (1 - 1e-9)) & (x <= high * (1 + 1e-9))
