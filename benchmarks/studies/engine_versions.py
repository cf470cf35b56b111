"""One free body in several versions of MuJoCo, each in its own environment.

Versions differ in the convergence of the attitude error and in the energy error. Each version has
one file of rows; one that cannot be installed has a row with the reason, and is retried next time.
"""

from __future__ import annotations

import hashlib
import json
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.applications.releases.own_run import SAMPLES, Answer, Motion, OwnRun
from benchmarks.applications.releases.requirements import (
    USUAL_RELEASES,
    installed,
    interpreter,
    requirement,
)
from benchmarks.checks.claim import Report
from benchmarks.store.isolated_environment import EnvironmentUnavailable
from benchmarks.store.provenance import today, version
from benchmarks.store.row_files import RowFiles
from galvi.arrays import Array
from references.closed_forms.top_motion import FREE_TOP
from references.mujoco import own_model
from references.mujoco.body import from_mujoco, mujoco_body, to_mujoco
from references.mujoco.steps import MUJOCO_RK4

COLUMNS: Mapping[str, type] = {
    "engine": str,
    "joint": str,
    "integrator": str,
    "step": float,
    "attitude_error": float,
    "energy_error": float,
    "status": str,
    "commit": str,
    "date": str,
}
INTEGRATORS = ("Euler", "RK4", "implicit", "implicitfast", "discrete")
NESTED, NESTED_ON = "free, nested", "free"  # half of the inertia in a body that is fixed in it
DURATION = 10.0
STEPS = tuple(0.1 / 2.0**k for k in range(9))
FOLDER = "engine_versions"  # subfolder of the studies
PROGRAM = Path(own_model.__file__)


@dataclass(frozen=True)
class Part:
    """The runs of one version.

    Attributes
    ----------
    version
        such as "3.6.0"
    files
        the files of its rows
    """

    version: str
    files: RowFiles

    @property
    def title(self) -> str:
        """The title in progress and tables, e.g. 'mujoco 3.6.0'."""
        return engine_of(self.version)

    @property
    def name(self) -> str:
        """The name of its file: the version and a digest of the job."""
        return f"{self.title.replace(' ', '-')}_{_digest()}"

    def is_complete(self) -> bool:
        """Whether its rows exist."""
        table = self.files.read(self.name)
        return table is not None and bool((table["status"] == "").any())

    def run(self, report: Report) -> None:
        """Install it if necessary, run the bodies, evaluate the results and write the rows."""
        try:
            report(f"{self.title}: installing")
            with interpreter("mujoco", self.version, self.files.folder) as python:
                report(f"{self.title}: moving")
                rows = rows_of(answers(python))
        except EnvironmentUnavailable as error:
            report(f"{self.title}: {error}")
            rows = [_absent(self.title, str(error))]
        table = pd.DataFrame(rows).assign(commit=version(), date=today())
        self.files.write(self.name, table)


def engine_versions(quick: bool = False, report: Report = lambda sentence: None) -> pd.DataFrame:
    """The rows of the installed version, for each joint, integrator and step; see COLUMNS.

    attitude_error  largest entry of R - R_true over the samples of 10 units of time, against the
                    closed form
    energy_error    largest |E / E0 - 1| over the samples
    """
    if MUJOCO_RK4.missing:
        rows = [_absent("mujoco", MUJOCO_RK4.missing)]
    else:
        report(f"mujoco {installed('mujoco')}")
        rows = rows_of(answers())
    return pd.DataFrame(rows, columns=list(COLUMNS)).assign(commit="", date="")


def parts(studies: Path, report: Report, versions: Sequence[str] = ()) -> list[Part]:
    """A part for each version: older ones and the installed one."""
    files = RowFiles(studies / FOLDER, COLUMNS, report)
    selected = versions or (*USUAL_RELEASES["mujoco"], installed("mujoco"))
    return [Part(version, files) for version in selected if version]


def stored(studies: Path, report: Report) -> pd.DataFrame:
    """The stored rows of the current job; none when the study was not run."""
    tables = [part.files.read(part.name) for part in parts(studies, report)]
    existing = [table for table in tables if table is not None]
    return (
        pd.concat(existing, ignore_index=True) if existing else pd.DataFrame(columns=list(COLUMNS))
    )


def engine_of(version: str) -> str:
    """What is installed for a version, such as "mujoco 3.6.0"."""
    return requirement("mujoco", version).replace("==", " ")


def answers(python: str | Path = sys.executable) -> dict[str, Answer]:
    """Run each body by the MuJoCo of this interpreter.

    Raises EnvironmentUnavailable where it fails.
    """
    return {joint: run.answer(specifications(run), python=python) for joint, run in _runs().items()}


def specifications(run: OwnRun) -> list[dict[str, Any]]:
    """The runs to make: every integrator at every step."""
    counts = [round(DURATION / step) for step in STEPS]
    return [
        {**run.request(steps=count), "integrator": integrator}
        for integrator in INTEGRATORS
        for count in counts
    ]


def rows_of(answers: Mapping[str, Answer]) -> list[dict[str, Any]]:
    """A row for each body, integrator that the version has, and step."""
    settings = [(integrator, step) for integrator in INTEGRATORS for step in STEPS]
    return [
        {
            "engine": engine_of(answer.release.split()[1]),
            "joint": joint,
            "integrator": integrator,
            "step": step,
            **_errors(joint, motion),
        }
        for joint, answer in answers.items()
        for (integrator, step), motion in zip(settings, answer.motions, strict=True)
        if not motion.failure.startswith(own_model.NO_INTEGRATOR)
    ]


def _errors(joint: str, motion: Motion) -> dict[str, Any]:
    on = NESTED_ON if joint == NESTED else joint
    q, v = from_mujoco(on, motion.positions, motion.velocities)
    problem = _bodies()["ball"]
    with np.errstate(all="ignore"):
        attitude = float(np.max(np.abs(q[:, :3, :3] - _truth())))
        energy = problem.system.kinetic_energy(v[:, :3])
        start = problem.system.kinetic_energy(problem.v0)
        lost = float(np.max(np.abs(energy / start - 1.0)))
    finite = np.isfinite(attitude) and np.isfinite(lost)
    return {
        "attitude_error": attitude if finite else float("nan"),
        "energy_error": lost if finite else float("nan"),
        "status": "" if finite else motion.failure or "The states are not finite.",
    }


def _absent(engine: str, why: str) -> dict[str, Any]:
    nan = float("nan")
    blank = {"joint": "", "integrator": "", "step": nan, "attitude_error": nan, "energy_error": nan}
    return {"engine": engine, **blank, "status": why}


def _bodies() -> dict[str, Any]:
    """H's free body on a ball joint and, translating too, on a free joint; equal attitudes."""
    return {"ball": galvi.problems.free_rigid_body(), "free": galvi.problems.free_body_se3()}


def _runs() -> dict[str, OwnRun]:
    runs = {}
    for joint, problem in _bodies().items():
        start = to_mujoco(joint, problem.q0, problem.v0)
        job = {"mjcf": mujoco_body(problem.system).mjcf()}
        runs[joint] = OwnRun("mujoco", PROGRAM, job, *start, "", STEPS[0], DURATION, None, "")
    nested = {"mjcf": _nested(runs[NESTED_ON].job["mjcf"])}
    return {**runs, NESTED: replace(runs[NESTED_ON], job=nested)}


def _nested(mjcf: str) -> str:
    """The same body, with half of its mass and moments in a body that is fixed in it."""
    (inertial,) = re.findall(r"<inertial [^>]*/>", mjcf)

    def halved(match: re.Match[str]) -> str:
        return f'{match[1]}="{" ".join(repr(0.5 * float(number)) for number in match[2].split())}"'

    half = re.sub(r'(mass|diaginertia)="([^"]*)"', halved, inertial)
    return mjcf.replace(inertial, f"{half}<body>{half}</body>")


@cache
def _truth() -> Array:
    """Exact attitudes at the samples, (samples, 3, 3)."""
    return FREE_TOP.run(_bodies()["ball"], DURATION, {"samples": SAMPLES}).q[1:]


@cache
def _digest() -> str:
    job = [[run.job, specifications(run)] for run in _runs().values()]
    return hashlib.sha256(PROGRAM.read_bytes() + json.dumps(job).encode()).hexdigest()[:8]
