"""A worker process that runs benchmarks with the galvi of one checkout, connected by a pipe."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from contextlib import AbstractContextManager, suppress
from dataclasses import asdict
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from benchmarks.store.foreign_texts import log_line
from benchmarks.timings import worker
from benchmarks.timings.case import Case
from reports.tracking.checkouts import Checkout

ANSWER_SECONDS = 600.0  # time limit for an answer of galvi, whose first call compiles
CONTENDER_SECONDS = 60.0  # time limit for an answer of another integrator
END_SECONDS = 10.0  # seconds to wait for the end of a process that has closed its pipe
MAX_TIME_OUTS = 2  # timeouts of a side after which it is not asked again
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
REMOVED_VARIABLES = ("NUMBA_CACHE_DIR", "PYTHONHOME")


class Failed(Exception):
    """A worker's request failed; the message gives the reason."""


class Worker(AbstractContextManager["Worker"]):
    """A context manager: `with Worker(checkout) as worker` ends the process afterwards.

    Both sides run the worker program of this suite, which uses only galvi's public interface, so
    that a revision with another suite is measured in the same way. A request starts the process if
    it does not run: at first, after `stop`, and after it died or hung. After MAX_TIME_OUTS timeouts
    each request fails at once.

    Parameters
    ----------
    limit
        seconds for an answer
    """

    pipe: Connection  # exists while the process runs

    def __init__(self, checkout: Checkout, limit: float = ANSWER_SECONDS) -> None:
        self.checkout, self.limit, self.time_outs = checkout, limit, 0
        self.process: subprocess.Popen[bytes] | None = None

    def __exit__(self, *error: object) -> None:
        self.stop()

    def run(self, case: Case) -> dict[str, Any]:
        """Run a benchmark, and compile it if it is new; returns its results. Raises Failed."""
        answer = self._ask("run", case)
        code = Path(answer.pop("code"))
        if not code.resolve().is_relative_to(self.checkout.folder.resolve()):
            raise Failed(f"It ran {code}, not that of its own checkout.")
        return answer | {"status": log_line(answer["status"])}

    def time(self, case: Case, repeats: int, attempts: int) -> float:
        """The processor time of one call in seconds. Raises Failed."""
        return float(self._ask("time", case, repeats=repeats, attempts=attempts)["processor"])

    def stop(self) -> None:
        """End the process, if it runs."""
        if self.process is not None:
            with suppress(ProcessLookupError):  # kill the processes that it started, too
                os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
            self.pipe.close()
            self.process = None

    def _ask(self, request: str, case: Case, **numbers: int) -> dict[str, Any]:
        if self.time_outs >= MAX_TIME_OUTS:
            raise Failed(
                f"It was not asked: {MAX_TIME_OUTS} answers did not come within {self.limit:g} "
                "seconds."
            )
        process = self.process or self._start()
        try:
            order = {"do": request, "case": asdict(case), **numbers}
            self.pipe.send_bytes(json.dumps(order).encode())
            if not self.pipe.poll(self.limit):
                self.stop()
                self.time_outs += 1
                raise Failed(f"It gave no answer within {self.limit:g} seconds and was ended.")
            answer: dict[str, Any] = json.loads(self.pipe.recv_bytes())
        except (EOFError, OSError):
            with suppress(subprocess.TimeoutExpired):  # a process that only closed its pipe goes on
                process.wait(END_SECONDS)
            status = process.poll()
            self.stop()
            raise Failed(f"Its process ended with status {status}.") from None
        if "raised" in answer:
            raise Failed(log_line(answer["raised"]))
        return answer

    def _start(self) -> subprocess.Popen[bytes]:
        self.pipe, child_end = Pipe()
        places = self.checkout.places or (self.checkout.folder,)
        environment = {
            key: text for key, text in os.environ.items() if key not in REMOVED_VARIABLES
        }
        environment |= dict.fromkeys(ONE_THREAD, "1")
        environment["PYTHONPATH"] = os.pathsep.join(str(path.resolve()) for path in places)
        with child_end:
            self.process = subprocess.Popen(
                [self.checkout.python, "-P", str(worker.__file__), str(child_end.fileno())],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=environment,
                pass_fds=[child_end.fileno()],
                start_new_session=True,
            )
        return self.process
