"""How commands end that cannot be carried out: status 2 and a sentence, whatever was raised."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path
from threading import Timer

import pandas as pd
import pytest
import typer

import galvi
from galvi.command import main
from reports.cli.commands import run

ROOT = Path(__file__).parents[3]
FULL_DISK = OSError(errno.ENOSPC, "No space left on device", "claims.csv")


class Wordless(Exception):
    def __str__(self):
        raise RuntimeError("no words")


RAISED = (
    Wordless(),
    ImportError("numpy.dtype size changed"),
    RuntimeError("two\nlines"),
    KeyError("samples"),
    MemoryError(),
    RecursionError("maximum recursion depth exceeded"),
    EOFError("Ran out of input"),
    UnicodeEncodeError("ascii", "…", 0, 1, "ordinal not in range"),
    BrokenPipeError(errno.EPIPE, "of a worker"),
    SystemExit(0),
    FULL_DISK,
)


def raising(error: BaseException):
    def load():
        raise error

    return load


@pytest.mark.parametrize("error", RAISED, ids=lambda error: type(error).__name__)
def test_what_nobody_caught_is_no_verdict(error, tmp_path, capsys):
    assert run(raising(error), ["verify", "--out", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("The command could not be carried out: ")
    assert type(error).__name__ in line


def test_control_characters_of_an_exception_are_escaped(tmp_path, capsys):
    assert run(raising(ValueError("red \x1b[31m")), ["verify", "--out", str(tmp_path)]) == 2
    assert "ValueError: red \\x1b[31m." in capsys.readouterr().err


def test_a_full_disk_is_named(make_suite, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("reports.build.verify.write", lambda *given: raising(FULL_DISK)())
    assert run(make_suite, ["verify", "--out", str(tmp_path)]) == 2
    *_, line = capsys.readouterr().err.splitlines()
    assert "No space left on device: 'claims.csv'. " in line


def test_a_package_that_is_missing_is_named_with_what_installs_it(tmp_path, capsys):
    error = ModuleNotFoundError("No module named 'pebble'", name="pebble")
    assert run(raising(error), ["verify", "--out", str(tmp_path)]) == 3
    (line,) = capsys.readouterr().err.splitlines()
    assert "pebble is not installed. Install them: pip install 'galvi[suite]'." in line


def test_what_cannot_be_imported_is_no_verdict(monkeypatch, capsys):
    monkeypatch.setattr(sys, "path", list(sys.path))
    broken = ImportError("undefined symbol: x")
    monkeypatch.setattr("runpy.run_module", lambda *given, **more: raising(broken)())
    assert main() == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "cannot be imported: undefined symbol: x." in line


def test_an_abort_is_an_interrupt(tmp_path, capsys):
    assert run(raising(typer.Abort()), ["verify", "--out", str(tmp_path)]) == 130


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_during_a_run_of_galvi_ends_the_command(make_suite, tmp_path):
    orbit = galvi.problems.kepler(0.6)
    method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    galvi.integrate(orbit, method, 0.1, 1)  # compiles the kernel

    def cost(quick, report):
        Timer(0.3, os.kill, [os.getpid(), signal.SIGINT]).start()
        run = galvi.integrate(orbit, method, 0.1, 10**8, save_every=10**6)
        return pd.DataFrame({"status": [run.status]})

    handler = signal.getsignal(signal.SIGINT)
    suite = make_suite(cost=cost)
    assert run(lambda: suite, ["compare", "--out", str(tmp_path)]) == 130
    assert signal.getsignal(signal.SIGINT) is handler
    assert not (tmp_path / "cost.csv").exists()


def test_where_it_was_raised_is_shown_where_asked_for(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("GALVI_TRACEBACK", "1")
    assert run(raising(KeyError("samples")), ["verify", "--out", str(tmp_path)]) == 2
    *lines, last = capsys.readouterr().err.splitlines()
    assert lines[0].startswith("Traceback") and any("in load" in line for line in lines)
    assert last.startswith("The command could not be carried out: KeyError: 'samples'.")


def ended(action: str, **options) -> subprocess.CompletedProcess[str]:
    """A command that does this, in a process of its own."""
    code = (
        "import sys\nfrom reports.cli.endings import ended\n"
        f"def command():\n    {action}\n    return 0\nsys.exit(ended(command))"
    )
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "env": {}, **options}
    environment = {**os.environ, "PYTHONUNBUFFERED": "", **options.pop("env")}
    command = [sys.executable, "-c", code]
    return subprocess.run(command, cwd=ROOT, text=True, env=environment, **options)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_standard_output_that_is_full_is_a_full_disk():
    with open("/dev/full", "w") as full:
        done = ended("print('a verdict')", stdout=full)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "OSError: [Errno 28] No space left on device. " in line


@pytest.mark.parametrize(
    ("stream", "unbuffered"), [("stdout", ""), ("stdout", "1"), ("stderr", "")]
)
def test_output_that_nobody_reads_ends_a_command_quietly(stream, unbuffered):
    reader, writer = os.pipe()
    os.close(reader)
    with open(writer, "w") as gone:
        environment = {"PYTHONUNBUFFERED": unbuffered}
        printed = f"print('a line\\n' * 10_000, file=sys.{stream})"
        done = ended(printed, env=environment, **{stream: gone})
    assert done.returncode == 141 and not (done.stdout or done.stderr)


def test_a_table_of_rich_that_nobody_reads_ends_a_command_quietly():
    reader, writer = os.pipe()
    os.close(reader)
    with open(writer, "w") as gone:
        done = ended("from rich.console import Console; Console().print('a')", stdout=gone)
    assert done.returncode == 141 and not done.stderr


def test_characters_that_the_output_lacks_are_replaced():
    done = ended("print('error at 1\\u2026 \\udcff')", env={"PYTHONIOENCODING": "ascii"})
    assert (done.returncode, done.stdout, done.stderr) == (0, "error at 1? ?\n", "")
