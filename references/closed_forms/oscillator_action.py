"""The action of the harmonic oscillator between two points in a given time."""

from __future__ import annotations

from decimal import Decimal, localcontext

from references.closed_forms.decimal_trigonometry import DIGITS, sine_cosine


def oscillator_action(mass: float, stiffness: float, start: float, end: float, h: float) -> float:
    """Integral of m v^2/2 - k q^2/2 from q = `start` to `end` in the time h, w h below pi:
    m w ((q0^2 + q1^2) cos wh - 2 q0 q1) / (2 sin wh), w^2 = k/m (Feynman and Hibbs, problem 2-2).

    All given numbers are taken as exact; the result is rounded once.
    """
    with localcontext(DIGITS):
        m, k, q0, q1 = map(Decimal, (mass, stiffness, start, end))
        w = (k / m).sqrt()
        sine, cosine = sine_cosine(w * Decimal(h))
        return float(m * w * ((q0 * q0 + q1 * q1) * cosine - 2 * q0 * q1) / (2 * sine))
