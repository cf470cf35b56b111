"""Two methods of fourth order for q'' = a(q, t): Kutta's and Forest and Ruth's."""

from references.textbook.nystrom import Nystrom, splitting

# The classical Runge-Kutta method on (q, v)' = (v, a) (Hairer, Norsett and Wanner, Solving ODEs I,
# II.1, table 1.2).
RK4 = Nystrom(
    "RK4",
    order=4,
    stages=((0.0,) * 4, (0.0,) * 4, (0.25, 0.0, 0.0, 0.0), (0.0, 0.5, 0.0, 0.0)),
    nodes=(0.0, 0.5, 0.5, 1.0),
    position=(1 / 6, 1 / 6, 1 / 6, 0.0),
    velocity=(1 / 6, 1 / 3, 1 / 3, 1 / 6),
)

# Leapfrog, from drift to drift, in steps of theta, 1 - 2 theta and theta (Forest and Ruth,
# Physica D 43 (1990) 105).
THETA = 1.0 / (2.0 - 2.0 ** (1 / 3))
FOREST_RUTH = splitting(
    "Forest-Ruth",
    order=4,
    nodes=(0.5 * THETA, 0.5, 1.0 - 0.5 * THETA),
    kicks=(THETA, 1.0 - 2.0 * THETA, THETA),
)
