"""The pages of the reference: every public name of galvi, grouped as a reader looks for it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from inspect import isclass, ismodule
from typing import Any

import galvi
from reports.site.docstrings import restructured
from reports.site.examples import examples

PROBLEMS = tuple(f"problems.{name}" for name in galvi.problems.__all__)


@dataclass(frozen=True)
class Group:
    """A page: its file, its title, what it is for, and (heading, names) of its sections."""

    file: str
    title: str
    text: str
    sections: tuple[tuple[str, tuple[str, ...]], ...]

    @property
    def names(self) -> tuple[str, ...]:
        """All names of the page, in order."""
        return tuple(name for _, names in self.sections for name in names)


GROUPS = (
    Group(
        "run", "Run", "A problem, a method and a step make a run; a run can be kept and continued.",
        (("", ("integrate", "resume", "integrate_many", "Problem", "Trajectory", "states_at",
              "save", "load")),),
    ),
    Group(
        "methods", "Methods", "A method is a space of curves and a quadrature rule. "
        "On a Lie group it works in a chart; a moving frame does the known part exactly, and in a "
        "clock the steps follow the motion.",
        (
            ("Method", ("Galerkin",)),
            ("Spaces", ("Polynomials", "ComponentPolynomials", "PolynomialFourier", "Fourier",
                        "PiecewisePolynomials", "PiecewiseHermite")),
            ("Quadrature rules", ("gauss", "lobatto", "radau", "clenshaw_curtis", "newton_cotes",
                                  "composite", "Rule")),
            ("Charts", ("Cayley", "Exponential", "ModifiedRodrigues")),
            ("Moving frames", ("KeplerFrame", "HarmonicFrame")),
            ("Clocks", ("DynamicalTime", "Sundman", "Clock")),
        ),
    ),
    Group(
        "systems", "Systems", "What moves: masses, bodies, trees of bodies, or any Lagrangian, and "
        "the group on which its configurations live.",
        (
            ("Systems", ("Canonical", "NBody", "RigidBody", "FreeBody", "Multibody", "Joint",
                         "Link", "Lagrangian", "PlanarChain")),
            ("Groups", ("Rn", "SO2", "SO3", "SE2", "SE3", "Product", "nearest_rotation")),
        ),
    ),
    Group(
        "forces", "Potentials and forces", "Built-in ones are values that run compiled, and that "
        "other codes of the suite recognise; your own are functions, see "
        "[models of your own](../../models.md).",
        (
            ("Potentials", ("CentralForce", "LinearSpring", "SpringChain", "UniformField",
                            "UniformGravity", "CosinePotential", "PendulumWeight")),
            ("Drag", ("RotorDrag", "QuadraticDrag", "SchillerNaumann")),
        ),
    ),
    Group(
        "problems", "Problems", "Problems that are ready to run. Each states its units in `units`.",
        (("", ("problems", *PROBLEMS)),),
    ),
    Group(
        "results", "Looking at a run", "What a run conserves, and how it reads in other terms.",
        (
            ("Invariants", ("energy", "momentum_map", "linear_momentum", "momentum_balance",
                            "MomentumBalance")),
            ("Orbits and attitudes", ("heliocentric", "orbital_elements", "OrbitalElements",
                                      "rotations", "orthogonality_defect")),
            ("Events", ("find_events", "Event", "Found", "events")),
        ),
    ),
    Group(
        "ensembles", "Ensembles",
        "Many members of one system: see [ensembles](../../ensembles.md).",
        (
            ("Run", ("integrate_ensemble", "Ensemble")),
            ("What is kept", ("FinalStates", "StatesAt", "Extrema", "Histogram")),
        ),
    ),
    Group(
        "interop", "Other packages", "From REBOUND and MuJoCo, a verdict on their runs, and what "
        "to cite. To REBOUND, SciPy, xarray and pandas a `Trajectory` converts itself.",
        (("", ("from_rebound", "from_mujoco", "judge", "Judged", "cite", "Citation")),),
    ),
    Group(
        "theory", "Errors and theory", "Which degree and step reach an error, what theory says of "
        "a method, and checks that need no other solution.",
        (
            ("Degree and step", ("recommend", "Recommendation")),
            ("Theory", ("theory", "Theory")),
            ("Checks", ("round_trip_error", "symplecticity_defect", "step_derivative")),
        ),
    ),
)  # fmt: skip

# Values that galvi makes: readers look up their fields, and never call them.
MADE = {"Trajectory", "Ensemble", "Found", "Judged", "Recommendation", "Theory", "MomentumBalance",
        "OrbitalElements", "Citation"}  # fmt: skip
SPACE = ("dimension", "basis", "derivative")
SYSTEM = ("momentum", "velocity", "potential_energy")
MEMBERS = {  # those of which users read or call more than the docstring of the class explains
    "Problem": ("p0", "with_initial_state", "body_names"),
    "Trajectory": ("__call__", "velocity", "v", "plot", "to_frame", "to_xarray", "to_scipy",
                   "to_rebound"),
    "Galerkin": ("name", "order", "symmetric", "stages", "theory", "table"),
    **dict.fromkeys(("ComponentPolynomials", "PolynomialFourier", "Fourier", "PiecewisePolynomials",
                     "PiecewiseHermite"), SPACE),
    "Polynomials": (*SPACE, "nodes", "lagrange"),
    "Rule": ("points", "nodes", "weights", "symmetric"),
    **dict.fromkeys(("Canonical", "NBody", "FreeBody"), SYSTEM),
    "RigidBody": (*SYSTEM, "torque"),
    "Lagrangian": ("from_sympy", "untraced", "momentum", "velocity", "energy"),
    "Multibody": ("from_mujoco", "to_mujoco", "with_numbers", "acceleration"),
    **dict.fromkeys(("Rn", "SO2", "SO3", "SE2", "SE3"), ("multiply", "inverse", "bracket")),
    "Product": ("join", "parts"),
    "MomentumBalance": ("defect",),
    "OrbitalElements": ("pericentre_longitude", "mean_longitude", "states"),
    "Ensemble": ("members", "success", "status"),
    "Judged": ("passed", "own", "recommended", "table", "truth_agreement", "summary", "notes",
               "duration"),
    "Theory": ("to_dict",),
}  # fmt: skip
KNOWN = {name for group in GROUPS for name in group.names} | {
    f"{name}.{member}" for name, members in MEMBERS.items() for member in members
}


def public(name: str) -> Any:
    """The object of a public name, e.g. "integrate" or "problems.kepler"."""
    found: Any = galvi
    for part in name.split("."):
        found = getattr(found, part)
    return found


def pages() -> Iterator[tuple[str, str]]:
    """(file, text) of the pages of the reference, the list of all names first."""
    lines = ["# Reference", "", "Every public name of `galvi`, with an example each.", ""]
    for group in GROUPS:
        lines += [f"## [{group.title}]({group.file}.md)", "", group.text, "", "```{eval-rst}"]
        for name in group.names:
            lines += [f":py:obj:`{name} <galvi.{name}>`", f"    {_first(name)}", ""]
        lines += ["```", ""]
    lines += ["```{toctree}", ":hidden:", "", *(group.file for group in GROUPS), "```", ""]
    yield "api/index.md", "\n".join(lines)
    for group in GROUPS:
        yield f"api/{group.file}.md", _page(group)


def _first(name: str) -> str:
    """The first paragraph of a docstring."""
    return restructured(public(name).__doc__ or "", KNOWN, name)[0]


def _page(group: Group) -> str:
    lines = [f"# {group.title}", "", group.text, ""]
    for heading, names in group.sections:
        lines += [f"## {heading}", ""] if heading else []
        lines += ["```{eval-rst}"]
        for name in names:
            lines += [f".. {_directive(name)}:: galvi.{name}"]
            members = MEMBERS.get(name, ())
            plain = [one for one in members if not one.startswith("__")]
            lines += [f"   :members: {', '.join(plain)}"] if plain else []
            lines += ["   :special-members: __call__"] if "__call__" in members else []
            lines += [""]
        lines += ["```", ""]
    return "\n".join(lines)


def _directive(name: str) -> str:
    one = public(name)
    return "automodule" if ismodule(one) else "autoclass" if isclass(one) else "autofunction"


def docstring(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Sphinx's `autodoc-process-docstring`: as reStructuredText, with the example at its end."""
    short = name.removeprefix("galvi.")
    if lines and lines[0].startswith("alias of"):
        text = list(lines)
    else:
        text = restructured("\n".join(lines), KNOWN, short)
    if short in examples():
        shown = (f"    {line}".rstrip() for line in examples()[short].splitlines())
        text += ["", ".. code-block:: pycon", "", *shown, ""]
    lines[:] = text


def signature(
    app: Any, what: str, name: str, obj: Any, options: Any, arguments: str | None, result: Any
) -> tuple[str, None] | None:
    """Sphinx's `autodoc-process-signature`: none for a value that galvi makes."""
    if name.removeprefix("galvi.") in MADE:
        return "", None
    return (arguments.replace("<factory>", "..."), None) if arguments else None
