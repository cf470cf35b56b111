"""What single steps say of bodies without mass, which the energy of the whole does not see.

From some states of a run one step is compared with two of half its length. Their difference gives a
body the energy v . dv + G M / r^2 dr, here relative to G M / r, of the body M that attracts it
most: an estimate of what a step does to it. Other steps may err more, and errors of many steps may
cancel, as they do for a symplectic method.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

STATES = 6  # that are looked at in a long run, the last one and others before it
COARSE = 1e-3  # share of its energy by which a step that follows a body's motion does not change it
EACH = 32768  # steps for each further one, which takes 1 % of their time


class MasslessError(NamedTuple):
    """The body without mass whose energy a step changes by most, at one of some states.

    body    its index
    share   that change, relative
    states  how many were looked at
    """

    body: int
    share: float
    states: int


@np.errstate(all="ignore")
def massless_error(
    steps_from: Callable[[Checkpoint, int], Trajectory], states: Sequence[Checkpoint]
) -> MasslessError:
    """The estimate for a run to the last of some states.

    steps_from  (a state, n) does n steps of 1 / n of the run's step
    """
    wanted = min(STATES, 1 + (states[-1].first - states[0].first) // EACH)
    chosen = np.linspace(len(states) - 1, 0, wanted + 1).round().astype(int)[:-1]
    looked_at = [states[k] for k in dict.fromkeys(chosen.tolist())]
    errors = [
        _energy_change(*(steps_from(replace(state, save_every=1, curves=False), n) for n in (1, 2)))
        for state in looked_at
    ]
    share = np.max(errors, axis=0)
    body = int(np.argmax(share))
    return MasslessError(body, float(share[body]), len(looked_at))


def _energy_change(one: Trajectory, two: Trajectory) -> Array:
    """The difference of two runs for each body, 0 of those with a mass and where a run ended."""
    system = one.problem.system
    assert isinstance(system, NBody)
    heavy, light = system.masses > 0.0, system.masses == 0.0
    q, v = two.q[-1], two.v[-1]
    change = np.zeros(len(q))
    apart = np.linalg.norm(q[light, None] - q[None, heavy], axis=-1)
    pulls = system.G * system.masses[heavy] / apart**2
    nearest = np.argmax(pulls, axis=1)
    row = np.arange(len(nearest))
    pull, r = pulls[row, nearest], apart[row, nearest]
    speed = np.linalg.norm(v[light] - v[heavy][nearest], axis=-1)
    dq = np.linalg.norm(one.q[-1, light] - q[light], axis=-1)
    dv = np.linalg.norm(one.v[-1, light] - v[light], axis=-1)
    change[light] = (speed * dv + pull * dq) / (pull * r)
    return np.nan_to_num(change)
