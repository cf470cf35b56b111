"""Reference solutions and models as files, for projects that do not install galvi."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.applications.kit.models import Model, all_models
from benchmarks.applications.kit.orders import ORDER_TOLERANCE, Convergence
from benchmarks.applications.kit.point_masses import (
    WRITTEN_FOR_GALVI,
    PointMasses,
    all_point_masses,
)
from benchmarks.applications.kit.truths import RULE, Truth
from benchmarks.store.atomic import write
from benchmarks.store.provenance import commit, today, versions
from galvi.arrays import Array
from references import IAS15, MUJOCO_RK4, EngineMissing, missing_engine
from references.stored.provenance import truths

FORMAT = 1
TESTS_FOLDER = Path(__file__).parents[2] / "docs" / "kit"
README = Path(__file__).with_name("kit_readme.md")
MANIFEST = "manifest.json"
POINT_MASSES, MODELS = "point_masses", "models"
COMPUTED_WITH = ("rebound", "mujoco-core", "scipy", "numpy", "de421")
UNITS_OF_MODELS = "m, kg, s, rad"
NOT_LICENSED = "written for galvi, whose repository has no licence file at present"
LICENCES = {
    "models, numbers and texts": NOT_LICENSED,
    "states and GM of the Sun and the planets": "of JPL's ephemeris DE421 (Folkner, Williams and "
    "Boggs 2009, IPN Progress Report 42-178), read through the Python package de421 (MIT)",
    "other initial states": "`start` in a problem's file names the publication, or says that the "
    "numbers were written for galvi",
}
FIELDS = {
    "format": "version of this format",
    "stored_truths": "what computed the states that are stored with galvi",
    "name": "name of the files, without their extensions",
    "title": "the problem or model",
    "start": "source of the masses and the initial state",
    "units": "of all numbers; `G = 1` alone where they are arbitrary; angles are in radians",
    "G": "gravitational constant; some problems with G = 1 give GM as mass, as `units` says",
    "t0": "initial time",
    "bodies": "mass `m`, position and velocity of each body at t0, in an inertial frame; bodies "
    "with m = 0 exert no force",
    "names": "of the bodies, in the same order",
    "qpos, qvel, ctrl": "state of a model at t = 0 and its constant controls, which are also the "
    "keyframe of its XML file",
    "truth": "states at later times `t`",
    "q, v": "position and velocity of each body, in the order of `bodies`",
    "truth: qpos, qvel": "as MuJoCo defines them. Quaternions are (w, x, y, z), and q and -q are "
    "the same attitude. A ball joint's velocity is its angular velocity in the body's frame; a "
    "free joint's is the velocity of the body's origin in the world frame, then the angular "
    "velocity in the body's frame",
    "error_q, error_v": f"stated errors of every position and every velocity (distances): {RULE}",
    "error_qpos, error_qvel": "stated errors of every joint's position and velocity, by the same "
    "rule; of a ball joint, and of the attitude of a free joint, the position is an angle",
    "computed_by": "source of the states",
    "compared_with": "second source, from which the stated errors follow",
    "orders": "for each integrator its order of convergence; the index in `truth`, from 0, of the "
    "time at which errors of positions were measured; and three step sizes, each half of the one "
    f"before. Orders measured from one to the next were within {ORDER_TOLERANCE:g} of the order; a "
    "test may allow 0.3. It is null where there are no such steps, or for integrators that choose "
    "their own",
    "tables (.txt)": "of point masses, a row for each time and body: t, G m, x, y, z, vx, vy, vz, "
    "error_q, error_v; of models, a row for each time: t, error_qpos, error_qvel, qpos, qvel. The "
    "first time is the start",
}


def write_kit(folder: Path, report: Callable[[str], None] = lambda sentence: None) -> Path:
    """Write the kit into a folder, which is made if it does not exist; returns its path.

    Parameters
    ----------
    report
        called with the name of each problem and model before it is computed, and with "" at the end

    Raises
    ------
    EngineMissing
        Without REBOUND or MuJoCo, before anything is computed.
    """
    for engine in (IAS15, MUJOCO_RK4):
        if engine.missing:
            raise EngineMissing(engine.missing, name=missing_engine(engine))
    point_masses, models = all_point_masses(), all_models()
    files: dict[str, str] = {}
    for case in point_masses:
        report(case.name)
        files |= files_of_point_masses(case)
    for model in models:
        report(model.name)
        files |= files_of_model(model)
    for path in sorted((*TESTS_FOLDER.glob("*.py"), *TESTS_FOLDER.glob("*.cpp"))):
        files[f"tests/{path.name}"] = path.read_text(encoding="utf-8")
    files["README.md"] = README.read_text(encoding="utf-8")
    names = {POINT_MASSES: [x.name for x in point_masses], MODELS: [x.name for x in models]}
    files[MANIFEST] = manifest(names, files)
    for name, text in files.items():
        write(folder / name, text)
    report("")
    return folder


def is_kit(folder: Path) -> bool:
    """Whether the folder has the manifest of a kit."""
    try:
        content = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(content, dict) and {"format", "galvi", "sha256"} <= content.keys()


def manifest(names: Mapping[str, list[str]], files: Mapping[str, str]) -> str:
    """The manifest as JSON: what computed the files, the meaning of their fields, and their hashes.

    Parameters
    ----------
    names
        POINT_MASSES and MODELS -> the names of the problems and models
    files
        name of a file -> its text
    """
    installed = versions()
    content = {
        "format": FORMAT,
        "galvi": installed["galvi"],
        "commit": commit(),
        "date": today(),
        "computed_with": {"python": platform.python_version()}
        | {name: installed[name] for name in COMPUTED_WITH},
        "stored_truths": sorted({truth["engine"] for truth in truths()}),
        **names,
        "fields": FIELDS,
        "licences": LICENCES,
        "sha256": {
            name: hashlib.sha256(text.encode()).hexdigest() for name, text in sorted(files.items())
        },
    }
    return _json(content)


def files_of_point_masses(case: PointMasses) -> dict[str, str]:
    """Name -> text of the files of a problem of point masses."""
    truth, problem = case.truth(), case.problem
    system: Any = problem.system
    q, v = (_in_space(x) for x in (truth.q, truth.v))
    letters = ("m", "x", "y", "z", "vx", "vy", "vz")
    bodies = np.column_stack([system.masses, q[0], v[0]]).tolist()
    content = {
        **_head(case.name, problem.name, case.start, problem.units or f"G = {system.G:g}"),
        "G": float(system.G),
        "t0": float(problem.t0),
        "names": [str(name) for name in problem.body_names()],
        "bodies": [dict(zip(letters, body, strict=True)) for body in bodies],
        "truth": _rows(t=truth.t, q=q, v=v, error_q=truth.error_q, error_v=truth.error_v),
        **_sources_and_orders(case, truth),
    }
    table = [
        [t, system.G * mass, *position, *velocity, *errors]
        for t, positions, velocities, *errors in zip(
            truth.t, q, v, truth.error_q, truth.error_v, strict=True
        )
        for mass, position, velocity in zip(system.masses, positions, velocities, strict=True)
    ]
    path = f"{POINT_MASSES}/{case.name}"
    return {f"{path}.json": _json(content), f"{path}.txt": _table(table)}


def files_of_model(model: Model) -> dict[str, str]:
    """Name -> text of the files of a model."""
    truth, start = model.truth(), model.start()
    qpos, qvel = model.problem.system.to_mujoco(truth.q, truth.v)
    qpos[0], qvel[0] = start["qpos"], start["qvel"]
    errors = {"error_qpos": truth.error_q, "error_qvel": truth.error_v}
    content = {
        **_head(model.name, model.problem.name, WRITTEN_FOR_GALVI, UNITS_OF_MODELS),
        **start,
        "truth": _rows(t=truth.t, qpos=qpos, qvel=qvel, **errors),
        **_sources_and_orders(model, truth),
    }
    table = np.column_stack([truth.t, *errors.values(), qpos, qvel])
    path = f"{MODELS}/{model.name}"
    return {
        f"{path}.xml": model.mjcf,
        f"{path}.json": _json(content),
        f"{path}.txt": _table(table.tolist()),
    }


def _head(name: str, title: str, start: str, units: str) -> dict[str, Any]:
    return {"format": FORMAT, "name": name, "title": title, "start": start, "units": units}


def _sources_and_orders(case: PointMasses | Model, truth: Truth) -> dict[str, Any]:
    first, second = case.sources
    orders: Mapping[str, Convergence | None] = case.orders(truth)
    return {
        "computed_by": first.label,
        "compared_with": second.label,
        "orders": {name: order and asdict(order) for name, order in orders.items()},
    }


def _in_space(x: Array) -> Array:
    """Vectors in the plane or in space, (..., 2) or (..., 3), as vectors in space, (..., 3)."""
    return np.pad(x, [(0, 0)] * (x.ndim - 1) + [(0, 3 - x.shape[-1])])


def _rows(**columns: Array) -> list[dict[str, Any]]:
    """A mapping of names to values for each time but the first; the columns are (times, ...)."""
    return [
        {name: column[k].tolist() for name, column in columns.items()}
        for k in range(1, len(columns["t"]))
    ]


def _table(rows: list[list[float]]) -> str:
    """Rows of numbers as text, separated by spaces, with the digits that determine the float64."""
    return "".join(" ".join(repr(float(x)) for x in row) + "\n" for row in rows)


def _json(content: Mapping[str, Any]) -> str:
    """JSON with a line for each key, each entry of a mapping, and each mapping in a list."""
    return "{\n" + ",\n".join(_lines(content)) + "\n}\n"


def _lines(content: Mapping[str, Any]) -> Iterator[str]:
    for name, value in content.items():
        if isinstance(value, Mapping):
            members = [f"{json.dumps(key)}: {json.dumps(x)}" for key, x in value.items()]
            text = "{\n  " + ",\n  ".join(members) + "\n }"
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            text = "[\n  " + ",\n  ".join(map(json.dumps, value)) + "\n ]"
        else:
            text = json.dumps(value)
        yield f" {json.dumps(name)}: {text}"
