"""Another build of REBOUND takes the module's place for a run, and no longer."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import galvi
from references.rebound import native
from references.rebound.simulation import missing, version
from references.rebound.whfast import WHFAST

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "present")
OTHER = (
    "__version__ = '{}'\nclass Simulation:\n    def __init__(self): raise OSError('the other')\n"
)


@pytest.fixture
def build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """(version) -> a build of this version, whose simulations say that they are its."""

    def make(number: str) -> None:
        (tmp_path / "rebound").mkdir()
        (tmp_path / "rebound" / "__init__.py").write_text(OTHER.format(number))

    monkeypatch.setattr(native, "FOLDER", tmp_path)
    yield make
    native._modules.cache_clear()


def test_it_says_what_is_missing_or_does_not_fit(build) -> None:
    assert "make native" in native.missing()
    build("0.1")
    assert native.missing().startswith("rebound 0.1 is built for this processor, beside")


def test_it_takes_the_place_of_the_module_for_a_run_which_it_gives_back_even_after_a_fault(
    build,
) -> None:
    import rebound

    build(rebound.__version__)
    assert native.missing() == "" and native.Native(WHFAST).name == "REBOUND WHFast, native"
    problem, setting = galvi.problems.outer_solar_system(), {"step": 100.0, "save_every": 5}
    with pytest.raises(OSError, match="the other"):
        native.Native(WHFAST).run(problem, 500.0, setting)
    assert sys.modules["rebound"] is rebound and version().startswith("rebound")
    assert WHFAST.run(problem, 500.0, setting).success
