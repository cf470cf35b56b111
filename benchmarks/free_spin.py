"""What is left of energy and angular momentum when a free body turns for long.

H's free body by galvi in both charts and by each of MuJoCo's integrators, and the free box of
MuJoCo's own tests. A turn is the time that the first angular velocity takes for one. MuJoCo turns
a body otherwise on a ball joint than on a free one, by `implicitfast` and `discrete`: the long runs
are on free joints, those of the box on both.
"""

from __future__ import annotations

import datetime
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks import textbook
from benchmarks.body_arenas import CHARTS, MUJOCO, largest_entry
from benchmarks.contenders import gauss_collocation
from benchmarks.long_brouwer import version
from benchmarks.row_files import RowFiles
from galvi import Problem
from galvi.arrays import Array
from references import Contender, mujoco_engine
from references.free_top import FREE_TOP

COLUMNS: Mapping[str, type] = {
    "problem": str,
    "contender": str,
    "engine": str,
    "step": float,
    "turns": float,
    "turn": float,
    "energy_error": float,
    "momentum_error": float,
    "attitude_error": float,
    "status": str,
    "commit": str,
    "date": str,
}
TURNS, QUICK_TURNS, MANY_TURNS = 1000, 100, 100_000
FOLDER = "free_spin"  # below that of all studies
GRID = 2.0**-20  # steps are multiples of it, so that their ends are numbers of the machine
BOX_STEP, BOX_STEPS = 0.01, 500  # of MuJoCo's test
OWN_STEP = 0.01
Report = Callable[[str], None]


@dataclass(frozen=True)
class Runner:
    """One contender at one step.

    label     for tables
    step      asked for; the nearest multiple of GRID is taken, unless the problem sets it
    joint     "free" for a body that can go away, too; it does not
    """

    label: str
    contender: Contender
    step: float
    joint: str = ""

    @property
    def engine(self) -> str:
        """What moves the body: galvi, or name and version of another."""
        mujoco = self.contender in MUJOCO and not self.contender.missing
        return mujoco_engine.version() if mujoco else "galvi"


def _ours(degree: int, step: float) -> list[Runner]:
    return [
        Runner(f"galvi degree {degree}, Gauss {degree}, {name}",
               gauss_collocation(degree, chart), step)
        for name, chart in CHARTS.items()
    ]  # fmt: skip


def _mujoco(joint: str, step: float) -> list[Runner]:
    return [Runner(f"{one.name}, {joint} joint", one, step, joint) for one in MUJOCO]


RUNNERS = (*_ours(4, 0.125), *_ours(8, 0.4), *_mujoco("free", OWN_STEP))
ON_BOX = (*_ours(4, BOX_STEP), *_mujoco("free", BOX_STEP), *_mujoco("ball", BOX_STEP))


def free_spin(
    quick: bool = False,
    report: Report = lambda sentence: None,
    runners: Sequence[Runner] = RUNNERS,
    on_box: Sequence[Runner] = ON_BOX,
) -> pd.DataFrame:
    """Rows of each contender at some of its turns; see COLUMNS.

    engine          galvi, or name and version of another
    turns           length of the run; of it, `turn` is the one of the row
    energy_error    E / E0 - 1 where it was largest in magnitude since the row before, signed
    momentum_error  |L - L0| / |L0| likewise, in space
    attitude_error  largest entry of R - R_true against the closed form; at the end only
    status          empty, or why there is no number
    """
    turns = QUICK_TURNS if quick else TURNS
    rows = []
    for runner in on_box:
        rows += box_rows(runner)
    for runner in runners:
        report(f"{runner.label}, {turns} turns")
        rows += body_rows(runner, turns)
    return pd.DataFrame(rows, columns=list(COLUMNS))


def body_rows(runner: Runner, turns: int) -> list[dict[str, Any]]:
    """H's free body, at turns 1, 2, 5, 10, ... and the last."""
    problem = galvi.problems.free_rigid_body()
    step = max(1, round(runner.step / GRID)) * GRID
    per_turn = max(1, round(period(problem) / step))
    return _rows(runner, problem, step, per_turn, per_turn * turns, marks(turns))


def box_rows(runner: Runner) -> list[dict[str, Any]]:
    """MuJoCo's free box, after the steps of its test."""
    problem = galvi.problems.free_box()
    return _rows(runner, problem, BOX_STEP, BOX_STEPS, BOX_STEPS, [1])


def period(problem: Problem) -> float:
    """Of a turn at the first angular velocity."""
    return float(math.tau / np.linalg.norm(problem.v0))


def marks(turns: int) -> list[int]:
    """1, 2, 5, 10, 20, 50, ... below the number of turns, and this."""
    decades = range(math.ceil(math.log10(turns)) + 1)
    return [n for k in decades for j in (1, 2, 5) if (n := j * 10**k) < turns] + [turns]


def _rows(
    runner: Runner, problem: Problem, step: float, every: int, count: int, kept: Sequence[int]
) -> list[dict[str, Any]]:
    """From a run of so many steps, of which every so many are saved, at the saved ones kept."""
    turn, nan = period(problem), float("nan")
    told = {
        "problem": problem.name, "contender": runner.label, "engine": runner.engine, "step": step,
        "turns": count * step / turn, "turn": nan, "energy_error": nan, "momentum_error": nan,
        "attitude_error": nan, "status": runner.contender.missing, "commit": "", "date": "",
    }  # fmt: skip
    if runner.contender.missing:
        return [told]
    moving = _unbound(problem) if runner.joint == "free" else problem
    run = runner.contender.run(moving, count * step, {"step": step, "save_every": every})
    R, w = run.q[:, :3, :3], run.problem.system.velocity(run.p)[:, :3]
    energy, momentum = _energy_errors(problem, R, w), _momentum_errors(problem, R, w)
    rows = []
    for first, last in zip([0, *kept[:-1]], kept, strict=True):
        rows.append(
            {
                **told,
                "turn": float(run.t[last] - run.t[0]) / turn,
                "energy_error": _largest(energy[first + 1 : last + 1]),
                "momentum_error": _largest(momentum[first + 1 : last + 1]),
                "status": "" if np.all(np.isfinite(R[last])) else run.status,
            }
        )
    truth = FREE_TOP.run(problem, count * step, {"samples": 1})
    rows[-1]["attitude_error"] = largest_entry(R[-1], truth.q[-1])
    return rows


def _unbound(problem: Problem) -> Problem:
    """The same body where it could also go away."""
    body = galvi.FreeBody(1.0, problem.system.inertia)
    start = np.eye(4)
    start[:3, :3] = problem.q0
    return galvi.Problem(body, start, np.concatenate([problem.v0, np.zeros(3)]))


def _energy_errors(problem: Problem, R: Array, w: Array) -> Array:
    """E / E0 - 1 of attitudes (k, 3, 3) and angular velocities in the body's frame (k, 3), (k,)."""
    exact = textbook.energy(problem, problem.q0[None], problem.v0[None])
    relative: Array = textbook.energy(problem, R, w) / exact - 1.0
    return relative


def _momentum_errors(problem: Problem, R: Array, w: Array) -> Array:
    """|L - L0| / |L0|, likewise."""
    exact = textbook.angular_momentum(problem, problem.q0[None], problem.v0[None])
    change = np.linalg.norm(textbook.angular_momentum(problem, R, w) - exact, axis=-1)
    relative: Array = change / np.linalg.norm(exact)
    return relative


def _largest(errors: Array) -> float:
    """The one of largest magnitude; NaN when one is not known."""
    return float(errors[np.argmax(np.abs(errors))])


@dataclass(frozen=True)
class Part:
    """One contender's long run.

    files  where its rows go
    code   version of the code
    """

    runner: Runner
    turns: int
    files: RowFiles
    code: str

    @property
    def title(self) -> str:
        """For progress."""
        return f"{self.runner.label}, {self.turns} turns"

    @property
    def name(self) -> str:
        """Of its file: contender, turns, engine and version."""
        words = f"{self.title} {self.runner.engine}"
        return f"{re.sub(r'[^a-z0-9.]+', '-', words.lower()).strip('-')}_{self.code}"

    def done(self) -> bool:
        """Whether its rows are there."""
        return self.files.read(self.name) is not None

    def run(self, report: Report) -> None:
        """Turn the body and keep the rows."""
        report(self.title)
        date = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")
        rows = pd.DataFrame(body_rows(self.runner, self.turns), columns=list(COLUMNS))
        self.files.write(self.name, rows.assign(commit=self.code, date=date))


def parts(
    studies: Path,
    report: Report,
    turns: int = MANY_TURNS,
    runners: Sequence[Runner] = RUNNERS,
    code: str | None = None,
) -> list[Part]:
    """One for each contender that is here."""
    files, code = RowFiles(studies / FOLDER, COLUMNS, report), code or version()
    for runner in runners:
        if runner.contender.missing:
            report(f"{runner.label}: {runner.contender.missing}")
    return [Part(one, turns, files, code) for one in runners if not one.contender.missing]


def stored(studies: Path, report: Report) -> pd.DataFrame:
    """Every row that is there, of any version; none when the study was not run."""
    return RowFiles(studies / FOLDER, COLUMNS, report).all()
