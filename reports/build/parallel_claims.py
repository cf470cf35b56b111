"""A second process that studies claims from the last to the first, while a build goes forwards.

Only claims that time nothing are studied beside each other. What the second process finishes is
kept as a part of the build, which takes it up when it comes to it. Claims whose study raises are
left to the build. The process ends when the build does, however that ends, when the build comes to
a claim that times something, and when it meets what the build has done.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.checks.claim import Claim
from benchmarks.timings.unfinished import Unfinished
from reports.results.cache import Parts

FEWEST = 4  # claims, below which starting a process takes longer than it saves


@contextmanager
def ahead(parts: Parts, claims: Iterable[Claim], quick: bool) -> Iterator[None]:
    """Study those of the claims that are missing, the last first, until the context is left."""
    missing = [claim.id for claim in claims if claim.id not in parts.taken]
    if parts.store is None or not parts.ahead or len(missing) < FEWEST or _processors() < 2:
        yield
        return
    setting = "quick" if quick else "default"
    words = [str(parts.store.storage), parts.store.state, parts.run, setting, *reversed(missing)]
    process = subprocess.Popen(
        [sys.executable, "-m", "reports.build.parallel_claims", *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield
    finally:
        process.kill()
        process.communicate()


def study(claims: Iterable[Claim], make_method: Any, parts: Parts, quick: bool) -> None:
    """Keep the parts of these claims, in their order, until one is there."""

    def silent(sentence: str) -> None:
        return

    for claim in claims:
        if parts.store is None or parts.store.row(claim.id) is not None:
            return
        try:
            parts.part(claim.id, partial(claim.study, make_method, quick, silent))
        except Exception:
            continue


def _processors() -> int:
    available = getattr(os, "sched_getaffinity", None)
    return len(available(0)) if available else os.cpu_count() or 1


def _end_with_the_build() -> None:
    """Its end of the pipe closes when it is gone, killed or not."""
    sys.stdin.buffer.read()
    os._exit(1)


def main(words: Sequence[str]) -> None:
    """(storage, state, run, setting, *ids), as `ahead` hands them over."""
    from reports.results.suite import load

    storage, state, run, setting, *ids = words
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the build decides
    threading.Thread(target=_end_with_the_build, daemon=True).start()
    parts = Parts(Unfinished(Path(storage), state), run)
    suite = load()
    known = {claim.id: claim for claim in suite.claims}
    ours = [known[name] for name in ids if name in known]  # not those of a contender
    study(ours, suite.make_method, parts, setting == "quick")


if __name__ == "__main__":
    main(sys.argv[1:])
