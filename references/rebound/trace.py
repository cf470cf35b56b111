"""REBOUND's TRACE: a time-reversible Wisdom-Holman method that switches in close encounters.

Lu, Hernandez and Rein (2024). Meant for one dominant mass. Options: r_crit_hill, peri_crit_eta,
peri_mode ("PARTIAL_BS", "FULL_BS" or "FULL_IAS15"), as in REBOUND.
"""

from references.rebound.fixed_steps import ReboundSteps

TRACE = ReboundSteps(
    "REBOUND TRACE",
    integrator="trace",
    options=("r_crit_hill", "peri_crit_eta", "peri_mode"),
    order=2,
)
