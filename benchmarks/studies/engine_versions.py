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
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.checks.claim import Report
from benchmarks.store.isolated_environment import NotHere, environment, finished
from benchmarks.store.provenance import today, version
from benchmarks.store.row_files import RowFiles
from galvi.arrays import Array
from references.closed_forms.top_motion import FREE_TOP
from references.mujoco import other_versions
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
OLDER = tuple(f"mujoco=={one}" for one in ("3.6.0", "3.10.0", "3.11.0", "3.13.0", "3.17.0"))
NESTED, NESTED_ON = "free, nested", "free"  # half of the inertia in a body that is fixed in it
DURATION, SAMPLES = 10.0, 10
STEPS = tuple(0.1 / 2.0**k for k in range(9))
FOLDER = "engine_versions"  # subfolder of the studies
SCRIPT = Path(other_versions.__file__)


@dataclass(frozen=True)
class Part:
    """The runs of one version.

    Attributes
    ----------
    requirement
        requirement to install, e.g. "mujoco==3.6.0"
    files
        the files of its rows
    """

    requirement: str
    files: RowFiles

    @property
    def title(self) -> str:
        """The title in progress and tables, e.g. 'mujoco 3.6.0'."""
        return self.requirement.replace("==", " ")

    @property
    def name(self) -> str:
        """The name of its file: the version and a digest of the job."""
        return f"{self.title.replace(' ', '-')}_{_digest()}"

    def done(self) -> bool:
        """Whether its rows exist."""
        frame = self.files.read(self.name)
        return frame is not None and bool((frame["status"] == "").any())

    def run(self, report: Report) -> None:
        """Install it if necessary, run the bodies, evaluate the results and write the rows."""
        try:
            report(f"{self.title}: installing")
            with environment(self.requirement, self.files.folder) as python:
                report(f"{self.title}: moving")
                rows = judged(self.title, _moved(python))
        except NotHere as error:
            report(f"{self.title}: {error}")
            rows = [_absent(self.title, str(error))]
        frame = pd.DataFrame(rows).assign(commit=version(), date=today())
        self.files.write(self.name, frame)


def engine_versions(quick: bool = False, report: Report = lambda sentence: None) -> pd.DataFrame:
    """The rows of the installed version, for each joint, integrator and step; see COLUMNS.

    attitude_error  largest entry of R - R_true over the samples of 10 units of time, against the
                    closed form
    energy_error    largest |E / E0 - 1| over the samples
    """
    engine = _current().replace("==", " ")
    report(engine)
    try:
        if MUJOCO_RK4.missing:
            raise NotHere(MUJOCO_RK4.missing)
        rows = judged(engine, _moved(Path(sys.executable)))
    except NotHere as error:
        rows = [_absent(engine, str(error))]
    return pd.DataFrame(rows, columns=list(COLUMNS)).assign(commit="", date="")


def parts(studies: Path, report: Report, requirements: Sequence[str] | None = None) -> list[Part]:
    """A part for each version: older ones and the installed one."""
    files = RowFiles(studies / FOLDER, COLUMNS, report)
    return [Part(wanted, files) for wanted in requirements or (*OLDER, _current())]


def stored(studies: Path, report: Report) -> pd.DataFrame:
    """The stored rows of the current job; none when the study was not run."""
    frames = [part.files.read(part.name) for part in parts(studies, report)]
    known = [frame for frame in frames if frame is not None]
    return pd.concat(known, ignore_index=True) if known else pd.DataFrame(columns=list(COLUMNS))


def judged(engine: str, answer: Mapping[str, Any]) -> list[dict[str, Any]]:
    """A row for each run in an engine's answer, with the version that it reports."""
    name = f"{engine.partition(' ')[0]} {answer['version']}"
    return [_row(name, _truth(), run) for run in answer["runs"]]


def _row(engine: str, truth: Array, run: Mapping[str, Any]) -> dict[str, Any]:
    joint = NESTED_ON if run["joint"] == NESTED else run["joint"]
    q, v = from_mujoco(joint, np.array(run["qpos"]), np.array(run["qvel"]))
    problem = _bodies()["ball"]
    with np.errstate(all="ignore"):
        attitude = float(np.max(np.abs(q[:, :3, :3] - truth)))
        energy = problem.system.kinetic_energy(v[:, :3])
        start = problem.system.kinetic_energy(problem.v0)
        lost = float(np.max(np.abs(energy / start - 1.0)))
    good = np.isfinite(attitude) and np.isfinite(lost)
    return {
        "engine": engine,
        "joint": run["joint"],
        "integrator": run["integrator"],
        "step": run["step"],
        "attitude_error": attitude if good else float("nan"),
        "energy_error": lost if good else float("nan"),
        "status": "" if good else "The states are not finite: the step is too large.",
    }


def _absent(engine: str, why: str) -> dict[str, Any]:
    nan = float("nan")
    blank = {"joint": "", "integrator": "", "step": nan, "attitude_error": nan, "energy_error": nan}
    return {"engine": engine, **blank, "status": why}


def _moved(python: Path) -> Mapping[str, Any]:
    """The answer to the job by the MuJoCo of this interpreter."""
    printed = finished([str(python), "-I", str(SCRIPT)], json.dumps(_job()))
    return json.loads(printed)


def _bodies() -> dict[str, Any]:
    """H's free body on a ball joint and, translating too, on a free joint; equal attitudes."""
    return {"ball": galvi.problems.free_rigid_body(), "free": galvi.problems.free_body_se3()}


def _job() -> dict[str, Any]:
    models = {}
    for joint, problem in _bodies().items():
        qpos, qvel = to_mujoco(joint, problem.q0, problem.v0)
        mjcf = mujoco_body(problem.system).mjcf()
        models[joint] = {"mjcf": mjcf, "qpos": qpos.tolist(), "qvel": qvel.tolist()}
    models[NESTED] = {**models[NESTED_ON], "mjcf": _nested(models[NESTED_ON]["mjcf"])}
    return {"models": models, "steps": STEPS, "duration": DURATION, "samples": SAMPLES}


def _nested(mjcf: str) -> str:
    """The same body, with half of its mass and moments in a body that is fixed in it."""
    (whole,) = re.findall(r"<inertial [^>]*/>", mjcf)

    def halved(found: re.Match[str]) -> str:
        return f'{found[1]}="{" ".join(repr(0.5 * float(one)) for one in found[2].split())}"'

    half = re.sub(r'(mass|diaginertia)="([^"]*)"', halved, whole)
    return mjcf.replace(whole, f"{half}<body>{half}</body>")


@cache
def _truth() -> Array:
    """Exact attitudes at the samples, (samples, 3, 3)."""
    return FREE_TOP.run(_bodies()["ball"], DURATION, {"samples": SAMPLES}).q[1:]


@cache
def _digest() -> str:
    asked = SCRIPT.read_bytes() + json.dumps(_job()).encode()
    return hashlib.sha256(asked).hexdigest()[:8]


def _current() -> str:
    """The requirement of the installed version, or the minimum of the references."""
    try:
        return f"mujoco-core=={metadata.version('mujoco-core')}"
    except metadata.PackageNotFoundError:
        return "mujoco-core==4.0.1"
