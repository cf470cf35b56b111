"""Fixtures of the tests of reports.

The process that distributes the tests imports this file and runs none, so that the fixtures import
what they need.
"""

from __future__ import annotations

import shlex
from functools import lru_cache
from types import SimpleNamespace

import pytest


@pytest.fixture
def ask(tmp_path, monkeypatch, capsys):
    """A function that runs a command line, with claims or a suite, in an empty folder with the
    report in `out`, and returns its status, out and err."""
    from reports.cli.commands import run
    from reports.results.suite import Suite
    from tests.suite.reports.small_reports import suite_of

    monkeypatch.chdir(tmp_path)

    def ask(command_line, *claims):
        capsys.readouterr()
        suite = claims[0] if claims and isinstance(claims[0], Suite) else suite_of(*claims)
        out_option = [] if "--out" in command_line else ["--out", "out"]
        status = run(lambda: suite, [*shlex.split(command_line), *out_option], called=["galvi"])
        out, err = capsys.readouterr()
        return SimpleNamespace(status=status, out=out, err=err)

    return ask


@pytest.fixture(scope="session")
def drawn_frames():
    """A table for each figure of the catalogue, by its name."""
    from reports.figures.catalogue.all import FIGURES
    from tests.suite.reports.figure_frames import table_for

    return {figure.name: table_for(figure) for figure in FIGURES}


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch):
    """Builds draw no figures, which would take most of their time."""
    from reports.figures.drawing import Gallery

    monkeypatch.setattr("reports.build.build.draw", lambda *measured: Gallery({}, {}))


@pytest.fixture(scope="session", autouse=True)
def pages_as_text():
    """Pages are written without Sphinx, which takes seconds and leaves their text as it is."""
    from tests.suite.reports.sites import BUILDER, TextSite

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(BUILDER, TextSite)
        yield


@pytest.fixture(scope="session", autouse=True)
def labels_parsed_once():
    """matplotlib parses the labels of a figure in every pass that draws it: a third of the time.

    It caches parsed labels for one renderer; here the cache serves all of the same output type.
    """
    from matplotlib.mathtext import MathTextParser

    parse_cached = getattr(MathTextParser, "_parse_cached", None)  # not public: it may go
    with pytest.MonkeyPatch.context() as patch:
        if parse_cached is not None:
            patch.setattr(
                MathTextParser,
                "__eq__",
                lambda left, right: output_type(left) == output_type(right),
            )
            patch.setattr(MathTextParser, "__hash__", lambda parser: hash(output_type(parser)))
            patch.setattr(
                MathTextParser, "_parse_cached", lru_cache(4096)(parse_cached.__wrapped__)
            )
        yield


def output_type(parser):
    """The parser's output, vectors or pixels."""
    return parser._output_type
