"""Progress of the studies: a progress bar on a terminal, otherwise one line per study."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import partial

from tqdm import tqdm


class Studies(AbstractContextManager["Studies"]):
    """A progress display: `with studies("V3", title) as report` encloses a study, and report(text)
    shows details of it.

    Parameters
    ----------
    count
        number of studies
    """

    def __init__(self, count: int) -> None:
        self.count, self.done = count, 0
        self.bar = tqdm(total=count, disable=None, leave=False, dynamic_ncols=True)

    def __exit__(self, *error: object) -> None:
        self.bar.close()

    @contextmanager
    def __call__(self, name: str, title: str) -> Iterator[Callable[[str], None]]:
        """Announce a study, yield its `report` function, and print its run time."""
        start = time.perf_counter()
        report = partial(self._show, name)
        report(title)
        try:
            yield report
        finally:
            self.finished(name, title, time.perf_counter() - start)

    def finished(self, name: str, title: str, seconds: float) -> None:
        """Count a study, and print its run time in seconds."""
        self.done += 1
        self.bar.update()
        if self.bar.disable:  # not a terminal
            line = f"[{self.done}/{self.count}] {name} {title}: {seconds:.1f} s"
            print(line, file=sys.stderr, flush=True)

    def _show(self, name: str, text: str) -> None:
        self.bar.set_description_str(name, refresh=False)
        self.bar.set_postfix_str(text)
