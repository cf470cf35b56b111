"""REBOUND compiled for this processor, beside the wheel: `make native` builds it from its source.

A process has one module `rebound`. The native build is imported from its own folder and replaces
that module during a run.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

from galvi import Problem, Trajectory
from references.contender import Contender
from references.rebound import simulation as rebound_simulation

FOLDER = Path(sys.prefix) / "native"
BUILT = "built from its source with -O3 -march=native"


def missing() -> str:
    """One sentence saying why this build cannot be used here; empty when it can."""
    if why := rebound_simulation.missing():
        return why
    if not (FOLDER / "rebound").is_dir():
        return "REBOUND is not built for this processor: make native."
    wheel = rebound_simulation.version()
    with native():
        built = rebound_simulation.version()
    if built == wheel:
        return ""
    return f"{built} is built for this processor, beside {wheel}. Build it again: make native."


@contextmanager
def native() -> Iterator[None]:
    """Inside the block ``import rebound`` imports the native build."""
    before = _remove_modules()
    try:
        sys.modules.update(_modules(FOLDER))
        yield
    finally:
        _remove_modules()
        sys.modules.update(before)


@cache
def _modules(folder: Path) -> Mapping[str, ModuleType]:
    """The modules of the build in this folder."""
    sys.path.insert(0, str(folder))
    importlib.invalidate_caches()
    try:
        importlib.import_module("rebound")
    finally:
        sys.path.remove(str(folder))
    return _remove_modules()


def _remove_modules() -> dict[str, ModuleType]:
    """Remove REBOUND's modules from those imported; returns them by name."""
    names = [name for name in sys.modules if name.partition(".")[0] in ("rebound", "librebound")]
    return {name: sys.modules.pop(name) for name in names}


@dataclass(frozen=True, eq=False)
class Native:
    """A contender of REBOUND's, run by this build."""

    engine: ClassVar[str] = "rebound"

    contender: Contender

    @property
    def name(self) -> str:
        """The contender's name, with a mark."""
        return f"{self.contender.name}, native"

    @property
    def exact(self) -> bool:
        """Whether the contender is exact."""
        return self.contender.exact

    @property
    def missing(self) -> str:
        """Why the native build or the contender cannot be used here; "" when they can."""
        return missing() or self.contender.missing

    def supports(self, problem: Problem) -> bool:
        """Whether the contender supports the problem."""
        return self.contender.supports(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """See `references.Contender`."""
        with native():
            return self.contender.run(problem, duration, setting)
