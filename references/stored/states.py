"""Reference solutions stored with the package, rounded to double; reading them needs no heyoka."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from galvi import Problem, Trajectory
from galvi.arrays import Array, read_only
from references.as_trajectory import as_trajectory
from references.contender import Contender, times_of_run
from references.heyoka.engine import engine_name
from references.setting import described
from references.stored.planets import FOLDER, LOOSER_TOLERANCE, TOLERANCE

SAVE_INTERVAL = 0.5  # units of time between stored states
Identity = dict[str, list[float]]


@dataclass(frozen=True, eq=False)
class FileContents:
    """The contents of a file: the identity of its problem, times since the start (saved,), q and p
    (saved, ...)."""

    identity: Identity
    t: Array
    q: Array
    p: Array


@dataclass(frozen=True, eq=False)
class StoredStates:
    """Stored states of a few problems, which are recognised bit for bit except for t0.

    Attributes
    ----------
    module
        name of the module that writes the files, with ``python -m``
    makers
        case -> function that makes its problem, and the horizon in its unit of time
    engine
        heyoka in quadruple precision
    knows
        problem -> whether it has an identity
    identity
        problem -> the numbers that identify it, to the last bit
    columns
        titles of the entries of q and p

    Notes
    -----
    Setting: samples. Duration and samples must fall on stored times, every half unit. Accurate to
    the rounding of the states.
    """

    fixed_step: ClassVar[bool] = False

    name: str
    module: str
    makers: Mapping[str, tuple[Callable[[], Problem], float]]
    engine: Contender
    knows: Callable[[Problem], bool]
    identity: Callable[[Problem], Identity]
    columns: Callable[[Problem], Sequence[str]]
    exact: bool = True
    missing: str = ""

    @cached_property
    def cases(self) -> Mapping[str, tuple[Problem, float]]:
        """Case -> its problem and horizon."""
        return {case: (make(), horizon) for case, (make, horizon) in self.makers.items()}

    @cached_property
    def files(self) -> Mapping[str, FileContents]:
        """Case -> its file's contents."""
        return {case: self._read(case) for case in self.cases}

    def supports(self, problem: Problem) -> bool:
        """A problem whose identity equals a stored one bit for bit."""
        return self._of(problem) is not None

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Look up; see `Contender`. ValueError for times that are not stored."""
        times = times_of_run(self, problem, duration, setting)
        contents = self._of(problem)
        assert contents is not None
        since = times - problem.t0
        rows = np.argmin(np.abs(since[:, None] - contents.t), axis=1)
        not_stored = since != contents.t[rows]
        if np.any(not_stored):
            raise ValueError(
                f"the truth is stored every {SAVE_INTERVAL:g} up to {contents.t[-1]:g} after "
                f"the start; received a sample at {since[not_stored][0]:g}. Choose a duration and "
                "samples among these."
            )
        method = described(self.name, setting, f"heyoka, real128, tolerance {TOLERANCE}")
        return as_trajectory(
            problem, method, times, contents.q[rows], p=contents.p[rows], counts={"steps": 0}
        )

    def table(self, case: str) -> str:
        """The text of one file; raises ModuleNotFoundError without heyoka's real128."""
        problem, horizon = self.cases[case]
        samples = round(horizon / SAVE_INTERVAL)
        runs = [
            self.engine.run(problem, horizon, {"samples": samples, "tolerance": tolerance})
            for tolerance in (TOLERANCE, LOOSER_TOLERANCE)
        ]
        entries, looser_entries = (
            np.concatenate([run.q.reshape(samples + 1, -1), run.p], axis=1) for run in runs
        )
        lines = [
            f"# {problem.name}, the truth",
            f"# source: {engine_name('real128')}, tolerance {TOLERANCE}, high_accuracy",
            f"# accuracy: rounded to double; with {LOOSER_TOLERANCE} instead, "
            f"{np.count_nonzero(entries != looser_entries)} of {entries.size} numbers differ",
            f"# made by: python -m {self.module} {case}",
            f"# units: {problem.units}; t since the start",
            *(f"# {key}: " + " ".join(map(repr, x)) for key, x in self.identity(problem).items()),
            ",".join(["t", *self.columns(problem)]),
        ]
        for t, row in zip((runs[0].t - problem.t0).tolist(), entries.tolist(), strict=True):
            lines.append(",".join(map(repr, [t, *row])))
        return "\n".join(lines) + "\n"

    def write(self, cases: Sequence[str]) -> None:
        """Write the files of these cases, or without any those of all cases."""
        for case in cases or self.cases:
            (FOLDER / f"{case}.csv").write_text(self.table(case), encoding="ascii")
            print(f"wrote references/stored/data/{case}.csv")

    def _of(self, problem: Problem) -> FileContents | None:
        if not self.knows(problem):
            return None
        identity = self.identity(problem)
        return next(
            (contents for contents in self.files.values() if contents.identity == identity), None
        )

    def _read(self, case: str) -> FileContents:
        problem, _ = self.cases[case]
        lines = (FOLDER / f"{case}.csv").read_text("ascii").splitlines()
        header = dict(line[2:].split(": ", 1) for line in lines if line[0] == "#" and ": " in line)
        identity = {
            name: [float(x) for x in header[name].split()] for name in self.identity(problem)
        }
        rows = np.array([[float(x) for x in ln.split(",")] for ln in lines if ln[0].isdigit()])
        t, q, p = np.split(rows, [1, 1 + problem.q0.size], axis=1)
        q = q.reshape(-1, *problem.q0.shape)
        return FileContents(identity, *map(read_only, (t[:, 0], q, p)))
