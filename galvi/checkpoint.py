"""The complete state of a run between two steps."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from galvi.arrays import Array, read_only

NOTHING = read_only(np.zeros(0))


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """The state of a run after ``first`` steps from the problem's start, and its settings.

    Attributes
    ----------
    first
        number of completed steps; times are t0 + k h in every part of a continued run
    state : array, shape (4, d)
        q, its low part, v, its low part; on a group see galvi.kernels.on_group.advance, in a moving
        frame (8, m), see galvi.lanes.frames.collocation
    stages : array, shape (d, s)
        accelerations, on a group velocities, at the last step's stages, from which the next step is
        predicted
    solver_state
        integers of the solver, see galvi.kernels.nystrom.advance and .on_group.advance,
        galvi.lanes.nbody, TERMS_KEPT of galvi.lanes.loops
    solver
        "auto", "fixed_point" or "newton"
    tolerance
        relative change at which a step's iteration stops
    save_every
        k keeps the states after 0, k, 2 k, ... steps and the last
    curves
        whether curves are kept; None: only when save_every is 1
    energies : array, shape (4,)
        energies of the completed steps, see galvi.kernels.energy_errors; empty before the first
    passage : array, shape (5,)
        worst passage in the completed steps, see galvi.kernels.forces.passages; empty before the
        first
    clock : array, shape (4,)
        with a clock, the time, its low part, the energy and its low part; empty otherwise. For
        point masses in lanes the energy is that in the frame of their centre of mass, times G. In a
        checkpoint without a state it prescribes the energy of the clock
    """

    first: int
    state: Array
    stages: Array
    solver_state: npt.NDArray[np.int64]
    solver: str
    tolerance: float
    save_every: int = 1
    curves: bool | None = None
    energies: Array = field(default_factory=lambda: NOTHING)
    passage: Array = field(default_factory=lambda: NOTHING)
    clock: Array = field(default_factory=lambda: NOTHING)

    @property
    def keeps_curves(self) -> bool:
        """Whether curves are kept."""
        return self.save_every == 1 if self.curves is None else self.curves
