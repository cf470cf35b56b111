"""The reference pages: docstrings of functions, and examples."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from inspect import isclass, ismodule
from pathlib import Path
from typing import Any

import galvi

# From galvi's docstrings, which are plain text, to the reStructuredText that Sphinx reads.
#
# A block between blank lines is a paragraph, a list, a formula, or a legend: lines of a name, two
# spaces and its meaning, which goes on in indented lines.

ENTRY = re.compile(r"([A-Za-z_]\S*(?:, \S+)*) {2,}(\S.*)")
ITEM = re.compile(r"- (.*)")
CODE = re.compile(r"(``.+?``|`.+?`)")
CALL = re.compile(r"(?:galvi\.)?([A-Za-z_]\w*(?:\.\w+)*)(?:\([^<>`]*\))?")
SPECIAL = re.compile(r"([\\*|_`])")
LEAD = re.compile(r"^(?=[-+.:]|\w{1,4}[.)] )")  # what would begin a list, an option, a comment


def restructured(text: str, known: Collection[str], own: str = "") -> list[str]:
    """The lines of a docstring as reStructuredText.

    known  names to which code in backticks is linked, without "galvi."
    own    the name that the text explains, which needs no link
    """
    lines: list[str] = []
    for block in re.split(r"\n\s*\n", text.strip()):
        lines += [*_block(block.rstrip().splitlines(), known, own), ""]
    return lines


def _block(lines: Sequence[str], known: Collection[str], own: str) -> Iterator[str]:
    if len(lines) == 1 and " = " in lines[0] and lines[0][-1] not in ".;:,":
        yield from (".. code-block:: text", "", f"    {lines[0].strip()}")
        return
    entries = _entries(lines, ENTRY)
    if entries:
        for names, words in entries:
            yield ", ".join(f"``{name}``" for name in names.split(", "))
            yield f"    {_inline(words, known, own)}"
        return
    items = _entries(lines, ITEM)
    if items:
        yield from (f"* {_inline(words, known, own)}" for (words,) in items)
        return
    yield _inline(" ".join(line.strip() for line in lines), known, own)


def _entries(lines: Sequence[str], form: re.Pattern[str]) -> list[list[str]]:
    """The parts of each entry, when all lines are entries or go on with one; else none."""
    entries: list[list[str]] = []
    for line in lines:
        found = form.fullmatch(line)
        if found:
            entries.append(list(found.groups()))
        elif entries and line.startswith("  "):
            entries[-1][-1] += f" {line.strip()}"
        else:
            return []
    return entries


def _inline(text: str, known: Collection[str], own: str) -> str:
    parts = CODE.split(text)
    plain = [SPECIAL.sub(r"\\\1", part) for part in parts[::2]]
    code = [_code(part, known, own) for part in parts[1::2]]
    for place, part in enumerate(code):
        plain[place] += "" if not plain[place][-1:].isalnum() else "\\ "
        after = "\\ " if plain[place + 1][:1].isalnum() else ""
        plain[place] += part + after
    return LEAD.sub(r"\\", "".join(plain))


def _code(part: str, known: Collection[str], own: str) -> str:
    """Code in backticks: a link where it names a class, or anything public in single ones."""
    text = part.strip("`")
    found = CALL.fullmatch(text)
    named = found is not None and found[1] in known and found[1] != own
    if named and (text[0].isupper() or text.startswith("galvi.") or not part.startswith("``")):
        return f":py:obj:`{text} <galvi.{found[1]}>`"
    return f"``{text}``"


FILE = Path(__file__).with_name("examples.txt")
HEADING = re.compile(r"^== (\S+) ==$\n", re.MULTILINE)


@cache
def examples() -> dict[str, str]:
    """Name -> lines of an interpreter and what they print; raises ValueError for a name twice."""
    _, *parts = HEADING.split(FILE.read_text(encoding="utf-8"))
    names = parts[::2]
    if len(set(names)) < len(names):
        raise ValueError(f"{FILE.name} has two examples of one name")
    return {name: text.strip() + "\n" for name, text in zip(names, parts[1::2], strict=True)}


TUTORIALS = Path(__file__).parents[2] / "docs" / "tutorials"
CELL = re.compile(r"^```\{code-cell\}\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@cache
def tutorials() -> dict[str, tuple[str, ...]]:
    """Public name -> the tutorials whose code has it, or has what makes it."""
    found: dict[str, tuple[str, ...]] = {}
    for page in sorted(TUTORIALS.glob("*.md")):
        code = "".join(CELL.findall(page.read_text(encoding="utf-8")))
        for name in sorted(set(re.findall(r"\bgalvi\.(problems\.\w+|\w+)", code))):
            found[name] = (*found.get(name, ()), page.stem)
    for made, maker in MADE.items():
        pages = {*found.get(made, ()), *found.get(maker, ())}
        found |= {made: tuple(sorted(pages))} if pages else {}
    return found


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
        (("", ("integrate", "resume", "integrate_many", "Problem", "Trajectory", "Outcome",
              "End", "states_at", "save", "load")),),
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
                            "UniformGravity", "CosinePotential")),
            ("Drag", ("RotorDrag", "QuadraticDrag", "SchillerNaumann")),
            ("On point masses", ("Relativity", "Oblateness", "PowerLaw", "Radiation", "Drag",
                                 "Tides", "Force")),
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
            ("What is kept", ("FinalStates", "StatesAt", "Extrema", "Histogram", "Events")),
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
            ("Order and cost tables", ("convergence",)),
            ("Theory", ("theory", "Theory")),
            ("Checks", ("round_trip_error", "symplecticity_defect", "step_derivative")),
        ),
    ),
)  # fmt: skip

# Values that galvi makes, and what makes them: readers look up their fields.
MADE = {
    "Trajectory": "integrate", "Outcome": "integrate", "Ensemble": "integrate_ensemble",
    "Found": "find_events", "Judged": "judge", "Recommendation": "recommend", "Theory": "theory",
    "MomentumBalance": "momentum_balance", "Citation": "cite",
}  # fmt: skip
SPACE = ("dimension", "basis", "derivative")
SYSTEM = ("momentum", "velocity", "potential_energy")
MEMBERS = {  # those of which users read or call more than the docstring of the class explains
    "Problem": ("p0", "with_initial_state", "body_names"),
    "Trajectory": ("__call__", "velocity", "v", "plot", "to_frame", "to_xarray", "to_scipy",
                   "to_rebound", "outcome", "checkpoint"),
    "Outcome": ("success", "in_doubt", "failed_step"),
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
    """Sphinx's `autodoc-process-docstring`: as reStructuredText, with example and tutorials."""
    short = name.removeprefix("galvi.")
    text = restructured("\n".join(lines), KNOWN, short)
    if short in examples():
        shown = (f"    {line}".rstrip() for line in examples()[short].splitlines())
        text += ["", ".. code-block:: pycon", "", *shown, ""]
    if short in tutorials():
        pages = ", ".join(f":doc:`/tutorials/{page}`" for page in tutorials()[short])
        text += ["", f"In tutorials: {pages}.", ""]
    lines[:] = text


def signature(
    app: Any, what: str, name: str, obj: Any, options: Any, arguments: str | None, result: Any
) -> tuple[str, None] | None:
    """Sphinx's `autodoc-process-signature`: none for a value that galvi makes."""
    if name.removeprefix("galvi.") in MADE:
        return "", None
    return (arguments.replace("<factory>", "..."), None) if arguments else None
