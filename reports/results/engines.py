"""Availability of the engines; a missing engine is reported, and is a failure if required."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Engines:
    """Every optional engine.

    absence   name -> why it cannot be used here; empty when it can
    required  names of engines that must be available
    """

    absence: Mapping[str, str] = field(default_factory=dict)
    required: tuple[str, ...] = ()

    @property
    def wanting(self) -> tuple[str, ...]:
        """The required engines that are missing."""
        return tuple(name for name in self.required if self.absence[name])

    def sentences(self) -> list[str]:
        """One sentence for each missing engine."""
        return [
            f"{name} is absent{', and was required' if name in self.required else ''}: {why}"
            for name, why in self.absence.items()
            if why
        ]
