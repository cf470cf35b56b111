"""Numbers of a system that differ from member to member, by name.

A name is that of a field of the system, its potential, force or Lagrangian, e.g. "masses", "mu" or
"factor", of a parameter of a SymPy expression, or for a tree an argument of
`Multibody.with_numbers`. The system of a member is made from the problem's with these numbers
replaced, so that all checks of a system are made.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.ensembles.member_laws import Law, LawNumbers, law_of
from galvi.input_checks import shown
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.multibody import Multibody
from galvi.tracing.from_sympy import SymbolicForce
from galvi.tracing.symbolic_lagrangian import SymbolicLagrangian

SYMBOLIC = (SymbolicLagrangian, SymbolicForce)
Path = tuple[str, ...]  # names of fields, from the system to a number or a parameter of SYMBOLIC


def check_parameters(parameters: Any) -> dict[str, Array]:
    """The arrays of a dict of names and arrays, or of None; TypeError or ValueError for others."""
    if parameters is None:
        return {}
    if not isinstance(parameters, Mapping):
        raise TypeError(
            f"parameters must be a dict of names and arrays; received {shown(parameters)}."
        )
    return {
        name: input_checks.array(f"parameters[{shown(name)}]", values)
        for name, values in parameters.items()
    }


class Parameters:
    """The parameters of n members: name -> values (n, ...)."""

    def __init__(self, problem: Problem, values: Mapping[str, Array], members: int) -> None:
        self.problem, self.members, self.values = problem, members, dict[str, Array]()
        self.places = _paths_by_name(problem.system)
        for name, array in values.items():
            if name not in self.places:
                names = ", ".join(sorted(self.places)) or "none"
                raise ValueError(
                    f"parameters must be named as fields of the system are, or as the parameters "
                    f"of its expression: {names}; received {shown(name)}."
                )
            if array.ndim == 0 or len(array) != members:
                raise ValueError(
                    f"parameter {name!r} must have one value for each of the {members} members; "
                    f"received shape {array.shape}."
                )
            for path in self.places[name]:
                shape = self._shape(path)
                if shape is not None and array.shape[1:] != shape:
                    raise ValueError(
                        f"parameter {name!r} must have shape {(members, *shape)}, the members "
                        f"in front; received {array.shape}."
                    )
            self.values[name] = array
        if isinstance(problem.system, Multibody) and self.values:  # so that all have one law
            first_values = {name: values[0] for name, values in self.values.items()}
            self.problem = replace(problem, system=problem.system.with_numbers(**first_values))

    def _shape(self, path: Path) -> tuple[int, ...] | None:
        """The shape that one member's value must have; None where the field is a number, which may
        also become an array."""
        owner = _part_at(self.problem.system, path[:-1])
        if isinstance(owner, SYMBOLIC):
            return ()
        if isinstance(owner, Multibody):
            return owner.shape_of(path[-1])
        return np.shape(getattr(owner, path[-1])) or None

    def check(self) -> None:
        """ValueError, with a note that names the member, for values that a system refuses."""
        for member in range(self.members if self.values else 0):
            self._checked_system(member)

    def _checked_system(self, member: int) -> Any:
        try:
            return self.system(member)
        except ValueError as error:
            error.add_note(f"This was member {member}.")
            raise

    def system(self, member: int) -> Any:
        """The system of one member."""
        system: Any = self.problem.system
        for name, values in self.values.items():
            value = values[member]
            for path in self.places[name]:
                system = _replace_number(system, path, float(value) if value.ndim == 0 else value)
        if self.values and isinstance(system, Canonical | Lagrangian):
            system.trace(self.problem.q0, self.problem.v0, self.problem.t0)
        return system

    def numbers(self, law: Law, problem_numbers: LawNumbers) -> LawNumbers:
        """The numbers of the law for the members; ``problem_numbers`` are those of the problem.

        Raises
        ------
        ValueError
            With a note that names the member, for a value that a system refuses.
        """
        by_name = self.values
        if not by_name:
            return problem_numbers
        if self._symbolic_only():
            return self._symbolic_numbers(problem_numbers)
        rows = np.concatenate(
            [values.reshape(len(values), -1) for values in by_name.values()], axis=1
        )
        _, first, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        member_numbers = []
        for k in first:
            law_and_numbers = law_of(self._checked_system(int(k)), law.dimension)
            if law_and_numbers is None or law_and_numbers[0].lines != law.lines:
                raise ValueError(
                    f"the parameters of member {k} give another law than the problem's; "
                    f"received {[values[k].tolist() for values in by_name.values()]}."
                )
            member_numbers.append(law_and_numbers[1])
        indices = inverse.ravel()
        constants = np.concatenate([numbers.constants for numbers in member_numbers])[indices]
        if problem_numbers.mass is None:
            return LawNumbers(constants)
        masses = [numbers.mass for numbers in member_numbers if numbers.mass is not None]
        return LawNumbers(constants, np.concatenate(masses)[indices])

    def _symbolic_only(self) -> bool:
        return all(
            isinstance(_part_at(self.problem.system, path[:-1]), SYMBOLIC)
            for name in self.values
            for path in self.places[name]
        )

    def _symbolic_numbers(self, problem_numbers: LawNumbers) -> LawNumbers:
        """The numbers of a law from SymPy: its parameters, then those of its force."""
        system: Any = self.problem.system
        constants = np.tile(problem_numbers.constants, (self.members, 1))
        first = 0
        for part in (system.function, system.force):
            if isinstance(part, SYMBOLIC):
                for name, values in self.values.items():
                    if name in part.names:
                        constants[:, first + part.names.index(name)] = values
                first += len(part.constants)
        return LawNumbers(constants)


def _paths_by_name(system: Any) -> dict[str, list[Path]]:
    """The paths of each name in a system."""
    paths: dict[str, list[Path]] = {}
    for path in _paths(system, ()):
        paths.setdefault(path[-1], []).append(path)
    return paths


def _paths(value: Any, path: Path) -> Iterator[Path]:
    if isinstance(value, (*SYMBOLIC, Multibody)):
        names = value.varied_names if isinstance(value, Multibody) else value.names
        yield from ((*path, name) for name in names)
        return
    for field in fields(value):
        content = getattr(value, field.name)
        if is_dataclass(content) and not isinstance(content, type):
            yield from _paths(content, (*path, field.name))
        elif _is_numbers(content):
            yield (*path, field.name)


def _is_numbers(value: Any) -> bool:
    if isinstance(value, bool | np.bool_ | str) or callable(value) or value is None:
        return False
    return np.asarray(value).dtype.kind in "iuf"


def _part_at(value: Any, path: Path) -> Any:
    for name in path:
        value = getattr(value, name)
    return value


def _replace_number(value: Any, path: Path, number: Any) -> Any:
    """The value with one of its numbers replaced."""
    name, *inner_path = path
    if isinstance(value, SYMBOLIC):
        constants = list(value.constants)
        constants[value.names.index(name)] = number
        return replace(value, constants=tuple(constants))
    if isinstance(value, Multibody):
        return value.with_numbers(**{name: number})
    content = (
        number
        if not inner_path
        else _replace_number(getattr(value, name), tuple(inner_path), number)
    )
    return replace(value, **{name: content})


def starts_of(
    problem: Problem, q0: Any, v0: Any, step: Any, parameters: dict[str, Array]
) -> tuple[Array, Array, Array]:
    """Configurations (n, ...), velocities (n, ...) and steps (n,) of all members."""
    arguments: Any = {
        "q0": (q0, problem.q0.shape),
        "v0": (v0, problem.v0.shape),
        "step": (step, ()),
    }
    arrays = {name: input_checks.array(name, value) for name, (value, _) in arguments.items()}
    counts = {}
    for name, (_, shape) in arguments.items():
        array = arrays[name]
        if array.shape == shape:
            continue
        if array.shape[1:] != shape or array.ndim != len(shape) + 1 or not len(array):
            raise ValueError(
                f"{name} must have shape (members, {', '.join(map(str, shape))}), or "
                f"{shape} for all members; received {array.shape}."
            )
        counts[name] = len(array)
    for name, values in parameters.items():
        counts[f"parameters[{name!r}]"] = len(np.atleast_1d(values))
    if len(set(counts.values())) > 1:
        received = ", ".join(f"{count} of {name}" for name, count in counts.items())
        raise ValueError(
            f"q0, v0, step and parameters must have the same number of members; "
            f"received {received}."
        )
    if np.any(arrays["step"] == 0.0):
        raise ValueError("step must not be zero; received 0. Give the step size in units of time.")
    members = max(counts.values(), default=1)
    q, v, h = (
        np.broadcast_to(arrays[name], (members, *shape)) for name, (_, shape) in arguments.items()
    )
    group = getattr(problem.system, "group", None)
    if group is not None and q[0].ndim == 2:
        for k, g in enumerate(q):
            group.check(f"q0[{k}]", g)
    return q, v, read_only(np.array(h))
