"""REBOUND's EOS: embedded operator splitting (Rein 2019), for systems without a dominant mass too.

Options: phi0, phi1, n and safe_mode, as in REBOUND.
"""

from __future__ import annotations

from references.rebound.fixed_steps import ReboundSteps

EOS = ReboundSteps(
    "REBOUND EOS", integrator="eos", options=("phi0", "phi1", "n", "safe_mode"), order=2
)
