"""Trials of one target in a process of its own, so that a crash or a hang is seen and named."""

from __future__ import annotations

import multiprocessing
import os
import tempfile
import warnings
from collections import Counter
from concurrent.futures import TimeoutError
from dataclasses import dataclass
from pathlib import Path

from pebble import ProcessExpired, ProcessPool

from benchmarks.applications.fuzzing.judgement import REFUSED, RETURNED, judged

PATIENCE = 300.0  # seconds for a batch of calls


@dataclass(frozen=True)
class Trials:
    """Calls of one target: how many returned, how many were refused, and what went wrong.

    findings  what went wrong and where -> message and arguments of the first such call
    """

    calls: int
    returned: int
    refused: int
    findings: dict[str, str]


def tried(name: str, calls: int, seed: int, patience: float = PATIENCE) -> Trials:
    """Call a target ``calls`` times with arguments that the seed draws."""
    with tempfile.TemporaryDirectory(prefix="galvi-fuzz-") as folder:
        last = Path(folder) / "last"
        last.touch()
        spawn = multiprocessing.get_context("spawn")
        with ProcessPool(max_workers=1, context=spawn) as pool:
            future = pool.schedule(_calls, (name, calls, seed, last), timeout=patience)
            try:
                return future.result()
            except TimeoutError:
                return Trials(calls, 0, 0, {f"no answer in {patience:g} s": last.read_text()})
            except ProcessExpired as crash:
                return Trials(
                    calls, 0, 0, {f"the process ended ({crash.exitcode})": last.read_text()}
                )


def _calls(name: str, calls: int, seed: int, last: Path) -> Trials:
    import hypothesis
    from hypothesis import HealthCheck, Phase, given, settings
    from hypothesis import strategies as st

    from benchmarks.applications.fuzzing.targets import TARGETS

    target = TARGETS[name]
    counts: Counter[str] = Counter()
    findings: dict[str, str] = {}
    home = last.parent / "home"
    home.mkdir()
    os.chdir(home)

    @hypothesis.seed(seed)
    @settings(
        max_examples=calls, database=None, deadline=None, phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(st.data())
    def every(data):  # type: ignore[no-untyped-def]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            call, text = target(data)
        last.write_text(text, encoding="utf-8", errors="replace")
        end = judged(call)
        counts[end if end in (RETURNED, REFUSED) else "wrong"] += 1
        if end not in (RETURNED, REFUSED):
            place, _, message = end.partition(" | ")
            findings.setdefault(place, f"{message[:300]} | {text}")

    every()
    for path in home.iterdir():
        findings[f"a file was written: {path.name}"] = name
    return Trials(sum(counts.values()), counts[RETURNED], counts[REFUSED], findings)
