"""Rules for the sources: frozen values, no pickles that travel, no paths of a machine."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PACKAGES = ("galvi", "references", "benchmarks", "reports")
DATACLASS = re.compile(r"^@dataclass(\(.*\))?\nclass (\w+).*((?:\n(?:[ )].*)?)*)", re.MULTILINE)
ARRAY_FIELD = re.compile(
    r"^    \w+: ((Array|Codes|pd\.DataFrame)( \| None)?( = .*)?|tuple\[Array, .*)$", re.MULTILINE
)
MUTABLE = {  # classes with the state of a search, a measurement or a process
    "Scan", "_Motion", "_Ladder", "_Measurement", "_Measured", "ExternalIntegrator", "TimedRun",
    "BuildCache", "Pair", "Printed", "_Runs", "Runs", "ServedChecks",
}  # fmt: skip
# Loading a pickle runs any code that it names. Rows, caches, histories, folders of ensembles and
# saved runs are text or arrays.
PICKLERS = r"\b(pickle|_pickle|cPickle|cloudpickle|dill|joblib|marshal|shelve)\b"
HARMLESS = r"(?:(?:PicklingError|dumps?|Parallel|cpu_count|delayed)(?:, )?)+$"
UNPICKLES = re.compile(
    rf"{PICKLERS}\.(load|Unpickler|open)|from {PICKLERS} import (?!{HARMLESS})"
    rf"|import {PICKLERS} as|\.read_pickle|\.recv\(|allow_pickle=(?!False)",
    re.MULTILINE,
)
UNPICKLING_FILES = {
    "galvi/interop/rebound.py": "a pipe from the process that reads a file of REBOUND's",
    "galvi/interop/rebound_contents.py": "a pipe from the process that started this one",
    "galvi/kernels/compile/cache.py": "compiled code, in a folder that is the user's own",
    "reports/cli/handed_over.py": "a file of galvi.judge or galvi.convergence, by its digest",
}
NAMES_THAT_SAY_NOTHING = {"utils", "helpers", "common", "base", "misc"}
MACHINE_PATH = re.compile(r"(?<![\w./])/(?:home|root|tmp|work|opt|mnt|Users)/\w|\b[A-Z]:\\Users\b")


@pytest.fixture(scope="module")
def texts() -> dict[Path, str]:
    """The text of every file that git tracks, or would on the next `git add .`, from the root."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    files = [Path(name) for name in listed.split("\0") if name and (ROOT / name).is_file()]
    return {file: (ROOT / file).read_text("utf-8", errors="replace") for file in files}


@pytest.mark.parametrize("package", PACKAGES)
def test_values_are_frozen_and_those_that_hold_arrays_compared_by_identity(
    package: str, texts: dict[Path, str]
) -> None:
    """Arrays are compared entry by entry, so that values with arrays have no equality or hash."""
    package_texts = [text for file, text in texts.items() if file.parts[0] == package]
    dataclasses = [dataclass for text in package_texts for dataclass in DATACLASS.findall(text)]
    assert (
        dataclasses
        and {name for options, name, _ in dataclasses if "frozen=True" not in options} <= MUTABLE
    )
    holders = {name: options for options, name, body in dataclasses if ARRAY_FIELD.search(body)}
    assert holders and [name for name in holders if "eq=False" not in holders[name]] == []


def test_what_is_unpickled_is_listed_with_the_reason(texts: dict[Path, str]) -> None:
    shipped_texts = {
        file: text for file, text in texts.items() if file.parts[0] in (*PACKAGES, "setup.py")
    }
    unpickling = {
        str(file)
        for file in shipped_texts
        if file.suffix == ".py" and UNPICKLES.search(shipped_texts[file])
    }
    assert unpickling == set(UNPICKLING_FILES)


@pytest.mark.parametrize(
    "line",
    [
        "pickle.loads(data)",
        "read = pickle.Unpickler",
        "import pickle as p",
        "shelve.open(path)",
        "from cloudpickle import dumps, load",
        "pd.read_pickle(path)",
        "connection.recv()",
        "np.load(path, allow_pickle=yes)",
    ],
)
def test_unpickling_would_be_noticed(line: str) -> None:
    assert UNPICKLES.search(line)
    assert not UNPICKLES.search("pickle.dumps(data); np.load(path, allow_pickle=False)")


def test_every_folder_of_tests_is_run(texts: dict[Path, str]) -> None:
    settings = tomllib.loads(texts[Path("pyproject.toml")])["tool"]["pytest"]["ini_options"]
    tests = [file for file in texts if file.parts[0] == "tests" and file.name.startswith("test_")]
    assert sorted(settings["testpaths"]) == sorted({str(file.parent) for file in tests})


def test_no_file_or_folder_has_a_name_that_says_nothing(texts: dict[Path, str]) -> None:
    assert [x for x in texts if NAMES_THAT_SAY_NOTHING & {*x.parts[:-1], x.stem}] == []


def test_no_file_names_a_place_on_the_machine_it_was_written_on(texts: dict[Path, str]) -> None:
    assert [file for file, text in texts.items() if MACHINE_PATH.search(text)] == []
    assert MACHINE_PATH.search("cd " + "/".join(["", "home", "someone", "galvi"]))
    assert not MACHINE_PATH.search(
        "see docs/home/index.md, work/precision and https://a.org/home/x"
    )
