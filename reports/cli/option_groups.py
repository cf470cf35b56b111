"""Options that travel together: in the code one value, on the command line one option each."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from functools import wraps
from typing import Any, get_type_hints

import typer

from reports.cli.invocation import CLAIMS, CONTENDER, TIMEOUT

METHOD = typer.Option(
    [],
    "--method",
    metavar="rebound.whfast",
    help="Another code by its name, gauss:DEGREE of galvi's, or package.module:name of a "
    "galvi.Galerkin; may be repeated. Default: all that take the problem.",
)


def spread(command: Callable[..., int]) -> Callable[..., int]:
    """The command as typer reads it: each parameter that is a group is replaced by its fields.

    A group is a dataclass, whose fields have options as their defaults.
    """
    signature = inspect.signature(command, eval_str=True)
    groups = {name: one for name, one in get_type_hints(command).items() if is_dataclass(one)}

    @wraps(command)
    def grouped(**values: Any) -> int:
        for name, group in groups.items():
            values[name] = group(**{one.name: values.pop(one.name) for one in fields(group)})
        return command(**values)

    parameters = (
        one.replace(kind=inspect.Parameter.KEYWORD_ONLY)
        for name, parameter in signature.parameters.items()
        for one in (
            inspect.signature(groups[name], eval_str=True).parameters.values()
            if name in groups
            else [parameter]
        )
    )
    vars(grouped)["__signature__"] = signature.replace(parameters=list(parameters))
    return grouped


@dataclass(frozen=True)
class Checking:
    """What is checked, and of what: claims, engines that must be there, integrators of a user."""

    claims: str = CLAIMS
    require: str = typer.Option(
        None, "--require", metavar="rebound,mujoco", help="Engines whose absence is a failure."
    )
    contender: list[str] = CONTENDER
    timeout: float | None = TIMEOUT


@dataclass(frozen=True)
class ModelStart:
    """Where and how a model starts: of an archive of REBOUND's, or of a model of MuJoCo's."""

    snapshot: int = typer.Option(-1, "--snapshot", metavar="N", help="Of an archive; -1: the last.")
    key: str = typer.Option(
        None, "--key", metavar="NAME|N", help="Keyframe of a model to start at."
    )
    ignore: str = typer.Option(
        "", "--ignore", metavar="contacts,limits", help="What of a model to leave out."
    )
    qpos: str = typer.Option("", "--qpos", metavar="1,0.5", help="Start of a model: positions.")
    qvel: str = typer.Option("", "--qvel", metavar="0,0.1", help="Start of a model: velocities.")
    ctrl: str = typer.Option(
        "", "--ctrl", metavar="0,0.1", help="Constant controls of a model's actuators."
    )


@dataclass(frozen=True)
class Convergence:
    """Of which problem, methods and steps errors and orders are tabulated."""

    problem: str = typer.Option(
        "",
        "--problem",
        metavar="package.module:function",
        help="Returns a galvi.Problem and its duration.",
    )
    method: list[str] = METHOD
    contender: list[str] = CONTENDER
    steps: str = typer.Option(
        "",
        "--steps",
        metavar="50,100,200",
        help="Numbers of equal steps, or their sizes. Default: found by trying.",
    )
    duration: float | None = typer.Option(
        None, "--duration", metavar="T", help="In place of the problem's own."
    )
    truth: str = typer.Option(
        "", "--truth", metavar="scipy.dop853", help="The code that gives the truth."
    )


@dataclass(frozen=True)
class Selection:
    """Which tables or figures are exported: one by its name, or all; or what there is is listed."""

    name: str = typer.Argument(
        "", metavar="NAME", help="E.g. work_precision, ratios, numbers, fig-3-02."
    )
    listed: bool = typer.Option(False, "--list", help="Say what there is, instead of NAME.")
    every: bool = typer.Option(False, "--all", help="All tables, or figures, not NAME.")
