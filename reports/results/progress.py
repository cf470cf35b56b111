"""Progress of the studies: a progress bar on a terminal, otherwise one line per study."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Column

TEXT = Column(ratio=1, no_wrap=True, overflow="ellipsis")  # long text is cut with an ellipsis


class Studies:
    """Count studies; `with studies("V3", title) as report` runs one, report(text) shows details.

    count   number of studies
    stream  output; stderr by default
    """

    def __init__(self, count: int, stream: TextIO | None = None) -> None:
        self.stream = stream or sys.stderr
        self.count = count
        self.done = 0
        self.bar: Progress | None = None
        if self.stream.isatty():
            self.bar = Progress(
                TextColumn("{task.fields[name]}", table_column=Column(min_width=4, no_wrap=True)),
                BarColumn(bar_width=16, table_column=Column(min_width=16)),
                MofNCompleteColumn(),
                TimeElapsedColumn(),
                TextColumn("{task.description}", style="dim", markup=False, table_column=TEXT),
                console=Console(file=self.stream),
                transient=True,
                expand=True,
            )
            self.task = self.bar.add_task("", total=count, name="")

    def __enter__(self) -> Studies:
        if self.bar:
            self.bar.start()
        return self

    def __exit__(self, *error: object) -> None:
        if self.bar:
            self.bar.stop()

    @contextmanager
    def __call__(self, name: str, title: str) -> Iterator[Callable[[str], None]]:
        """Announce a study, yield its `report` function, and print its run time."""
        start = time.perf_counter()
        self._tell(name, title)
        try:
            yield lambda text: self._tell(name, text)
        finally:
            self.finished(name, title, time.perf_counter() - start)

    def finished(self, name: str, title: str, seconds: float) -> None:
        """Count a study, and print its run time in seconds."""
        self.done += 1
        if self.bar:
            self.bar.update(self.task, completed=self.done)
        else:
            line = f"[{self.done}/{self.count}] {name} {title}: {seconds:.1f} s"
            print(line, file=self.stream, flush=True)

    def _tell(self, name: str, text: str) -> None:
        if self.bar:
            self.bar.update(self.task, name=name, description=text)
