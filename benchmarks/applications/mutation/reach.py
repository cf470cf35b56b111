"""Which tests reach a line: by coverage, and for compiled code by what calls it.

A line of Python is reached by the tests that execute it. Compiled lines leave no trace, so that a
kernel's lines count as reached by the tests whose own file imports it, which come first, and those
that execute a line, outside the kernels, that names something of a kernel whose code depends on the
mutated file. What runs when a module is imported, or once for all tests, leaves the trace of the
first test only: after these come those that execute any function of a file that names something of
the mutated one, and those whose own file imports it.
"""

from __future__ import annotations

import ast
import json
import os
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from galvi.kernels.compile import cache

KERNELS = ("galvi/kernels/", "galvi/lanes/")
OF_SOURCES = "tests/suite/architecture/test_sources.py"  # reads all of them
FIRST = 120.0  # seconds of tests at most, the quickest ones first


@dataclass(frozen=True)
class Reach:
    """The tests of a checkout and what they execute.

    Attributes
    ----------
    root
        the sources
    folder
        holds coverage.sqlite and durations.json, written by `recorded`
    """

    root: Path
    folder: Path

    def tests(self, file: str, line: int) -> list[str]:
        """Names of the tests that reach a line, the quickest ones first; then those that may.

        Of a kernel's line, those that import it before all others.
        """
        of_sources = {test for test in self._durations if test.startswith(OF_SOURCES)}
        kernel, at_import = file.startswith(KERNELS), line not in self._bodies(file)
        found = set() if kernel else self._executing(file, self._place(file, line))
        further, files = set(), {file}
        if kernel or at_import or not found:
            callers = dict(self._callers(file))
            found = found.union(*(self._executing(one, at) for one, at in callers.items()))
            further = further.union(*(self._executing(one, self._bodies(one)) for one in callers))
            files |= callers.keys()
        found |= of_sources
        further |= self._importing({self._module(self.root / one) for one in files})
        own = self._importing({self._module(self.root / file)}) if kernel else set()
        groups = own, found - own, further - found - own
        return [test for group in groups for test in self._quickest_first(group)]

    def _importing(self, modules: set[str]) -> set[str]:
        """The tests in files that import one of the modules."""
        files = {file for file, imported in self._imports.items() if modules & imported}
        return {test for test in self._durations if test.partition("::")[0] in files}

    @cached_property
    def _imports(self) -> dict[str, set[str]]:
        """File with tests -> what it imports."""
        return {
            path.relative_to(self.root).as_posix(): _imported(self._source(str(path)))
            for path in (self.root / "tests").rglob("test_*.py")
        }

    def _quickest_first(self, tests: set[str]) -> list[str]:
        known = self._durations
        return sorted(tests & known.keys(), key=lambda test: (known[test], test))

    def chosen(self, tests: list[str]) -> list[str]:
        """The first of these, FIRST seconds of them."""
        spent, kept = 0.0, []
        for test in tests:
            spent += self._durations[test]
            if kept and spent > FIRST:
                break
            kept.append(test)
        return kept

    def duration(self, tests: list[str]) -> float:
        """Seconds that the tests take."""
        return sum(self._durations[test] for test in tests)

    @cached_property
    def _durations(self) -> dict[str, float]:
        return json.loads((self.folder / "durations.json").read_text())

    @cached_property
    def _lines(self) -> dict[str, dict[int, set[str]]]:
        """File -> line -> tests."""
        from coverage.numbits import numbits_to_nums

        found: dict[str, dict[int, set[str]]] = {}
        with sqlite3.connect(self.folder / "coverage.sqlite") as known:
            rows = known.execute(
                "SELECT path, context, numbits FROM line_bits"
                " JOIN file ON file.id = file_id JOIN context ON context.id = context_id"
                " WHERE context != ''"
            )
            for path, context, numbits in rows:
                lines = found.setdefault(Path(path).as_posix(), {})
                for line in numbits_to_nums(numbits):
                    lines.setdefault(line, set()).add(context.partition("|")[0])
        return found

    def _executing(self, file: str, lines: set[int]) -> set[str]:
        known = self._lines.get(file, {})
        return set().union(*(known.get(line, set()) for line in lines), set())

    def _place(self, file: str, line: int) -> set[int]:
        """The line, or the statement around it where a line of its own leaves no trace; all
        functions of the file for a line that runs when it is imported."""
        bodies = self._bodies(file)
        if line not in bodies:
            return bodies or set(self._lines.get(file, {}))
        if self._executing(file, {line}):
            return {line}
        tree = ast.parse(self._source(file))
        around = (_lines(one.lineno, one) for one in ast.walk(tree) if isinstance(one, ast.stmt))
        return min((lines for lines in around if line in lines), key=len)

    def _bodies(self, file: str) -> set[int]:
        """The lines inside functions."""
        tree = ast.parse(self._source(file))
        functions = [node.body for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
        return set().union(*(_lines(body[0].lineno, body[-1]) for body in functions))

    def _source(self, file: str) -> str:
        return (self.root / file).read_text(encoding="utf-8")

    def _callers(self, compiled: str) -> Iterator[tuple[str, set[int]]]:
        """File -> lines that name something of a kernel that may call this one, outside of them.

        Of another compiled file: lines that name something of it.
        """
        path, kernel = self.root / compiled, compiled.startswith(KERNELS)
        folders = KERNELS if kernel else ()
        kernels = (one for top in folders for one in (self.root / top).rglob("*.py"))
        above = {self._module(one) for one in kernels if path in cache.sources(str(one))}
        above = above or {self._module(path)}
        packages = {module.rpartition(".")[0] for module in above}
        for folder in ("galvi",) if kernel else ("galvi", "references", "benchmarks"):
            for one in sorted((self.root / folder).rglob("*.py")):
                file, text = one.relative_to(self.root).as_posix(), self._source(str(one))
                if not file.startswith(KERNELS) and any(x in text for x in packages):
                    lines = _lines_with_names_of(above, text)
                    if lines:
                        yield file, lines

    def _module(self, path: Path) -> str:
        name = path.relative_to(self.root).with_suffix("").as_posix().replace("/", ".")
        return name.removesuffix(".__init__")


def _lines(first: int, last: ast.stmt) -> set[int]:
    return set(range(first, (last.end_lineno or 0) + 1))


def _imported(text: str) -> set[str]:
    """Dotted names of what a file imports, and of what it imports that from."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom):
            found |= {str(node.module), *(f"{node.module}.{one.name}" for one in node.names)}
    return found


def _lines_with_names_of(modules: set[str], text: str) -> set[int]:
    """The lines that use what is imported from the modules; all where a string imports it."""
    tree = ast.parse(text)
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            for one in node.names:
                if {node.module, f"{node.module}.{one.name}"} & modules:
                    names.add(one.asname or one.name)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            named = set(re.findall(r"from (galvi\.kernels[\w.]*) import", node.value))
            if named & modules:
                return set(range(1, len(text.splitlines()) + 1))
    return {
        node.lineno for node in ast.walk(tree) if isinstance(node, ast.Name) and node.id in names
    }


def copied(root: Path, copy: Path, how: Callable[..., object] = shutil.copy2) -> Path:
    """The sources and compiled kernels of a checkout, in another place.

    Parameters
    ----------
    how
        of a file: `os.link` takes a tenth of the time, and what is written anew is the copy's own

    Notes
    -----
    Locks are left out: linked, one copy would wait for another.
    """

    def left_out(folder: str, names: list[str]) -> set[str]:
        top = {".git", ".venv", "build", "dist"} if Path(folder) == root else {"out"}
        endings = "_cache", ".egg-info", ".lock"
        return {one for one in names if one in top or one.endswith(endings)}

    return Path(shutil.copytree(root, copy, ignore=left_out, copy_function=how))


def in_copy(copy: Path) -> dict[str, str]:
    """The environment of tests in a copy."""
    places = os.pathsep.join(filter(None, (str(copy), os.environ.get("PYTHONPATH"))))
    return {**os.environ, "PYTHONPATH": places, "HYPOTHESIS_STORAGE_DIRECTORY": str(copy)}


def recorded(root: Path, folder: Path, tests: tuple[str, ...] = ("tests",)) -> Reach:
    """Run the tests once under coverage, in a copy as of a mutant, in about twice their time.

    What fails there without a fault finds none, and is left out.

    Raises
    ------
    RuntimeError
        When the tests do not run.
    """
    folder = folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    settings, data = folder / "coverage.ini", folder / "coverage.sqlite"
    settings.write_text(
        f"[run]\nsource = galvi,references,benchmarks\nrelative_files = true\ndata_file = {data}\n"
    )
    with tempfile.TemporaryDirectory(prefix="galvi-mutant-") as place:
        copy = copied(root, Path(place) / "sources")
        done = subprocess.run(
            [
                sys.executable, "-m", "pytest", "-n", "2", "--dist", "worksteal", "-q",
                "-p", "no:cacheprovider", "--cov", "--cov-context=test", f"--cov-config={settings}",
                "--cov-report=", f"--junitxml={folder / 'tests.xml'}", "-o", "junit_family=xunit1",
                *tests,
            ],
            cwd=copy, env=in_copy(copy), capture_output=True, text=True,
        )  # fmt: skip
    if done.returncode not in (0, 1):
        raise RuntimeError(f"the tests do not run: {done.stdout[-2000:]}")
    write_durations(folder)
    return Reach(root, folder)


def write_durations(folder: Path) -> None:
    """durations.json from tests.xml: name of a test that passed -> seconds."""
    from xml.etree import ElementTree

    found = {}
    for case in ElementTree.parse(folder / "tests.xml").iter("testcase"):
        if not {part.tag for part in case} & {"failure", "error", "skipped"}:
            name = f"{case.get('file')}::{case.get('name')}"
            found[name] = float(case.get("time") or 0.0)
    (folder / "durations.json").write_text(json.dumps(found))
