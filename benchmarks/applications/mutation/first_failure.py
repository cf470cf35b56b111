"""A plugin of pytest: hypothesis looks for no smaller example of a failure."""

from __future__ import annotations

from hypothesis import Phase, settings


def pytest_configure() -> None:
    """After tests/conftest.py, before any test is imported."""
    phases = Phase.explicit, Phase.generate
    settings.register_profile("first failure", settings.default, phases=phases)
    settings.load_profile("first failure")
