"""The spatial momentum R mu of a rotating body, from step to step.

It changes by torques alone, so that rounding errors of mu are not carried from step to step.
"""

from __future__ import annotations

from galvi.kernels.compile.jit import jit_inline
from galvi.kernels.nystrom.step import two_sum


@jit_inline
def turn_momentum(kick, R, R1, state, mu1):
    """Add R kick to the spatial momentum, state[1, 6:9] with low parts state[3, 4:7]; mu1 from it.

    kick   (3,)  impulse in the frame of the step's start
    R, R1  (9,)  attitudes at the step's start and end, by rows
    """
    for i in range(3):
        push = R[3 * i] * kick[0] + R[3 * i + 1] * kick[1] + R[3 * i + 2] * kick[2]
        state[1, 6 + i], state[3, 4 + i] = two_sum(state[1, 6 + i], state[3, 4 + i] + push)
    for i in range(3):
        mu1[i] = R1[i] * state[1, 6] + R1[3 + i] * state[1, 7] + R1[6 + i] * state[1, 8]
