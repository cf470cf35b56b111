"""All figures drawn from claims, in the order of the papers' chapters."""

from __future__ import annotations

from reports.figures.catalogue.brownout import BROWNOUT_FIGURES
from reports.figures.catalogue.lie_groups import LIE_GROUPS
from reports.figures.catalogue.oscillator_and_planets import OSCILLATOR_AND_PLANETS
from reports.figures.catalogue.vector_spaces import VECTOR_SPACES
from reports.results.section import Figure

FIGURES: tuple[Figure, ...] = (
    *OSCILLATOR_AND_PLANETS,
    *LIE_GROUPS,
    *BROWNOUT_FIGURES,
    *VECTOR_SPACES,
)
