"""What `python -m reports track` does with its options."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence

import typer

from benchmarks.timings.case import Case
from benchmarks.timings.catalogue import CASES
from references.setting import nearest
from reports.results.options import Options
from reports.tracking.trees import CannotCompare


def track_command(
    order: Options, provenance: Mapping[str, str], against: str | None, only: Sequence[str],
    isolate: bool,
) -> int:  # fmt: skip
    """The history, or a comparison with a revision; 1 when that got worse, 2 when it cannot be.

    Raises typer.BadParameter for options that do not go together and for an unknown benchmark.
    """
    if against is not None and not against.strip():
        raise typer.BadParameter(
            "--against expects a commit, a branch or a tag; received nothing: is a variable empty?"
        )
    if against is None:
        if only or isolate:
            raise typer.BadParameter("--only and --isolate go with --against REV.")
        from reports.tracking.record import track

        return track(order.out, dict(provenance))
    from reports.tracking.against import track_against

    try:
        cases = choose_cases(only, order.quick)
        return track_against(against, cases, order.out, dict(provenance), isolate)
    except CannotCompare as error:
        print(error, file=sys.stderr)
        return 2


def choose_cases(only: Sequence[str], quick: bool) -> tuple[Case, ...]:
    """Those whose name has one of the texts in it, of the quick ones or of all."""
    known = [case for case in CASES if case.quick or only or not quick]
    for text in only:
        if not any(text.lower() in case.name.lower() for case in known):
            names = [case.name for case in CASES]
            raise typer.BadParameter(
                f"there is no benchmark with {text!r} in its name; "
                f"did you mean {nearest(text, names)!r}?"
            )
    return tuple(
        case
        for case in known
        if not only or any(text.lower() in case.name.lower() for text in only)
    )
