"""REBOUND's MERCURIUS: Wisdom-Holman steps, and IAS15 during close encounters.

Rein et al. (2019). Meant for one dominant mass. Options: r_crit_hill, safe_mode, as in REBOUND.
"""

from references.rebound.fixed_steps import ReboundSteps

MERCURIUS = ReboundSteps(
    "REBOUND MERCURIUS",
    integrator="mercurius",
    options=("r_crit_hill", "safe_mode"),
    order=2,
)
