"""Runs on disk: one .npz file with arrays and a line of JSON; nothing is pickled.

Spaces, rules, systems and potentials that are plain numbers are written field by field and come
back as equal values. Functions cannot be written: a run of such a system is loaded with its
problem given again.
"""

from __future__ import annotations

import json
import os
import tempfile
import zipfile
from dataclasses import fields, is_dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np

from galvi.arrays import read_only
from galvi.charts import CHARTS
from galvi.checkpoint import Checkpoint
from galvi.curves.group_curves import GroupCurves
from galvi.curves.vector_curves import Curves
from galvi.groups import GROUPS
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.rules.rule import Rule
from galvi.run.group_system import group_system
from galvi.spaces.component_polynomials import ComponentPolynomials
from galvi.spaces.fourier import Fourier
from galvi.spaces.piecewise_hermite import PiecewiseHermite
from galvi.spaces.piecewise_polynomials import PiecewisePolynomials
from galvi.spaces.polynomial_fourier import PolynomialFourier
from galvi.spaces.polynomials import Polynomials
from galvi.systems.canonical import Canonical
from galvi.systems.forces.rotor_drag import RotorDrag
from galvi.systems.free_body import FreeBody
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.nbody import NBody
from galvi.systems.planar_chain import PlanarChain
from galvi.systems.potentials.central_force import CentralForce
from galvi.systems.potentials.linear_spring import LinearSpring
from galvi.systems.potentials.pendulum import PendulumWeight
from galvi.systems.potentials.spring_chain import SpringChain
from galvi.systems.potentials.uniform_field import UniformField
from galvi.systems.potentials.uniform_gravity import UniformGravity
from galvi.systems.rigid_body import RigidBody
from galvi.trajectory import Trajectory

VALUES = (
    CentralForce, LinearSpring, SpringChain, PendulumWeight, UniformField, UniformGravity,
    RotorDrag, Polynomials, ComponentPolynomials, Fourier, PolynomialFourier, PiecewisePolynomials,
    PiecewiseHermite, Rule, Galerkin, Canonical, NBody, RigidBody, FreeBody, Lagrangian,
    PlanarChain, *map(type, CHARTS), *map(type, GROUPS),
)  # fmt: skip
NAMES = {kind.__name__: kind for kind in VALUES}
VERSION = 1
UNREADABLE = (KeyError, ValueError, TypeError, AttributeError, EOFError, OSError)


def save(run: Trajectory, path: str | os.PathLike[str]) -> None:
    """Write ``run`` to ``path`` (.npz), whole or not at all.

    Raises ValueError for a run that was not made by galvi.
    """
    if not isinstance(run, Trajectory) or run.continuation is None:
        raise ValueError(f"only a run of galvi.integrate can be saved; received {run!r}.")
    method = _written(run.method)
    if "unknown" in json.dumps(method):
        raise ValueError(
            f"a run can be saved when its space and rule are galvi's own; received {run.method!r}. "
            f"Save run.t, run.q and run.p with numpy.savez instead."
        )
    target = Path(path)
    problem, end = run.problem, run.continuation
    facts = {
        "version": VERSION,
        "problem": {"name": problem.name, "t0": problem.t0, "units": problem.units,
                    "parameters": _parameters(problem)},
        "system": _written(problem.system),
        "method": method,
        "success": run.success, "interrupted": run.interrupted, "status": run.status,
        "failed_step": run.failed_step,
        "counts": dict(run.counts), "step": run.step, "first": end.first, "solver": end.solver,
        "tolerance": end.tolerance, "curves": None if run.curves is None else run.curves.t0,
    }  # fmt: skip
    arrays = {
        "t": run.t, "q": run.q, "p": run.p, "q0": problem.q0, "v0": problem.v0,
        "state": end.state, "stages": end.stages, "memo": end.memo,
    }  # fmt: skip
    if run.curves is not None:
        arrays |= {"bases": run.curves.bases, "coefficients": run.curves.coefficients}
    handle, partial = tempfile.mkstemp(dir=target.parent, suffix=".partial")
    try:
        with os.fdopen(handle, "wb") as stream:
            contents: dict[str, Any] = {"facts": np.array(json.dumps(facts)), **arrays}
            np.savez(stream, **contents)
        os.chmod(partial, 0o644)
        os.replace(partial, target)
    except BaseException:
        os.unlink(partial)
        raise


def load(path: str | os.PathLike[str], problem: Problem | None = None) -> Trajectory:
    """The run that `save` wrote; it can be evaluated and resumed as before.

    problem  the run's problem; needed only when its system holds functions

    Raises ValueError when the file is not a saved run, when a problem is needed, or when the one
    given does not start where the run's did.
    """
    if problem is not None and not isinstance(problem, Problem):
        raise TypeError(f"problem must be a galvi.Problem; received {problem!r}.")
    try:
        with open(path, "rb") as stream, np.load(stream, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        facts = json.loads(str(arrays.pop("facts")))
        version = facts["version"]
    except FileNotFoundError:
        raise
    except (*UNREADABLE, zipfile.BadZipFile) as error:
        raise ValueError(
            f"{path} must be a run written by galvi.save; it cannot be read as one ({error})."
        ) from error
    if version != VERSION:
        raise ValueError(f"{path} must have format {VERSION}; received format {version}.")
    method = _read(facts["method"])
    if problem is None:
        about = facts["problem"]
        problem = Problem(
            _read(facts["system"], path), arrays["q0"], arrays["v0"], about["t0"], about["name"],
            about["parameters"], about["units"],
        )  # fmt: skip
    same = np.array_equal(problem.q0, arrays["q0"]) and np.array_equal(problem.v0, arrays["v0"])
    if not same or problem.t0 != facts["problem"]["t0"]:
        raise ValueError(
            f"problem must start where the run in {path} did; received another q0, v0 or t0."
        )
    written = facts["system"]
    if not _agree(_written(problem.system), written):
        raise ValueError(f"problem must have the system of the run in {path}; it has another one.")
    curves: Curves | GroupCurves | None = None
    if facts["curves"] is not None:
        pieces = (
            method.space, facts["curves"], facts["step"], read_only(arrays["bases"]),
            read_only(arrays["coefficients"]),
        )  # fmt: skip
        system = group_system(problem, method)
        curves = (
            Curves(*pieces, problem.q0.shape)
            if system is None
            else GroupCurves(*pieces, system.group, method.chart)
        )
    end = Checkpoint(
        facts["first"], read_only(arrays["state"]), read_only(arrays["stages"]), arrays["memo"],
        facts["solver"], facts["tolerance"],
    )  # fmt: skip
    return Trajectory(
        problem, read_only(arrays["t"]), read_only(arrays["q"]), read_only(arrays["p"]),
        facts["success"], facts["status"], facts["failed_step"], facts["counts"], facts["step"],
        method, curves, end, facts["interrupted"],
    )  # fmt: skip


def _written(value: Any) -> Any:
    if isinstance(value, VALUES) and is_dataclass(value):
        content = {field.name: _written(getattr(value, field.name)) for field in fields(value)}
        return {"kind": type(value).__name__, **content}
    if isinstance(value, np.ndarray):
        return {"kind": "array", "values": value.tolist()}
    if isinstance(value, tuple):
        return {"kind": "tuple", "values": [_written(item) for item in value]}
    if isinstance(value, Decimal):
        return {"kind": "decimal", "values": str(value)}
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    return {"kind": "unknown", "values": repr(value)}


def _agree(one: Any, other: Any) -> bool:
    """Whether two written values are the same, as far as what cannot be written leaves to tell."""
    if not isinstance(one, dict) or not isinstance(other, dict):
        return bool(one == other)
    if "unknown" in (one["kind"], other["kind"]):
        return one["kind"] == other["kind"] and _type_of(one) == _type_of(other)
    return one.keys() == other.keys() and all(_agree(one[key], other[key]) for key in one)


def _type_of(unknown: dict[str, Any]) -> str:
    """The type in the repr of a dataclass; the same word for all functions."""
    name, bracket, _ = unknown["values"].partition("(")
    return name if bracket and name.isidentifier() else "function"


def _read(written: Any, path: Any = "") -> Any:
    if not isinstance(written, dict):
        return written
    kind: str = written["kind"]
    values: Any = written.get("values")
    if kind == "array":
        return np.array(values)
    if kind == "tuple":
        return tuple(_read(item, path) for item in values)
    if kind == "decimal":
        return Decimal(values)
    if kind in NAMES:
        content = {name: _read(item, path) for name, item in written.items() if name != "kind"}
        return NAMES[kind](**content)
    raise ValueError(
        f"the run in {path} needs its problem, because {values} cannot be stored; "
        f"use galvi.load(path, problem=...)."
    )


def _parameters(problem: Problem) -> dict[str, Any]:
    return {name: _plain(value) for name, value in problem.parameters.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    return value if value is None or isinstance(value, (bool, int, float, str)) else repr(value)
