"""Pages in a real browser, for tests with the mark `browser`."""

from __future__ import annotations

import os
import shutil
from contextlib import contextmanager

import pytest

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
CHROMIUM = next(filter(None, map(shutil.which, PROGRAMS)), "")
WIDTHS = (400, 800, 1400)
MARKS = [
    pytest.mark.browser,
    pytest.mark.skipif(bool(os.environ.get("CI")), reason="a CI has no browser to look with"),
    pytest.mark.skipif(not CHROMIUM, reason="no chromium is installed"),
]


@contextmanager
def browsing():
    """A context with the system's chromium."""
    sync = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with sync.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield started
        started.close()


@contextmanager
def page_opener(browser, out, notice="\0"):
    """A context with a function that opens a page of `out` in the browser.

    `page.console_lines` of its result collects messages and errors, but not lines with `notice`.
    """
    contexts = []

    def open_page(name, width=1400, dark=False, scripts=True, **context_options):
        context = browser.new_context(
            viewport={"width": width, "height": 900},
            java_script_enabled=scripts,
            color_scheme="dark" if dark else "light",
            reduced_motion="reduce",
            **context_options,
        )
        contexts.append(context)
        page = context.new_page()
        page.console_lines = []
        page.on(
            "console",
            lambda message: notice in message.text or page.console_lines.append(message.text),
        )
        page.on("pageerror", lambda error: page.console_lines.append(str(error)))
        page.on(
            "requestfailed", lambda request: page.console_lines.append(f"not found: {request.url}")
        )
        page.goto((out / f"{name}.html").as_uri())
        return page

    yield open_page
    for context in contexts:
        context.close()


def violations(page):
    """(rule, its first element) of each violation that axe finds."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is missing")
    failures = axe.Axe().run(page).response["violations"]
    return [(violation["id"], violation["nodes"][0]["html"][:200]) for violation in failures]
