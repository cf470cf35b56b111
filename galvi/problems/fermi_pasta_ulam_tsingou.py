"""The chain of Fermi, Pasta, Ulam and Tsingou."""

from __future__ import annotations

import numpy as np

from galvi import input_checks
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.potentials.spring_chain import SpringChain


def fermi_pasta_ulam_tsingou(masses: int = 15, alpha: float = 0.25, beta: float = 0.0) -> Problem:
    """``masses`` unit masses between walls, released at rest in the lowest mode, amplitude 1.

    Fermi, Pasta and Ulam, Los Alamos report LA-1940 (1955). Raises ValueError for no masses.
    """
    masses = input_checks.whole("masses", masses)
    place = np.arange(1, masses + 1) / (masses + 1)
    return Problem(
        system=Canonical(mass=1.0, potential=SpringChain(alpha, beta)),
        q0=np.sin(np.pi * place),
        v0=np.zeros(masses),
        name="fermi-pasta-ulam-tsingou",
        parameters={"masses": masses, "alpha": alpha, "beta": beta},
        units="none (masses and linear stiffness 1)",
    )
