"""Two bodies in space, the light one first, to test independence of the order of bodies."""

import galvi

PAIR = galvi.Problem(
    galvi.NBody([1e-3, 0.9], G=1.2),
    [[1.0, 0.2, 0.0], [0.0, 0.1, 0.0]],
    [[0.0, 0.9, 0.1], [0.0, 0.0, 0.0]],
    name="two bodies, the light one first",
)
