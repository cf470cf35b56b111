"""kill -9 at random moments of track and build: nothing damaged, and it goes on.

`python -m pytest tests/suite/reports/test_track_kills.py -m slow -s` prints the table; KILLS sets
how many.
"""

from __future__ import annotations

import json
import os
import random
import re
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

from benchmarks.store.provenance import ROOT
from reports.results.cache import FOLDER
from reports.tracking.checkouts import copy_kernels, copy_working_tree

RESUMING = re.compile(r"^Resuming: (\d+) results? of the build of [^;]*; --anew", re.M)
KILLS = int(os.environ.get("KILLS", "20"))
pytestmark = pytest.mark.slow(
    beside="test_unfinished_builds.py::test_a_build_that_was_stopped_resumes_with_what_it_was_measuring"
)


def commands(out: Path) -> dict[str, tuple[list[str], float]]:
    """Each command, and the seconds within which it is killed."""
    reports = [sys.executable, "-m", "reports"]
    return {
        "track": ([*reports, "track", "--out", str(out)], 8.0),
        "build": ([*reports, "build", "--quick", "--claims", "V1", "--out", str(out)], 40.0),
    }


def results_kept(folder: Path) -> int:
    """How many results of runs that were stopped lie in this folder."""
    if not (folder / FOLDER).exists():
        return 0
    return len(list((folder / FOLDER).rglob("*.json")))


def whole(path: Path) -> bool:
    """Whether a file is as its writer meant it."""
    if path.suffix == ".json":
        json.loads(path.read_text())
    elif path.suffix == ".csv":
        pd.read_csv(path)
    elif path.suffix == ".html":
        return path.read_text().rstrip().endswith("</html>")
    elif path.suffix == ".svg":
        return path.read_text().rstrip().endswith("</svg>")
    return True


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A copy of the checkout, whose sources stay the same until the end."""
    copy = tmp_path / "checkout"
    copy_working_tree(ROOT, copy)
    copy_kernels(ROOT, copy)
    return copy


def go_on(name: str, words: list[str], checkout: Path, out: Path, kept: int) -> None:
    """Do a command to its end; a build resumes with the `kept` parts."""
    done = subprocess.run(words, cwd=checkout, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    print(name, "at the end:", done.stdout.strip().splitlines()[-1])
    taken = RESUMING.search(done.stdout)
    if name == "build" and kept > 0:
        assert taken is not None and int(taken[1]) == kept
        told = json.loads((out / "provenance.json").read_text())["index.html"]["resumed"]
        assert told.startswith(f"{taken[1]} result")
        print(f"It resumed with {told}.")


def test_nothing_is_damaged_and_everything_goes_on(checkout: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    table, moments, parts = [], random.Random(5), [0]
    said = tmp_path / "said"
    known = commands(out)
    for k in range(KILLS):
        name = ("track", "build")[k % 2]
        words, longest = known[name]
        moment = moments.uniform(0.5, longest)
        with (
            said.open("w") as stdout,
            subprocess.Popen(
                words, cwd=checkout, stdout=stdout, stderr=subprocess.DEVNULL
            ) as process,
        ):
            time.sleep(moment)
            ended = process.poll()
            process.kill()
        if name == "build":
            parts.append(results_kept(out))
            taken = RESUMING.search(said.read_text())
            assert taken is None or int(taken[1]) == parts[-2]  # None: it was still importing
            assert parts[-1] >= parts[-2] or ended is not None
        files = [path for path in out.rglob("*") if path.is_file() and path.name[0] != "."]
        bad = [path.name for path in files if not whole(path)]
        table.append(
            {
                "killed": name,
                "after [s]": moment,
                "was": "running" if ended is None else f"done ({ended})",
                "files": len(files),
                "damaged": len(bad),
                "parts kept": parts[-1],
            }
        )
        assert bad == []
    print("\n" + pd.DataFrame(table).to_string(index=False, float_format="%.1f"))
    assert max(parts) > 0, "no build was killed between two of its parts"
    for name in ("track", "build"):
        go_on(name, known[name][0], checkout, out, parts[-1])
    assert not (out / FOLDER).exists()
