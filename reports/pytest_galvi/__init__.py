"""The plugin of pytest: `pytest --galvi mine:Leapfrog` checks an integrator beside other tests.

In a wheel it is a separate package: pytest imports it whenever it runs, and then need not import
galvi or numpy. The code for the option is in `check_items`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from .check_items import OtherProcess

ITEMS_KEY = "galvi_items"  # key of the list that the controller of xdist sends to its workers

PROCESS: pytest.StashKey[OtherProcess] = pytest.StashKey()
LISTED_CHECKS = pytest.StashKey[list[dict[str, str]]]()


def pytest_addoption(parser: pytest.Parser, pluginmanager: pytest.PytestPluginManager) -> None:
    """Add the options that select integrators, problems and a time limit."""
    # pytest rewrites the asserts of every package that comes in a wheel with a plugin: 2 s for the
    # first import of galvi, whose asserts are no tests.
    hook = getattr(pluginmanager, "rewrite_hook", None)
    getattr(hook, "_must_rewrite", set()).discard("galvi")
    group = parser.getgroup("galvi", "checks of an integrator by galvi")
    group.addoption(
        "--galvi",
        action="append",
        default=[],
        metavar="package.module:Class",
        help="An integrator, each check of which becomes a test item; may be repeated.",
    )
    group.addoption(
        "--galvi-problem",
        action="append",
        default=[],
        metavar="package.module:function",
        help="A problem to check it on, in place of galvi's; may be repeated.",
    )
    group.addoption(
        "--galvi-timeout",
        type=float,
        default=60.0,
        metavar="SECONDS",
        help="Longest time of one run of an integrator (default: 60).",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Register the marker of the items, for -m galvi."""
    config.addinivalue_line("markers", "galvi: a check of an integrator (--galvi mine:Leapfrog)")


def pytest_sessionstart(session: pytest.Session) -> None:
    """Obtain the list of the checks; a wrong path ends the run here.

    The workers of xdist receive the list from their controller.
    """
    config = session.config
    if not config.getoption("galvi"):
        if config.getoption("galvi_problem"):
            raise pytest.UsageError("--galvi-problem needs an integrator: --galvi mine:Leapfrog.")
        return
    limit = config.getoption("galvi_timeout")
    if not 0.0 < limit < float("inf"):
        raise pytest.UsageError(
            f"--galvi-timeout must be a positive, finite number of seconds; received {limit:g}."
        )
    from .check_items import OtherProcess

    config.stash[PROCESS] = OtherProcess(config)
    handed_over = getattr(config, "workerinput", {}).get(ITEMS_KEY)
    config.stash[LISTED_CHECKS] = (
        config.stash[PROCESS].answer({"do": "list"})["items"]
        if handed_over is None
        else handed_over
    )


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Send the list of checks to a worker of xdist, and end the controller's own process."""
    listed = node.config.stash.get(LISTED_CHECKS, None)
    if listed is not None:
        node.workerinput[ITEMS_KEY] = listed
        node.config.stash[PROCESS].close()


@pytest.hookimpl(tryfirst=True)  # before -k chooses
def pytest_collection_modifyitems(session: pytest.Session, items: list[pytest.Item]) -> None:
    """Add an item for each check, after the project's tests."""
    if listed := session.config.stash.get(LISTED_CHECKS, None):
        from .check_items import items_of

        checks = list(items_of(session, listed, session.config.stash[PROCESS]))
        report = pytest.CollectReport("galvi", outcome="passed", longrepr=None, result=checks)
        session.config.hook.pytest_collectreport(report=report)  # so that pytest counts them
        items += checks


def pytest_unconfigure(config: pytest.Config) -> None:
    """End the process that measures."""
    process = config.stash.get(PROCESS, None)
    if process is not None:
        process.close()
