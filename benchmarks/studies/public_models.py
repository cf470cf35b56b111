"""Which public MuJoCo models galvi can read: `python -m benchmarks.studies.public_models`.

It reads every model in the wheels that `make install` keeps in the environment's ``models``, and
those that come with MuJoCo, and writes docs/public_models.csv with these columns:

model, version
    path of the file, and version of its package
velocities
    number of velocities; 0 where MuJoCo cannot read the file
left_out
    parts that had to be left out, as ``ignore`` takes them
difference
    the largest mass-weighted difference between the accelerations of MuJoCo and galvi, relative to
    the forces, over the start, all keyframes and random states near each
why_not
    why galvi cannot read the model; empty where it can
"""

from __future__ import annotations

import argparse
import logging
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from importlib.metadata import distribution
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pandas as pd

from benchmarks.store.atomic import write
from galvi.interop import from_mujoco
from galvi.interop.mujoco_limits import BeyondTrees
from galvi.interop.mujoco_model import misfits, sample_states

WHEELS = Path(sys.prefix) / "models"
TABLE = Path("docs") / "public_models.csv"
SUFFIXES = (".xml", ".urdf", ".mjb", ".mjz")


def model_files(folder: Path) -> Iterator[Path]:
    """The files of a wheel with the root of a model, among them parts with a root <mujoco>."""
    for path in sorted(path for path in folder.rglob("*") if path.suffix in SUFFIXES):
        if path.suffix not in (".xml", ".urdf") or _root(path) in ("mujoco", "robot"):
            yield path


def _root(path: Path) -> str:
    """The tag of the root element; "mujoco" for what is no XML, which only MuJoCo may read."""
    try:
        return ElementTree.parse(path).getroot().tag
    except ElementTree.ParseError:  # MuJoCo's parser accepts more
        return "mujoco"


def row(path: Path) -> dict[str, Any]:
    """The row of one model, without its name and version."""
    blank = {"velocities": 0, "left_out": "", "difference": np.nan}
    try:
        model, left_out = from_mujoco.model_of(path), ()
    except ValueError:
        return {**blank, "why_not": "MuJoCo cannot read it"}
    try:
        from_mujoco.read(model)
    except BeyondTrees as refusal:
        left_out = refusal.names
    except ValueError:
        pass  # the second reading gives the reason
    cells = {**blank, "velocities": int(model.nv), "left_out": ", ".join(left_out)}
    differences = [0.0]
    try:
        for key in (None, *range(model.nkey)):
            problem, user_model = from_mujoco.read(model, left_out, key)
            states = sample_states(problem.system, problem.q0, problem.v0)
            differences += [np.max(x) for x, _ in misfits(user_model, problem, states)]
    except ValueError as error:
        return {**cells, "why_not": str(error).replace(str(path), path.name)}
    return {**cells, "difference": float(np.max(differences)), "why_not": ""}


def table() -> pd.DataFrame:
    """A row for each model of each wheel and of MuJoCo."""
    package = Path(str(distribution("mujoco-core").locate_file("mujoco")))
    rows = _rows(package.parent, package, distribution("mujoco-core").version)
    for wheel in sorted(WHEELS.glob("*.whl")):
        with tempfile.TemporaryDirectory() as folder:
            with zipfile.ZipFile(wheel) as archive:
                archive.extractall(folder)
            rows += _rows(Path(folder), Path(folder), wheel.name.split("-")[1])
    return pd.DataFrame(rows)


def _rows(root: Path, folder: Path, version: str) -> list[dict[str, Any]]:
    names = ((path, path.relative_to(root).as_posix()) for path in model_files(folder))
    return [{"model": name, "version": version, **row(path)} for path, name in names]


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    logging.getLogger("galvi").setLevel(logging.ERROR)
    models = table()
    write(TABLE, models.to_csv(index=False, float_format="%.0e"))
    readable = models[models["why_not"] == ""]
    print(
        f"{len(readable)} of {len(models)} models can be read, "
        f"{(readable['left_out'] != '').sum()} of them with parts left out; largest difference "
        f"{readable['difference'].max():.0e}; see {TABLE}"
    )
