"""What a contender is made of: an edit of any of it is seen, wherever it came from."""

from __future__ import annotations

import importlib
import sys
import types
import zipfile
from collections.abc import Iterator
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location
from pathlib import Path

import numpy as np
import pytest

from benchmarks.external import code_digest
from benchmarks.external.code_digest import digest, installed, loaded, places

FILES = {
    "wrapper_b.py": "import core_b.inner, elsewhere_b, numpy.polynomial.hermite, this",
    "core/core_b/__init__.py": "",
    "core/core_b/inner.py": "order = 2",
    "core/core_b/table.bin": "0.1",
    "core/core_b/unread.py": "",
    "away/elsewhere_b.py": "",
}


class Finder:
    """As an editable install puts one on sys.meta_path: a name, and a file anywhere."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def find_spec(self, name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        return spec_from_file_location(name, self.file) if name == "elsewhere_b" else None


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Where the files are, and are imported from; what was imported is forgotten at the end."""
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path / "core"))
    monkeypatch.syspath_prepend(str(tmp_path))
    finder = Finder(tmp_path / "away" / "elsewhere_b.py")
    monkeypatch.setattr(sys, "meta_path", [*sys.meta_path, finder])
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        if name.endswith("_b") or "_b." in name:
            del sys.modules[name]


def test_an_edit_of_anything_that_it_is_made_of_makes_another_digest(folder, capsys):
    before = loaded()
    importlib.import_module("wrapper_b")
    capsys.readouterr()
    made = places("wrapper_b", before)
    names = ("away/elsewhere_b.py", "core/core_b", "wrapper_b.py")
    assert made == [str(folder / name) for name in names]  # neither numpy's nor Python's
    seen = [digest(made)]
    assert digest(made) == seen[0]
    for name in FILES:
        (folder / name).write_text("1 + 1")
        seen.append(digest(made))
    (folder / "core" / "core_b" / "another.py").write_text("")
    seen.append(digest(made))
    assert len(set(seen)) == len(seen) == len(FILES) + 2
    (folder / "core" / "core_b" / "__pycache__").mkdir(exist_ok=True)
    (folder / "core" / "core_b" / "__pycache__" / "inner.nbc").write_text("compiled")
    assert digest(made) == seen[-1]
    (folder / "wrapper_b.py").unlink()
    assert digest(made) != seen[-1]


def test_of_a_large_file_the_size_and_the_time_of_change_are_looked_at(folder, monkeypatch):
    monkeypatch.setattr(code_digest, "LARGE", 2)
    path = folder / "core" / "core_b" / "inner.py"
    before = digest([str(path)])
    path.write_text("order = 12")
    assert digest([str(path)]) != before


def test_what_is_installed_is_told_with_its_version():
    assert f"numpy {np.__version__}" in installed()


def test_an_archive_is_a_file_and_what_came_from_no_file_is_made_of_nothing(folder, monkeypatch):
    archive = folder / "packed.zip"
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("packed_b.py", "")
    monkeypatch.syspath_prepend(str(archive))
    importlib.import_module("packed_b")
    assert str(archive) in places("packed_b", ())
    monkeypatch.setitem(sys.modules, "made_b", types.ModuleType("made_b"))
    assert places("made_b", ()) == []
