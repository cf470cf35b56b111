"""Which engines are there, and which must be: an absent one is reported, and fails if required."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Engines:
    """Every engine that may be absent.

    absence   name: why it cannot be used here; empty when it can
    required  names whose absence is a failure
    """

    absence: Mapping[str, str] = field(default_factory=dict)
    required: tuple[str, ...] = ()

    @property
    def wanting(self) -> tuple[str, ...]:
        """The required ones that are absent."""
        return tuple(name for name in self.required if self.absence[name])

    def sentences(self) -> list[str]:
        """One for each that is absent."""
        return [
            f"{name} is absent{', and was required' if name in self.required else ''}: {why}"
            for name, why in self.absence.items()
            if why
        ]
