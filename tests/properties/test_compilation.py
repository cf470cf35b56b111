"""What a user is told while kernels are compiled."""

from __future__ import annotations

import importlib
import inspect
import logging
from types import SimpleNamespace

import pytest

from galvi.kernels.compile.watching import LEAST_SECONDS, LOG, SECONDS, CompilationNotice
from galvi.kernels.lie import product


def called(name):
    module, _, function = name.rpartition(".")
    return getattr(importlib.import_module(module), function)


def compiled(notice, *nested):
    """As numba does with functions of which each calls the next."""
    for name in nested:
        notice.on_start(SimpleNamespace(data={"dispatcher": called(name)}))
    for _ in nested:
        notice.on_end(None)


@pytest.mark.parametrize("name", SECONDS)
def test_a_kernel_that_is_compiled_is_announced_once_with_how_long_it_takes(name, caplog):
    notice = CompilationNotice()
    compiled(notice, name), compiled(notice, name)
    (record,) = caplog.records
    assert record.name == "galvi" and record.levelno == logging.WARNING
    assert f"about {SECONDS[name]} s of processor time, once" in record.getMessage()


def test_what_is_compiled_within_another_or_in_no_time_is_not_announced(caplog):
    notice, (first, second, *_) = CompilationNotice(), SECONDS
    compiled(notice, "galvi.kernels.nystrom.step.copy_into")
    compiled(notice, first, second)
    assert len(caplog.records) == 1
    compiled(notice, second)
    assert len(caplog.records) == 2


def test_a_law_that_takes_long_is_announced_with_its_time(caplog):
    notice = CompilationNotice()
    for seconds in (0.9 * LEAST_SECONDS, 17.0):
        notice.on_start(SimpleNamespace(data={"seconds": seconds}))
    (record,) = caplog.records
    assert "the law of this system: about 17 s of processor time, once" in record.getMessage()


def test_the_notice_goes_to_stderr_and_can_be_silenced(caplog, capsys, monkeypatch):
    monkeypatch.setattr(logging.root, "handlers", [])
    name = next(iter(SECONDS))
    compiled(CompilationNotice(), name)
    said = capsys.readouterr().err
    assert said.startswith("galvi is compiling a kernel") and said.count("\n") == 1
    with caplog.at_level("ERROR", logger=LOG.name):
        compiled(CompilationNotice(), name)
    assert capsys.readouterr().err == ""


def test_numba_finds_a_function_where_generated_code_says_that_its_source_is() -> None:
    """Within a docstring Python 3.13 raised TokenError, and the first run on a group ended."""
    lines, _ = inspect.getsourcelines(product.in_space.py_func)
    assert lines[0] == "def over_factors(name, *arguments):\n"
