"""Parts of a build: kept to the last bit, set aside when damaged, studied by a second process."""

from __future__ import annotations

import inspect
import json
import re
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.claims import CLAIMS
from benchmarks.timings.unfinished import DAMAGED, FOLDER, Unfinished
from reports.build import parallel_claims
from reports.results.cache import Parts
from reports.results.suite import load
from reports.tables.plain_frames import framed, plain_frame


def kept(folder: Path) -> list[Path]:
    return sorted((folder / FOLDER).rglob("*.json"))


FRAMES = (
    pd.DataFrame({"x": [0.1 + 0.2, -0.0, np.nan, np.inf, -np.inf, 5e-324, 1e308]}),
    pd.DataFrame({"n": [2**62, -1], "good": [True, False], "text": ["a", ""]}),
    pd.DataFrame({"mixed": pd.Series(["a", None, np.nan, 1, 2.5, True], dtype=object)}),
    pd.DataFrame({"text": pd.Series(["a", np.nan], dtype="str"), "f": np.float32([0.1, 3])}),
    pd.DataFrame({"number": pd.Series([np.float64(0.1), np.int64(3)], dtype=object)}),
    pd.DataFrame(columns=["a", "b"]).astype({"a": "float64"}),
    pd.DataFrame(),
)


@pytest.mark.parametrize(
    "damage",
    [
        lambda text: text[:-9],
        lambda text: "\x00" + text,
        lambda text: text.replace('"seconds"', '"second"'),
        lambda text: text.replace('"rows": 2', '"rows": 3'),
        lambda text: text.replace('"V1"', '"V2"'),
        lambda text: re.sub(r'"columns": \[.*?\]\}\]', '"columns": []', text),
        lambda text: text.replace("0.1", "0.7"),
        lambda text: '{"fullname": "V1", "row": 3}',
    ],
)
def test_a_damaged_part_is_set_aside_and_measured_again(tmp_path, capsys, damage):
    frame, again = pd.DataFrame({"x": [0.1, 0.2]}), pd.DataFrame({"x": [0.3]})
    store, names = Unfinished(tmp_path, "state"), ("V1", "V3")
    before = Parts(store, "monday", planned=names)
    for name in names:
        before.part(name, lambda: frame)
    path = store.path("V1")
    whole = path.read_text()
    path.write_text(damage(whole))
    damaged = path.read_text()
    assert damaged != whole
    parts = Parts(store, "friday", planned=names)
    parts.take_up()
    assert "What was kept of V1 cannot be read (" in capsys.readouterr().out
    assert "monday that did not end: 1 of 2 parts are there" in parts.greeting()
    assert [parts.part(name, lambda: again).run for name in names] == ["friday", "monday"]
    parts.forget()
    assert kept(tmp_path) == [tmp_path / FOLDER / DAMAGED / path.name]
    assert kept(tmp_path)[0].read_text() == damaged


@pytest.mark.parametrize("frame", FRAMES)
def test_a_kept_frame_is_the_same_to_the_last_bit(frame: pd.DataFrame) -> None:
    back = framed(json.loads(json.dumps(plain_frame(frame))))
    pd.testing.assert_frame_equal(back, frame, check_exact=True)
    for name in frame.select_dtypes("float"):
        assert back[name].to_numpy().tobytes() == frame[name].to_numpy().tobytes()


def test_a_frame_of_other_things_is_refused_and_therefore_not_kept(tmp_path, capsys):
    frame = pd.DataFrame({"x": [np.zeros(3)]})
    with pytest.raises(TypeError, match="a cell holds a ndarray"):
        plain_frame(frame)
    parts = Parts(Unfinished(tmp_path, "state"))
    assert parts.part("V1", lambda: frame).frame is frame
    assert "V1 is not kept for a build that goes on: a cell holds" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_claims_that_take_times_say_so():
    """They are not studied beside others."""
    for claim in CLAIMS:
        source = inspect.getsource(sys.modules[claim.study.__module__])
        assert claim.timed == (
            "benchmarks.statistics.timing" in source or "import time" in source
        ), claim.id
    assert [claim.id for claim in CLAIMS if claim.timed] == ["V24"]


def test_a_second_process_keeps_claims_from_the_last_until_it_meets_the_build(make_claim, tmp_path):
    parts = Parts(Unfinished(tmp_path, "state"), "now")
    claims = [make_claim("V4"), make_claim("V3", raises=RuntimeError("no")), make_claim("V2")]
    parts.part("V2", lambda: pd.DataFrame({"mine": [1.0]}))
    parallel_claims.study([*claims, make_claim("V1")], None, parts, quick=True)
    assert parts.store.row("V1") is None and parts.store.row("V3") is None
    assert parts.part("V4", pytest.fail).run == "now"
    assert list(parts.part("V2", pytest.fail).frame) == ["mine"]


@pytest.mark.slow
def test_the_second_process_is_there_while_the_build_is_and_no_longer(tmp_path):
    """It studies A8 to A1 of the real suite, and ends in between."""
    claims = [claim for claim in load().claims if claim.id[0] == "A"]
    parts = Parts(Unfinished(tmp_path, "state"), "now", ahead=True)
    with parallel_claims.ahead(parts, claims, quick=True):
        for _ in range(600):
            if parts.store.row("A8") is not None:
                break
            time.sleep(0.1)
    there = kept(tmp_path)
    assert parts.part("A8", pytest.fail).run == "now"
    time.sleep(2.0)
    assert kept(tmp_path) == there
