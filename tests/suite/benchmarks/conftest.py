"""Settings for the tests of the suite."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="session", autouse=True)
def folder_of_quick_studies(
    tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest
) -> None:
    """Set the folder of quick studies: the run's, in which each worker has a subfolder."""
    # imported here, since the process that only distributes tests does not need it
    from tests.suite.benchmarks import quick_studies

    base = tmp_path_factory.getbasetemp()
    quick_studies.folder = base.parent if hasattr(request.config, "workerinput") else base
