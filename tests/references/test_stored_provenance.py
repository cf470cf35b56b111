"""The provenance of stored truths names each file, and its hash tells a changed one."""

from __future__ import annotations

import hashlib
import importlib
from pathlib import Path

import pytest

from references.stored import provenance
from references.stored.planets import FOLDER


def test_every_file_has_its_engine_command_and_hash() -> None:
    found = {one["file"]: one for one in provenance.truths()}
    assert set(found) == {path.name for path in FOLDER.iterdir()}
    for name, one in found.items():
        assert list(one) == list(provenance.HEADINGS)
        assert one["engine"].startswith("heyoka ") and "real128" in one["engine"]
        assert one["SHA-256"] == hashlib.sha256((FOLDER / name).read_bytes()).hexdigest()
        module, case = one["made by"].removeprefix("python -m ").split()[:2]
        assert f"{case}.csv" == name and importlib.util.find_spec(module) is not None


def test_a_changed_digit_has_another_hash(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    name = "henon_heiles.csv"
    text = (FOLDER / name).read_text()
    (tmp_path / name).write_text(text[:-2] + str((int(text[-2]) + 1) % 10) + "\n")
    (before,) = [one for one in provenance.truths() if one["file"] == name]
    monkeypatch.setattr(provenance, "FOLDER", tmp_path)
    (after,) = provenance.truths()
    assert after["SHA-256"] != before["SHA-256"]
