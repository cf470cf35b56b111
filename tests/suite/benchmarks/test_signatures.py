"""How peers move: one that moves otherwise, fails or is gone with newer engines is told."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from benchmarks.studies import signatures


def test_a_version_that_moves_otherwise_fails_or_is_gone_is_told() -> None:
    names = {"problem": "p", "settings": "step=1", "engines": "engine 1"}
    here = pd.DataFrame(
        [{**names, "contender": who, "error": error, "status": ""}
         for who, error in (("same", 1e-3), ("round-off", 1e-14), ("other", 1e-3), ("ends", 1e-3),
                            ("gone", 1e-3))]
    )  # fmt: skip
    new = here.assign(error=[1.001e-3, 4e-13, 2e-3, float("nan"), 1e-3])
    new.loc[3, "status"] = "It failed."
    assert list(signatures.differences(here, here)) == []
    assert list(signatures.differences(here, new[:4])) == [
        "p, other, step=1: the error 0.001 became 0.002.",
        "p, ends, step=1: '' became 'It failed.'.",
        "p, gone, step=1: not there.",
    ]


def test_what_is_written_and_read_again_is_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    row = {"problem": "p", "settings": "step=1", "engines": "engine 1"}
    rows = [{**row, "contender": "moves", "error": 0.1 + 0.2, "status": ""},
            {**row, "contender": "ends", "error": float("nan"), "status": "Failed."}]  # fmt: skip
    monkeypatch.setattr(signatures, "signatures", lambda: pd.DataFrame(rows))
    file = str(tmp_path / "signatures.csv")
    assert signatures.main(["--write", file]) == signatures.main([file]) == 0
    assert "2 signatures are the same." in capsys.readouterr().out
