"""One side of a comparison: a process that runs benchmarks with the galvi of one tree."""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import threading
from pathlib import Path
from types import TracebackType
from typing import Any

from benchmarks.timings import worker
from benchmarks.timings.case import Case

SECONDS = 600.0  # that a first call may take, which compiles; longer is a hang
SAMPLE = 120.0  # the same for a sample
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
CHECKOUT_ONLY = ("NUMBA_CACHE_DIR", "PYTHONPATH", "PYTHONHOME")


class Failed(Exception):
    """A side could not do what it was asked; a sentence says why."""


class Side:
    """`with Side(folder) as side` starts the process; it is ended afterwards.

    folder       holds the galvi to run
    interpreter  whose packages are used
    """

    def __init__(self, folder: Path, interpreter: str = sys.executable) -> None:
        self.folder, self.interpreter = folder, interpreter
        self.process: subprocess.Popen[str] | None = None
        self._cases: dict[str, Case] = {}
        self._ready: set[str] = set()  # those that the process of now has run

    def __enter__(self) -> Side:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self.stop()

    def prepare(self, case: Case) -> dict[str, Any]:
        """Run a case for the first time, which compiles what it needs; see the worker."""
        self._cases[case.name] = case
        told = self._ask({"do": "prepare", "case": case.as_data()}, SECONDS)
        self._ready.add(case.name)
        return told

    def sample(self, name: str, repeats: int, goes: int) -> dict[str, float]:
        """Seconds of one call, in processor time and by the wall clock, see the worker.

        A process that another case has ended is replaced by one that runs this case for the first
        time before.
        """
        if name not in self._ready:
            self.prepare(self._cases[name])
        order = {"do": "sample", "name": name, "repeats": repeats, "goes": goes}
        return self._ask(order, SAMPLE)

    def stop(self) -> None:
        """End the process, if there is one; the next question starts another."""
        process, self.process = self.process, None
        self._ready.clear()
        if process is not None:
            process.kill()
            process.wait()
            for stream in (process.stdin, process.stdout):
                if stream:
                    stream.close()

    def _ask(self, order: dict[str, Any], seconds: float) -> dict[str, Any]:
        if self.process is None:
            self._start()
        told = self._exchange(order, seconds)
        if "raised" in told:
            raise Failed(str(told["raised"]))
        return told

    def _start(self) -> None:
        kept = {key: value for key, value in os.environ.items() if key not in CHECKOUT_ONLY}
        own = dict.fromkeys(ONE_THREAD, "1") | {"PYTHONPATH": str(self.folder.resolve())}
        self.process = subprocess.Popen(
            [self.interpreter, "-P", str(Path(worker.__file__))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env=kept | own,
            start_new_session=True,
        )
        told = self._exchange({"do": "where"}, SECONDS)
        at = Path(told.get("file") or "nowhere")
        if self.folder.resolve() not in at.resolve().parents:
            self.stop()
            why = told.get("raised", "it is not the one of its tree")
            raise Failed(f"Its galvi cannot be imported: {why}.")

    def _exchange(self, order: dict[str, Any], seconds: float) -> dict[str, Any]:
        """Send a line and wait for its answer, no longer than that."""
        process = self.process
        assert process and process.stdin and process.stdout
        answers: queue.Queue[str] = queue.Queue()
        threading.Thread(target=_read, args=(process.stdout, answers), daemon=True).start()
        try:
            process.stdin.write(json.dumps(order) + "\n")
            process.stdin.flush()
            line = answers.get(timeout=seconds)
        except queue.Empty:
            self.stop()
            raise Failed(f"It gave no answer within {seconds:.0f} seconds and was ended.") from None
        except OSError:
            line = ""
        except BaseException:
            self.stop()
            raise
        if not line:
            status = process.wait()
            self.stop()
            raise Failed(f"Its process ended with status {status}.")
        answer: dict[str, Any] = json.loads(line)
        return answer


def _read(stream: Any, answers: queue.Queue[str]) -> None:
    try:
        answers.put(stream.readline())
    except (OSError, ValueError):
        answers.put("")
