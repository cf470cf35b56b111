"""Pages in a real browser: what tests with the mark `browser` share."""

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
    """A chromium of the system."""
    sync = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with sync.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield started
        started.close()


@contextmanager
def looking(browser, out, notice="\0"):
    """(name, width, dark, javascript) -> the page; what its console said is in `page.said`.

    notice  what is in lines of the console that say nothing
    """
    contexts = []

    def look(name, width=1400, dark=False, scripts=True, **context_options):
        context = browser.new_context(
            viewport={"width": width, "height": 900},
            java_script_enabled=scripts,
            color_scheme="dark" if dark else "light",
            reduced_motion="reduce",
            **context_options,
        )
        contexts.append(context)
        page = context.new_page()
        page.said = []
        page.on("console", lambda message: notice in message.text or page.said.append(message.text))
        page.on("pageerror", lambda error: page.said.append(str(error)))
        page.on("requestfailed", lambda request: page.said.append(f"not found: {request.url}"))
        page.goto((out / f"{name}.html").as_uri())
        return page

    yield look
    for context in contexts:
        context.close()


def violations(page):
    """(rule, element) of what axe finds."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is missing")
    failures = axe.Axe().run(page).response["violations"]
    return [(violation["id"], violation["nodes"][0]["html"][:200]) for violation in failures]
