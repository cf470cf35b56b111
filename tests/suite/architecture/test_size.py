"""The code stays within the sizes of CONTRIBUTING.md."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[3]
FOLDERS = ("galvi", "references", "benchmarks", "reports", "tests")
KERNELS = ("galvi/kernels/", "galvi/lanes/")  # their arguments are not grouped
FUNCTION = (ast.FunctionDef, ast.AsyncFunctionDef)
# They say that something was computed, not what it is.
EMPTY_NAME = re.compile(
    "_*(?:alone|apart|asked|data|done|each|every|far|found|given|heirs|here|info|kept|kit|known|least"
    "|made|mine|more|most|near|nothing|obj|one|others?|ours|own|placed?|res|rest|results?|room|said"
    "|seen|sound|taken|theirs|there|things?|tmp|told|tried|ways|what|whole|words)_*"
)
LIMIT = re.compile(r"^\| (.+?) \| ([\d,]+) \|$", re.MULTILINE)


def is_statement(node: ast.AST) -> bool:
    """Whether the node is a statement other than a docstring."""
    if not isinstance(node, ast.stmt):
        return False
    return not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))


def parameters(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """The number of parameters without self and cls."""
    declared = function.args
    named = (*declared.posonlyargs, *declared.args, *declared.kwonlyargs)
    names = [parameter.arg for parameter in named]
    return len(names) - (names[:1] in (["self"], ["cls"]))


def lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """The number of lines without those of the docstring."""
    first, last = function.body[0], function.end_lineno or 0
    docstring = 0 if is_statement(first) else (first.end_lineno or 0) - first.lineno + 1
    return last - function.lineno + 1 - docstring


def new_name(node: ast.AST) -> str:
    """The name that a node assigns, declares as a parameter or defines; "" for another node."""
    if isinstance(node, ast.Name):
        return node.id if isinstance(node.ctx, ast.Store) else ""
    if isinstance(node, ast.arg):
        return node.arg
    return node.name if isinstance(node, (*FUNCTION, ast.ClassDef)) else ""


def writes_elsewhere(node: ast.stmt) -> bool:
    """Whether a statement of a module fills what another one defined, when it is imported."""
    if isinstance(node, ast.Assign):
        return isinstance(node.targets[0], ast.Subscript | ast.Attribute)
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)


def measured(files: Iterator[tuple[str, str]]) -> Counter[str]:
    """Sizes by rows of CONTRIBUTING.md's table; `files` yields (path, text)."""
    sizes: Counter[str] = Counter()
    for path, text in files:
        tree = ast.parse(text)
        statements = [node for node in ast.walk(tree) if is_statement(node)]
        sizes[f"statements in `{path.split('/')[0]}/`"] += len(statements)
        names = [name for node in ast.walk(tree) if EMPTY_NAME.fullmatch(name := new_name(node))]
        sizes["names that say nothing"] += len(names)
        sizes["exceptions from the formatter"] += len(
            re.findall("# fmt: (?:skip|off)$", text, re.M)
        )
        for node in statements:
            if isinstance(node, FUNCTION):
                allowed = 14 if path.startswith(KERNELS) else 10
                sizes["functions of more than 80 lines"] += lines(node) > 80
                sizes["functions with too many parameters"] += parameters(node) > allowed
        if path.startswith("galvi/") and not path.startswith(KERNELS):
            sizes["statements that write into another module at import"] += sum(
                map(writes_elsewhere, tree.body)
            )
    return sizes


def sources() -> Iterator[tuple[str, str]]:
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            if not path.is_relative_to(ROOT / "reports/out"):
                yield path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")


def limits() -> dict[str, int]:
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    section = page.partition("\n## Size\n")[2].partition("\n## ")[0]
    return {name: int(number.replace(",", "")) for name, number in LIMIT.findall(section)}


def test_nothing_is_larger_than_contributing_allows() -> None:
    sizes = measured(sources())
    assert set(sizes) == set(limits())
    larger = {name: (size, limits()[name]) for name, size in sizes.items() if size > limits()[name]}
    assert larger == {}, "larger than CONTRIBUTING.md allows: (size, limit)"


def test_what_is_larger_is_counted() -> None:
    """Planted: a long function with many parameters, writes into another module, vague names."""
    names = ", ".join(f"a{k}" for k in range(11))
    source = f"def f(self, {names}):\n" + "    '''Text.'''\n" + "    pass\n" * 80
    files = {
        "galvi/a.py": source,
        "galvi/b.py": "c.x = 1\nc['y'] = 1\nc.append(1)\n",
        "galvi/c.py": "def kept(one, two):\n    found_ = two  # fmt: skip\n    return found_\n",
    }
    assert measured(iter(files.items())) == {
        "statements in `galvi/`": 87,
        "names that say nothing": 3,
        "exceptions from the formatter": 1,
        "functions of more than 80 lines": 1,
        "functions with too many parameters": 1,
        "statements that write into another module at import": 3,
    }
