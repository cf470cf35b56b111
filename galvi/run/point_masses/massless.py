"""What single steps say of bodies without mass, which the energy of the whole does not see.

At some states of a run the last step is done again backwards, and in two halves. The difference
gives a body the energy v . dv + G M / r^2 dr, here relative to v^2 / 2 + G M / r, where M attracts
it most: an estimate of what a step does to it. Other steps may err more, and errors of many steps
may cancel, as they do for a symplectic method.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

STATES = 6  # that are looked at in a long run, the last one and others before it
EACH = 32768  # steps of a run for each further state, which takes 1 % of their time
COARSE = 1e-3  # a step that resolves a body's motion changes less of its energy


class MasslessError(NamedTuple):
    """The body without mass whose energy a step changes by most, at one of some states.

    body    its index
    share   that change, relative
    states  how many were looked at; at others the step could not be done again
    """

    body: int
    share: float
    states: int


@np.errstate(all="ignore")
def massless_error(
    steps_from: Callable[[Checkpoint, int], Trajectory], states: Sequence[Checkpoint]
) -> MasslessError | None:
    """The estimate for a run to the last of some states, the first of which is its start; or None.

    steps_from  (a state, n) does n steps backwards, of 1 / n of the run's step
    """
    wanted = min(STATES, 1 + (states[-1].first - states[0].first) // EACH)
    chosen = np.linspace(len(states) - 1, 0, wanted + 1).round().astype(int)[:-1]
    looked_at = [states[k] for k in dict.fromkeys(chosen.tolist())]
    pairs = [[steps_from(state, n) for n in (1, 2)] for state in looked_at]
    errors = [_energy_change(one, two) for one, two in pairs if one.success and two.success]
    if not errors:
        return None
    share = np.max(errors, axis=0)
    body = int(np.argmax(share))
    return MasslessError(body, float(share[body]), len(errors))


def _energy_change(one: Trajectory, two: Trajectory) -> Array:
    """The difference of the ends of two runs for each body; 0 for bodies with a mass."""
    system = one.problem.system
    assert isinstance(system, NBody)
    q, v = two.q[-1], two.v[-1]
    light = np.flatnonzero(system.masses == 0.0)
    pull, depth, speed = (np.zeros(light.size) for _ in range(3))
    for body in np.flatnonzero(system.masses):  # one by one: there may be many of both
        r = np.linalg.norm(q[light] - q[body], axis=1)
        mu = system.G * system.masses[body]
        nearer = mu / r**2 > pull
        for known, found in (
            (pull, mu / r**2), (depth, mu / r), (speed, np.linalg.norm(v[light] - v[body], axis=1)),
        ):  # fmt: skip
            known[nearer] = found[nearer]
    dq, dv = (
        np.linalg.norm(x[-1, light] - y, axis=1) for x, y in ((one.q, q[light]), (one.v, v[light]))
    )
    change = np.zeros(len(q))
    change[light] = (speed * dv + pull * dq) / (0.5 * speed**2 + depth)
    return np.nan_to_num(change)
