"""All figures drawn from claims, in the order of the papers' chapters."""

from __future__ import annotations

from reports.figures.catalogue.brownout import BROWNOUT_FIGURES
from reports.figures.catalogue.lie_groups import PENDULUM_FIGURES, RIGID_BODIES
from reports.figures.catalogue.oscillator_and_planets import OSCILLATOR_AND_PLANETS
from reports.figures.catalogue.vector_spaces import FINITE_SMOOTHNESS, VECTOR_FIGURES
from reports.results.section import Figure

FIGURES: tuple[Figure, ...] = (
    *OSCILLATOR_AND_PLANETS,
    *RIGID_BODIES,
    *PENDULUM_FIGURES,
    *BROWNOUT_FIGURES,
    *VECTOR_FIGURES,
    *FINITE_SMOOTHNESS,
)
