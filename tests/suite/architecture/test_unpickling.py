"""Nothing that travels is unpickled, since loading a pickle runs whatever it says.

Rows, caches, histories, folders of ensembles and saved runs are text or arrays; models of engines
are read by these. What is unpickled comes through a pipe from a process that this one started, or
is code of the user's own that is kept beside the package.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
SOURCES = ("galvi", "references", "benchmarks", "reports")
PICKLERS = r"\b(pickle|_pickle|cPickle|cloudpickle|dill|joblib|marshal|shelve)\b"
UNPICKLES = re.compile(
    rf"{PICKLERS}\.(load|Unpickler|open)|from {PICKLERS} import (?!PicklingError|[Pcd])"
    rf"|import {PICKLERS} as|\.read_pickle|\.recv\(|allow_pickle=(?!False)"
)
ALLOWED = {
    "galvi/interop/rebound.py": "a pipe from the process that reads a file of REBOUND's",
    "galvi/interop/rebound_contents.py": "a pipe from the process that started this one",
    "galvi/kernels/compile/cache.py": "compiled code, in a folder that is the user's own",
    "reports/cli/handed_over.py": "a file of galvi.judge or galvi.convergence, by its digest",
}


def test_what_is_unpickled_is_listed_with_the_reason() -> None:
    files = [path for name in SOURCES for path in (ROOT / name).rglob("*.py")]
    found = [path for path in files if UNPICKLES.search(path.read_text(encoding="utf-8"))]
    assert {path.relative_to(ROOT).as_posix() for path in found} == set(ALLOWED)


@pytest.mark.parametrize(
    "line",
    ["pickle.loads(data)", "read = pickle.Unpickler", "import pickle as p", "shelve.open(path)",
     "from cloudpickle import load", "pd.read_pickle(path)", "connection.recv()",
     "np.load(path, allow_pickle=yes)"],
)  # fmt: skip
def test_unpickling_would_be_noticed(line: str) -> None:
    assert UNPICKLES.search(line)
    assert not UNPICKLES.search("pickle.dumps(data); np.load(path, allow_pickle=False)")
