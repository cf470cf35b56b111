"""Settings for the whole test suite."""

from __future__ import annotations

import gc
import hashlib
import io
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

# Before numpy is imported: its threads, beside those of other workers, take an eighth longer.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# What needs the kernels that the worker in tests/properties compiles in its first minute, and would
# wait for it: these go to the end.
LATE = (
    "tests/suite/reports/test_contender_",
    "tests/references/test_chains.py",
    "tests/references/test_forces.py",
)

SLOW = 3600  # seconds, of those marked slow; the time-out of others is in pyproject.toml

# The first call of a kernel compiles it, which no deadline of an example should count.
settings.register_profile("galvi", deadline=None, max_examples=25, derandomize=True)
settings.load_profile("galvi")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--without",
        action="append",
        default=[],
        metavar="PACKAGE",
        help="run as where PACKAGE is not installed, but for processes that tests start",
    )


@pytest.hookimpl(tryfirst=True)  # before -m chooses
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: item.nodeid.startswith(LATE))
    for item in items:
        for marker in item.iter_markers("slow_cases"):
            if is_slow(item, marker):
                item.add_marker(pytest.mark.slow)
        if item.get_closest_marker("slow"):
            item.add_marker(pytest.mark.timeout(SLOW))
    if config.getoption("lf", False):
        return  # the other tests of a file are not here
    if not any("[" in word for word in config.args):
        check_slow_cases(items)
    if not any("::" in word for word in config.args):
        check_beside(items, config.rootpath)


def is_slow(item: pytest.Item, marker: pytest.Mark) -> bool:
    """Whether this case of a test is one that the marker names, or none of those it leaves out."""
    case = item.callspec.id  # type: ignore[attr-defined]
    return case in marker.args or ("but" in marker.kwargs and case not in marker.kwargs["but"])


def check_slow_cases(items: list[pytest.Item]) -> None:
    """UsageError where a marker names a case that its test does not have."""
    cases: dict[str, set[str]] = {}
    named: dict[str, set[str]] = {}
    for item in items:
        for marker in item.iter_markers("slow_cases"):
            test = item.nodeid.partition("[")[0]
            cases.setdefault(test, set()).add(item.callspec.id)  # type: ignore[attr-defined]
            named[test] = {*marker.args, *marker.kwargs.get("but", ())}
    for test, names in named.items():
        if lost := sorted(names - cases[test]):
            raise pytest.UsageError(
                f"slow_cases of {test} names {lost[0]!r}, which is no case of it."
            )


def check_beside(items: list[pytest.Item], root: Path) -> None:
    """UsageError where a test is slow in all of its cases and names none that `make test` runs."""
    cases: dict[str, list[pytest.Item]] = {}
    for item in items:
        cases.setdefault(item.nodeid.partition("[")[0], []).append(item)
    left = {test for test, test_cases in cases.items() if not all(map(is_left_out, test_cases))}
    files = {test.partition("::")[0] for test in cases}
    for test, test_cases in cases.items():
        if not all(item.get_closest_marker("slow") for item in test_cases):
            continue
        named = [mark.kwargs.get("beside", "") for mark in test_cases[0].iter_markers("slow")]
        if not any(named):
            raise pytest.UsageError(f"{test} is slow and names no test beside it that is left.")
        test_name = full_name(named[0], test)
        file = test_name.partition("::")[0]
        if test_name not in left and (file in files or not (root / file).is_file()):
            raise pytest.UsageError(
                f"{test} is slow beside {named[0]!r}, which is no test or slow itself."
            )


def is_left_out(item: pytest.Item) -> bool:
    """Whether `make test` does not run it."""
    return any(item.get_closest_marker(name) for name in ("slow", "browser"))


def full_name(name: str, test: str) -> str:
    """Of a test that this one names: alone in its file, with the file in its folder, or whole."""
    file = test.partition("::")[0]
    if "::" not in name:
        return f"{file}::{name}"
    return name if "/" in name else f"{file.rpartition('/')[0]}/{name}"


def pytest_collection_finish() -> None:
    """What all tests share is not looked through for garbage any more, and the rest less often: a
    tenth of the time."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 50)


def pytest_configure(config: pytest.Config) -> None:
    """Importing such a package raises ModuleNotFoundError."""
    modules: dict[str, Any] = sys.modules
    modules.update(dict.fromkeys(config.getoption("without")))


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Ctrl-C raises, also where it was ignored when the tests were started, as nohup does."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def suite_in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """`galvi.judge` and `galvi.convergence` run their commands here, without the seconds that a new
    process imports for."""

    def run_in_process(command: str, arguments: list[str], pickled: bytes = b"") -> Exception:
        from galvi.interop.suite_process import HANDED_OVER, refusal
        from reports.cli.commands import run

        stderr = io.StringIO()
        monkeypatch.setenv(HANDED_OVER, hashlib.sha256(pickled).hexdigest() if pickled else "")
        with redirect_stdout(io.StringIO()), redirect_stderr(stderr):
            status = run(None, [command, *arguments])  # type: ignore[arg-type]
        lines = stderr.getvalue().splitlines()
        message_lines = [line for line in lines if not line.startswith(f"{command}: ")]
        return refusal("\n".join(message_lines), status)

    monkeypatch.setattr("galvi.interop.suite_process.run_command", run_in_process)


@pytest.fixture(autouse=True)
def arithmetic_is_left_alone() -> Iterator[None]:
    """Code of others may make subnormal numbers 0, for all that comes after in the process."""
    yield
    assert sys.float_info.min / 2.0 > 0.0, "subnormal numbers are 0 since this test"
