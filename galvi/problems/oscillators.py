"""Oscillators: harmonic, Hénon and Heiles's, and the chain of Fermi, Pasta, Ulam and Tsingou."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.input_checks import shown
from galvi.kernels.compile.jit import jit
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.potentials.potentials import LinearSpring, SpringChain


def harmonic_oscillator() -> Problem:
    """L = (v^2 - q^2) / 2 from q = 1, v = 0 (H 2.4.1, M 6.1). No units."""
    return Problem(
        system=Canonical(mass=1.0, potential=LinearSpring(1.0)),
        q0=np.array([1.0]),
        v0=np.array([0.0]),
        name="harmonic oscillator",
        units="none (m = k = 1)",
    )


@jit
def _star_potential(q: Any) -> Any:
    """V = (x^2 + y^2) / 2 + x^2 y - y^3 / 3."""
    return 0.5 * (q[0] ** 2 + q[1] ** 2) + q[0] ** 2 * q[1] - q[1] ** 3 / 3.0


@jit
def _star_gradient(q: Any) -> Any:
    """dV/dq, (2,)."""
    return np.array([q[0] + 2.0 * q[0] * q[1], q[1] + q[0] ** 2 - q[1] ** 2])


@jit
def _star_hessian(q: Any) -> Any:
    """d2V/dq2, (2, 2)."""
    return np.array([[1.0 + 2.0 * q[1], 2.0 * q[0]], [2.0 * q[0], 1.0 - 2.0 * q[1]]])


def henon_heiles(energy: float = 0.1) -> Problem:
    """A star in an axisymmetric galaxy, from q = (0, 0.1) with v = (v_x, 0.05) at this energy.

    The motion is bounded below the escape energy 1/6. Raises ValueError for an energy below that of
    the position or at least 1/6.
    """
    energy = input_checks.real("energy", energy)
    q0 = np.array([0.0, 0.1])
    resting = float(_star_potential(q0)) + 0.5 * 0.05**2
    if not resting <= energy < 1.0 / 6.0:
        raise ValueError(
            f"energy must be in [{resting:.6g}, 1/6), so that the start exists and the motion is "
            f"bounded; received {shown(energy)}."
        )
    return Problem(
        system=Canonical(1.0, _star_potential, _star_gradient, _star_hessian),
        q0=q0,
        v0=np.array([math.sqrt(2.0 * (energy - resting)), 0.05]),
        name="henon-heiles",
        parameters={"energy": energy},
        units="none",
    )


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
