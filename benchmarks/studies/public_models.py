"""What galvi reads of public MuJoCo models: `python -m benchmarks.studies.public_models`.

It reads every model in the wheels that `make install` keeps in the environment's ``models``, and
those that come with MuJoCo, and writes docs/public_models.csv: the velocities, the parts that had
to be left out, as ``ignore`` takes them, and the largest difference between MuJoCo's accelerations
and galvi's, times the mass and relative to the forces, at the start, at all keyframes and at random
states beside each.
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
KINDS = (".xml", ".urdf", ".mjb", ".mjz")


def model_files(folder: Path) -> Iterator[Path]:
    """The files of a wheel that hold a whole model: not parts that others include."""
    for path in sorted(path for path in folder.rglob("*") if path.suffix in KINDS):
        if path.suffix not in (".xml", ".urdf") or _root(path) in ("mujoco", "robot"):
            yield path


def _root(path: Path) -> str:
    try:
        return ElementTree.parse(path).getroot().tag
    except ElementTree.ParseError:  # MuJoCo's own parser takes more
        return "mujoco"


def row(path: Path) -> dict[str, Any]:
    """The row of one model: velocities, parts left out, the difference, or why it is not read."""
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
        pass
    columns = {**blank, "velocities": int(model.nv), "left_out": ", ".join(left_out)}
    off = 0.0
    try:
        for key in (None, *range(model.nkey)):
            problem, own_model = from_mujoco.read(model, left_out, key)
            states = sample_states(problem.system, problem.q0, problem.v0)
            off = max(
                off,
                *(
                    float(np.max(difference))
                    for difference, _ in misfits(own_model, problem, states)
                ),
            )
    except ValueError as error:
        return {**columns, "why_not": str(error).replace(str(path), path.name)}
    return {**columns, "difference": off, "why_not": ""}


def table() -> pd.DataFrame:
    """A row for each model of each wheel and of MuJoCo."""
    engine = Path(str(distribution("mujoco-core").locate_file("mujoco")))
    rows = _rows(engine.parent, engine, distribution("mujoco-core").version)
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
    read = models[models["why_not"] == ""]
    print(
        f"{len(read)} of {len(models)} models are read; of {(read['left_out'] != '').sum()} parts"
    )
    print(f"are left out; largest difference {read['difference'].max():.0e}; see {TABLE}")
