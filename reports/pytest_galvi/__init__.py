"""The plugin of pytest: `pytest --galvi mine:Leapfrog` checks an integrator beside other tests.

In a wheel it is a package of its own, so that pytest, which imports it whenever it runs, imports
neither galvi nor numpy; what the option needs is in `check_items`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from .check_items import OtherProcess

ITEMS = "galvi_items"  # what the controller of xdist hands to its workers

PROCESS: pytest.StashKey[OtherProcess] = pytest.StashKey()
LISTED = pytest.StashKey[list[dict[str, str]]]()


def pytest_addoption(parser: pytest.Parser, pluginmanager: pytest.PytestPluginManager) -> None:
    """Options that select what is checked."""
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
    """The marker of the items, for -m galvi."""
    config.addinivalue_line("markers", "galvi: a check of an integrator (--galvi mine:Leapfrog)")


def pytest_sessionstart(session: pytest.Session) -> None:
    """List the items, so that a wrong path ends the run; workers of xdist get them handed over."""
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
    handed = getattr(config, "workerinput", {}).get(ITEMS)
    config.stash[LISTED] = (
        config.stash[PROCESS].answer({"do": "list"})["items"] if handed is None else handed
    )


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Hand the items to a worker of xdist, whose controller measures nothing itself."""
    listed = node.config.stash.get(LISTED, None)
    if listed is not None:
        node.workerinput[ITEMS] = listed
        node.config.stash[PROCESS].close()


@pytest.hookimpl(tryfirst=True)  # before -k chooses
def pytest_collection_modifyitems(session: pytest.Session, items: list[pytest.Item]) -> None:
    """Add an item for each check, after the project's tests."""
    if listed := session.config.stash.get(LISTED, None):
        from .check_items import items_of

        checks = list(items_of(session, listed, session.config.stash[PROCESS]))
        report = pytest.CollectReport("galvi", outcome="passed", longrepr=None, result=checks)
        session.config.hook.pytest_collectreport(report=report)  # they are counted
        items += checks


def pytest_unconfigure(config: pytest.Config) -> None:
    """End the other process."""
    process = config.stash.get(PROCESS, None)
    if process is not None:
        process.close()
