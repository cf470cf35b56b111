"""Checks of an integrator as items of pytest, measured by another process.

The first request starts that process (`galvi.command.serve_checks`). It imports modules from where
`galvi verify` does, then from the folders of pytest's `pythonpath` and from its root, and runs
integrators in further processes.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any

import pytest

PROGRAM = "from galvi.command import serve_checks; serve_checks()"
END_SECONDS = 10.0  # seconds after which the other process is killed


class OtherProcess:
    """The process that measures; the first request starts it."""

    def __init__(self, config: pytest.Config) -> None:
        self.settings: Mapping[str, Any] = {
            "contenders": list(dict.fromkeys(config.getoption("galvi"))),
            "problems": list(dict.fromkeys(config.getoption("galvi_problem"))),
            "limit": config.getoption("galvi_timeout"),
            "folders": [*_python_path(config), str(config.rootpath)],
        }
        self.folder = config.invocation_params.dir
        self.process: subprocess.Popen[str] | None = None

    def answer(self, request: Mapping[str, Any]) -> Any:
        """Send a request to the process; returns its answer.

        Raises
        ------
        UsageError
            If an integrator or a problem cannot be loaded, and if the process ended.
        """
        requests = [request] if self.process else [self.settings, request]
        process = self.process or self._start()
        with suppress(BrokenPipeError):  # if it has ended, its last output says why
            for message in requests:
                print(json.dumps(message), file=process.stdin, flush=True)
        line = process.stdout.readline()
        if not line:
            self.stderr_file.seek(0)
            last_line = self.stderr_file.read().strip().rpartition("\n")[2]
            self.close()
            status = process.returncode
            signal_text = f"by the signal {signal.strsignal(-status)!r}" if status < 0 else ""
            check = f"at {title(request)}" if "check" in request else "when it listed the checks"
            raise pytest.UsageError(
                "--galvi: the process that measures ended "
                f"{signal_text or f'with status {status}'}, "
                f"{check}. {last_line}".strip()
            )
        answer = json.loads(line)
        if "usage" in answer:
            self.close()
            raise pytest.UsageError(answer["usage"])
        return answer

    def _start(self) -> subprocess.Popen[str]:
        self.stderr_file = tempfile.TemporaryFile("w+", errors="replace")  # noqa: SIM115
        environment = {key: value for key, value in os.environ.items() if key != "PYTHONWARNINGS"}
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-c", PROGRAM],
            cwd=self.folder,
            env=environment,
            encoding="utf-8",
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.stderr_file,
        )
        return self.process

    def close(self) -> None:
        """End the process, and with it those of the integrators."""
        process, self.process = self.process, None
        if process is None:
            return
        try:
            process.communicate(timeout=END_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
        self.stderr_file.close()


def _python_path(config: pytest.Config) -> list[str]:
    """The folders of pytest's setting `pythonpath`."""
    try:
        return [str(folder) for folder in config.getini("pythonpath")]
    except ValueError:  # pytest's plugin that reads it is switched off
        return []


def title(check: Mapping[str, Any]) -> str:
    """The names of the integrator, the check and, if there is one, the problem."""
    return ", ".join(filter(None, (check["name"], check["check"], check["problem"])))


class CheckItem(pytest.Item):
    """A check of an integrator on one problem or on all of them."""

    def __init__(self, *, entry: Mapping[str, str], process: OtherProcess, **options: Any) -> None:
        super().__init__(**options)
        self.entry, self.process = entry, process
        self.extra_keyword_matches.add(entry["name"])
        self.add_marker("galvi")

    def runtest(self) -> None:
        """Measure the check; a failure shows its sentences without a traceback."""
        try:
            answer = self.process.answer(self.entry)
        except pytest.UsageError as error:
            pytest.fail(str(error), pytrace=False)
        if answer["outcome"] == "skipped":
            pytest.skip(answer["text"])
        if answer["outcome"] == "failed":
            pytest.fail(answer["text"], pytrace=False)

    def reportinfo(self) -> tuple[Any, int | None, str]:
        """(location, None, heading of a failure); the location is a text, not a file."""
        return self.nodeid.partition("::")[0], None, f"{self.entry['name']}: {self.name}"


def items_of(
    session: pytest.Session, listed: Iterable[dict[str, str]], process: OtherProcess
) -> Iterator[CheckItem]:
    """An item for each check that the other process listed."""
    for entry in listed:
        name = ", ".join(filter(None, (entry["check"], entry["problem"]))).replace("::", ": :")
        parent_id = f"galvi: {entry['name']}".replace("::", ": :")
        yield CheckItem.from_parent(
            session, name=name, nodeid=f"{parent_id}::{name}", entry=entry, process=process
        )
