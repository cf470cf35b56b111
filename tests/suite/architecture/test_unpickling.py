"""Nothing that travels is unpickled, since loading a pickle runs whatever it says.

Rows, caches, histories, folders of ensembles and saved runs are text or arrays; models of engines
are read by these. What is unpickled comes through a pipe from a process that this one started, or
is code of the user's own that is kept beside the package.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
SOURCES = ("galvi", "references", "benchmarks", "reports", "setup.py")
PICKLERS = {"pickle", "_pickle", "cPickle", "cloudpickle", "dill", "joblib", "marshal", "shelve"}
HARMLESS = {  # of these modules
    *("dump", "dumps", "PicklingError"),
    *("Parallel", "cpu_count", "delayed"),  # pipes of processes that this one starts
}
LOADERS = {"read_pickle", "recv"}  # methods of any object: of pandas, and of a connection
ALLOWED = {
    "galvi/interop/rebound.py": "a pipe from the process that reads a file of REBOUND's",
    "galvi/interop/rebound_contents.py": "a pipe from the process that started this one",
    "galvi/kernels/compile/cache.py": "compiled code, in a folder that is the user's own",
    "reports/cli/handed_over.py": "a file of galvi.judge or galvi.convergence, by its digest",
}


def off(node: ast.keyword) -> bool:
    return isinstance(node.value, ast.Constant) and node.value.value is False


def unpickling(text: str) -> Iterator[str]:
    """The expressions of a source that unpickle, or may."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (ast.unparse(node) for alias in node.names
                        if alias.name.partition(".")[0] in PICKLERS and alias.asname)  # fmt: skip
        elif isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] in PICKLERS:
            if not {alias.name for alias in node.names} <= HARMLESS:
                yield ast.unparse(node)
        elif isinstance(node, ast.Attribute):
            owner = ast.unparse(node.value)
            if (owner in PICKLERS and node.attr not in HARMLESS) or node.attr in LOADERS:
                yield ast.unparse(node)
        elif isinstance(node, ast.keyword) and node.arg == "allow_pickle" and not off(node):
            yield ast.unparse(node)


def files() -> Iterator[Path]:
    for name in SOURCES:
        path = ROOT / name
        yield from sorted(path.rglob("*.py")) if path.is_dir() else [path]


def test_what_is_unpickled_is_listed_with_the_reason() -> None:
    places = {
        path.relative_to(ROOT).as_posix(): calls
        for path in files()
        if (calls := list(unpickling(path.read_text(encoding="utf-8"))))
    }
    assert {name: calls for name, calls in places.items() if name not in ALLOWED} == {}
    assert set(ALLOWED) == set(places)  # what unpickles no more leaves the list


@pytest.mark.parametrize(
    "line",
    ["pickle.loads(data)", "read = pickle.Unpickler", "import pickle as p",
     "from cloudpickle import load", "pd.read_pickle(path)", "connection.recv()",
     "np.load(path, allow_pickle=yes)"],
)  # fmt: skip
def test_unpickling_would_be_noticed(line: str) -> None:
    assert len(list(unpickling(line))) == 1
    written = "import pickle; pickle.dumps(data); np.load(path, allow_pickle=False)"
    assert list(unpickling(written)) == []
