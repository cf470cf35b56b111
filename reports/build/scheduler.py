"""Run studies without timings on the workers of a Dask scheduler: `--scheduler ADDRESS`."""

from __future__ import annotations

import pickle
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import cache, partial
from typing import Any

import pandas as pd
import typer

from benchmarks.store.provenance import cpu
from benchmarks.store.result_cache import digest_of_sources
from galvi.command import unpickled_call
from reports.build.workers import timed
from reports.results.claim_results import Finished
from reports.results.suite import Suite

PATIENCE = "10s"  # for the scheduler's answer


@contextmanager
def on_scheduler(suite: Suite, address: str) -> Iterator[Suite]:
    """The suite whose studies without timings run there; the suite itself for "".

    The provenance names the workers' processors. Raises typer.BadParameter where nothing answers,
    there are no workers, or they have other sources or versions than this process.
    """
    if not address:
        yield suite
        return
    try:
        from distributed import Client
        from distributed.comm import resolve_address
    except ImportError:
        raise typer.BadParameter("--scheduler needs Dask: pip install 'galvi[cluster]'.") from None
    try:
        resolve_address(address)  # else the client lingers and ends in a traceback
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        said = " ".join(str(error).split())
        raise typer.BadParameter(f"--scheduler: no answer of a scheduler ({said}).") from None
    with client:
        here = _sources()
        try:
            workers = client.run(unpickled_call, pickle.dumps(_identity))
        except Exception as error:
            raise typer.BadParameter(
                f"--scheduler: its workers cannot import the suite ({error}); give them the "
                "environment of this command."
            ) from None
        if not workers:
            raise typer.BadParameter(f"--scheduler {address} has no workers; start some.")
        if others := [name for name, (sources, _) in workers.items() if sources != here]:
            raise typer.BadParameter(
                f"--scheduler: the sources or versions at {', '.join(others)} are not those of "
                "this process; start the workers anew, in its environment."
            )
        counts = Counter(model for _, model in workers.values())
        words = ", ".join(f"{count} on {model}" for model, count in counts.items())
        yield replace(
            suite,
            runner=partial(study_on, client),
            provenance=lambda command: {**suite.provenance(command), "workers": words},
        )


def study_on(
    client: Any, studies: Mapping[str, Callable[[bool], pd.DataFrame]], quick: bool
) -> Generator[Finished, None, None]:
    """As `reports.build.workers.study_in_workers`, on the workers of this client's scheduler."""
    from distributed import as_completed

    here = _sources()
    futures = {
        client.submit(
            unpickled_call, pickle.dumps(partial(_study, study, quick, here)), pure=False
        ): name
        for name, study in studies.items()
    }
    try:
        for future in as_completed(futures, loop=client.loop):
            result = None if future.exception() is not None else future.result()
            if result is not None:  # else it is studied in this process, where it may raise again
                yield futures[future], *result
    finally:
        client.cancel(list(futures))


def _study(
    study: Callable[[bool], pd.DataFrame], quick: bool, sources: str
) -> tuple[pd.DataFrame, float] | None:
    """None also where the worker, which came later, has other sources or versions."""
    return timed(study, quick) if _sources() == sources else None


def _identity() -> tuple[str, str]:
    return _sources(), cpu()


@cache  # what this process has imported, not what was written since
def _sources() -> str:
    return digest_of_sources(("reports",), machine=False)
