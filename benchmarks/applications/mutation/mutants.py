"""Sources with one small fault: the operators are cosmic-ray's, the sample is drawn here."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

NUMBERS = "NumberReplacer"
# Of cosmic-ray's operators, those whose mutants are not found by the first call of the line.
OPERATORS = tuple(
    f"core/{name}"
    for name in (
        "AddNot",
        NUMBERS,
        "ReplaceAndWithOr",
        "ReplaceBinaryOperator_Add_Sub",
        "ReplaceBinaryOperator_Div_Mul",
        "ReplaceBinaryOperator_FloorDiv_Mul",
        "ReplaceBinaryOperator_Mod_Sub",
        "ReplaceBinaryOperator_Mul_Div",
        "ReplaceBinaryOperator_Pow_Mul",
        "ReplaceBinaryOperator_Sub_Add",
        "ReplaceBreakWithContinue",
        "ReplaceComparisonOperator_Eq_NotEq",
        "ReplaceComparisonOperator_GtE_Gt",
        "ReplaceComparisonOperator_GtE_Lt",
        "ReplaceComparisonOperator_Gt_GtE",
        "ReplaceComparisonOperator_Gt_LtE",
        "ReplaceComparisonOperator_LtE_Gt",
        "ReplaceComparisonOperator_LtE_Lt",
        "ReplaceComparisonOperator_Lt_GtE",
        "ReplaceComparisonOperator_Lt_LtE",
        "ReplaceComparisonOperator_NotEq_Eq",
        "ReplaceContinueWithBreak",
        "ReplaceFalseWithTrue",
        "ReplaceOrWithAnd",
        "ReplaceTrueWithFalse",
        "ReplaceUnaryOperator_Delete_Not",
        "ReplaceUnaryOperator_Delete_USub",
        "ZeroIterationForLoop",
    )
)


@dataclass(frozen=True)
class Mutant:
    """One fault.

    file        path from the root of the sources
    operator    name of cosmic-ray's operator
    occurrence  which of the operator's places in the file
    line        number of the line, from 1
    before      the line, and what the fault makes of it, without indentation
    after
    code        digest of the file, the operator and the occurrence
    """

    file: str
    operator: str
    occurrence: int
    line: int
    before: str
    after: str
    code: str

    def source(self, root: Path) -> str:
        """The file with the fault."""
        return _mutated(
            (root / self.file).read_text(encoding="utf-8"), self.operator, self.occurrence
        )

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.before}  ->  {self.after}"


def sampled(
    root: Path, folders: tuple[str, ...], count: int, seed: int, without: Collection[str] = ()
) -> list[Mutant]:
    """``count`` mutants of the Python files in the folders, each folder by its lines of code.

    Parameters
    ----------
    without
        folders that are left out

    Raises
    ------
    ModuleNotFoundError
        Without cosmic-ray.

    Notes
    -----
    The mutants of a folder are those whose digests with the seed are least, so that an edit changes
    the sample in its own file only.
    """
    rooms: dict[Path, list[Path]] = {}
    for folder in folders:
        for path in sorted((root / folder).rglob("*.py")):
            if path.parent.relative_to(root).as_posix() not in without:
                rooms.setdefault(path.parent, []).append(path)
    lines = {room: sum(_code_lines(path) for path in files) for room, files in rooms.items()}
    total, found, owed = sum(lines.values()), [], 0.0
    for room, files in rooms.items():
        owed += count * lines[room] / total
        wanted = round(owed) - len(found)
        keys = sorted(
            (
                hashlib.sha256(f"{seed} {path.relative_to(root)} {place}".encode()).hexdigest(),
                path,
                place,
            )
            for path in files
            for place in _places(path)
        )
        valid = (_mutant(root, path, *place) for _, path, place in keys)
        found += islice((one for one in valid if one), wanted)
    return found


def _mutant(root: Path, path: Path, operator: str, occurrence: int, line: int) -> Mutant | None:
    """None where the operator makes what is no Python, as of `{**a, **b}`."""
    text = path.read_text(encoding="utf-8")
    changed = _mutated(text, operator, occurrence)
    try:
        ast.parse(changed)
    except SyntaxError:
        return None
    before, after = _difference(text.splitlines(), changed.splitlines())
    code = hashlib.sha256(f"{text}{operator}{occurrence}".encode()).hexdigest()[:16]
    file = path.relative_to(root).as_posix()
    return Mutant(file, operator, occurrence, line, before, after, code)


def _difference(old: list[str], new: list[str]) -> tuple[str, str]:
    """The lines that differ, each side as one: a number on a new line may lose its indentation."""
    same = next(k for k, (a, b) in enumerate(zip(old, new, strict=False)) if a != b)
    rest = len(old) - len(new)
    last = next(
        k for k in range(len(old), same, -1) if k == same + 1 or old[k - 1] != new[k - 1 - rest]
    )
    before, after = old[same:last], new[same : last - rest]
    return " ".join(map(str.strip, before)), " ".join(map(str.strip, after))


def _mutated(text: str, operator: str, occurrence: int) -> str:
    from cosmic_ray.mutating import mutate_code

    return str(mutate_code(text, _operator(operator), occurrence))


@cache
def _operator(name: str) -> Any:
    from cosmic_ray.plugins import get_operator

    return get_operator(name)()


def _places(path: Path) -> Iterator[tuple[str, int, int]]:
    """Operator, occurrence and line of each mutant; what is not executed is left out."""
    from cosmic_ray.ast import get_ast

    text = path.read_text(encoding="utf-8")
    idle = _not_executed(ast.parse(text))
    nodes = list(_nodes(get_ast(text)))
    for name in OPERATORS:
        places = [at for node in nodes for at in _operator(name).mutation_positions(node)]
        for occurrence, ((line, column), _) in enumerate(places):
            skipped = name.endswith(NUMBERS) and occurrence % 4 not in (
                0,
                3,
            )  # one up, the next down
            if not skipped and not any(first <= (line, column) < last for first, last in idle):
                yield name, occurrence, line


def _nodes(node: Any) -> Iterator[Any]:
    """The nodes in the order in which cosmic-ray counts occurrences."""
    yield node
    for child in getattr(node, "children", ()):
        yield from _nodes(child)


def _not_executed(tree: ast.Module) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Where annotations begin and end."""
    found: list[Any] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.arg | ast.AnnAssign):
            found.append(node.annotation)
        elif isinstance(node, ast.FunctionDef):
            found.append(node.returns)
    return [
        ((one.lineno, one.col_offset), (one.end_lineno, one.end_col_offset)) for one in found if one
    ]


def _code_lines(path: Path) -> int:
    """Lines that hold a statement or a part of one, docstrings left out."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    held: set[int] = set()
    for node in ast.walk(tree):
        text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if (
            isinstance(node, ast.stmt)
            and not text
            and not isinstance(node, ast.FunctionDef | ast.ClassDef)
        ):
            held.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return len(held)
