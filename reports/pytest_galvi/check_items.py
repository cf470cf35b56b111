"""Checks of an integrator as items of pytest, measured by another process.

That process (`galvi.command.serve_checks`) is started by the first request of a process of pytest;
it looks for modules where `galvi verify` does, and then in the folders of pytest's `pythonpath` and
in its root; it runs integrators in processes of their own.
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
END = 10.0  # seconds for the other process to end by itself


class OtherProcess:
    """The process that measures, started with the first request."""

    def __init__(self, config: pytest.Config) -> None:
        self.asked: Mapping[str, Any] = {
            "contenders": list(dict.fromkeys(config.getoption("galvi"))),
            "problems": list(dict.fromkeys(config.getoption("galvi_problem"))),
            "limit": config.getoption("galvi_timeout"),
            "folders": [*_python_path(config), str(config.rootpath)],
        }
        self.folder = config.invocation_params.dir
        self.process: subprocess.Popen[str] | None = None

    def answer(self, request: Mapping[str, Any]) -> Any:
        """The answer of the process.

        Raises
        ------
        UsageError
            For what cannot be loaded, and where it ended.
        """
        requests = [request] if self.process else [self.asked, request]
        process = self.process or self._start()
        with suppress(BrokenPipeError):  # it may have said why it ended
            for message in requests:
                print(json.dumps(message), file=process.stdin, flush=True)
        line = process.stdout.readline()
        if not line:
            self.printed.seek(0)
            last = self.printed.read().strip().rpartition("\n")[2]
            self.close()
            status = process.returncode
            by = f"by the signal {signal.strsignal(-status)!r}" if status < 0 else ""
            check = f"at {title(request)}" if "check" in request else "when it listed the checks"
            raise pytest.UsageError(
                f"--galvi: the process that measures ended {by or f'with status {status}'}, "
                f"{check}. {last}".strip()
            )
        answer = json.loads(line)
        if "usage" in answer:
            self.close()
            raise pytest.UsageError(answer["usage"])
        return answer

    def _start(self) -> subprocess.Popen[str]:
        self.printed = tempfile.TemporaryFile("w+", errors="replace")  # noqa: SIM115
        environment = {key: value for key, value in os.environ.items() if key != "PYTHONWARNINGS"}
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-c", PROGRAM],
            cwd=self.folder,
            env=environment,
            encoding="utf-8",
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.printed,
        )
        return self.process

    def close(self) -> None:
        """End it, and the integrators' processes with it."""
        process, self.process = self.process, None
        if process is None:
            return
        try:
            process.communicate(timeout=END)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
        self.printed.close()


def _python_path(config: pytest.Config) -> list[str]:
    """The folders of the setting `pythonpath`."""
    try:
        return [str(folder) for folder in config.getini("pythonpath")]
    except ValueError:  # pytest's plugin that reads it is switched off
        return []


def title(check: Mapping[str, Any]) -> str:
    """The integrator, the check and its problem, if it has one."""
    return ", ".join(filter(None, (check["name"], check["check"], check["problem"])))


class CheckItem(pytest.Item):
    """A check of an integrator on a problem, or on all."""

    def __init__(self, *, entry: Mapping[str, str], process: OtherProcess, **options: Any) -> None:
        super().__init__(**options)
        self.entry, self.process = entry, process
        self.extra_keyword_matches.add(entry["name"])
        self.add_marker("galvi")

    def runtest(self) -> None:
        """Measure it; a failure shows its sentences alone."""
        try:
            answer = self.process.answer(self.entry)
        except pytest.UsageError as error:
            pytest.fail(str(error), pytrace=False)
        if answer["outcome"] == "skipped":
            pytest.skip(answer["text"])
        if answer["outcome"] == "failed":
            pytest.fail(answer["text"], pytrace=False)

    def reportinfo(self) -> tuple[Any, int | None, str]:
        """(location, None, heading of a failure), where the location is no file."""
        return self.nodeid.partition("::")[0], None, f"{self.entry['name']}: {self.name}"


def items_of(
    session: pytest.Session, listed: Iterable[dict[str, str]], process: OtherProcess
) -> Iterator[CheckItem]:
    """The items of what the other process listed."""
    for entry in listed:
        name = ", ".join(filter(None, (entry["check"], entry["problem"]))).replace("::", ": :")
        parent_id = f"galvi: {entry['name']}".replace("::", ": :")
        yield CheckItem.from_parent(
            session, name=name, nodeid=f"{parent_id}::{name}", entry=entry, process=process
        )
