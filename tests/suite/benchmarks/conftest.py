"""Settings for the tests of the suite."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="session", autouse=True)
def folder_of_quick_studies(
    tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest
) -> None:
    """Workers have each a folder inside the one of the run."""
    from tests.suite.benchmarks import quick_studies  # not where tests are only handed out

    base = tmp_path_factory.getbasetemp()
    quick_studies.folder = base.parent if hasattr(request.config, "workerinput") else base
