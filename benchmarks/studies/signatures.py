"""Errors of each peer at a few settings, to notice a new version that computes other motions.

    python -m benchmarks.studies.signatures --write FILE     what the installed engines do
    python -m benchmarks.studies.signatures FILE             the same, compared with a file

`make newest` does the first with the newest engines in an environment of their own, and the second
with those of constraints.txt; exit 1 where they differ.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from benchmarks.store.atomic import write
from benchmarks.store.provenance import versions
from benchmarks.work_precision.asked import code_of
from benchmarks.work_precision.participants import readable_setting
from benchmarks.work_precision.problems import work_precision_problems
from references.rebound.native import Native

CASES = ("kepler e=0.6", "outer solar system", "free rigid body", "3D pendulum, m g = 9.81")
ENGINES = ("rebound", "mujoco-core", "heyoka", "scipy")
KEYS = ["problem", "contender", "settings"]
LEAST_ERROR = 1e-10  # errors below it are no signature
CHANGED_RATIO = 1.02  # ratio of errors from which a code moves otherwise


def signatures() -> pd.DataFrame:
    """A row for each peer's coarsest setting on each of CASES in its quick form.

    The columns are KEYS, error (at the end), status (the reason where it fails or is missing) and
    engines (their versions). Builds for one processor are omitted.
    """
    rows = []
    for case in work_precision_problems(quick=True):
        if case.problem.name not in CASES:
            continue
        truth = case.truth().end
        for label, contender, settings in case.participants:
            if code_of(label) == "galvi" or isinstance(contender, Native):
                continue
            row = {
                "problem": case.problem.name,
                "contender": label,
                "settings": readable_setting(settings[0]),
                "error": float("nan"),
            }
            try:
                run = contender.run(case.problem, case.duration, settings[0])
                row["status"] = "" if run.success else run.status
                if run.success:
                    row["error"] = case.distance(run.q[-1], truth)
            except Exception as error:  # whatever a new version does
                row["status"] = f"{type(error).__name__}: {error}"
            rows.append(row)
    engines = {name: text for name, text in versions().items() if name in ENGINES}
    text = ", ".join(f"{name} {version}" for name, version in engines.items())
    return pd.DataFrame(rows).assign(engines=text)


def differences(current: pd.DataFrame, reference: pd.DataFrame) -> Iterator[str]:
    """A sentence for each row of `current` that is missing in `reference`, fails in one of them
    only, or has another error there."""
    indexed = reference.set_index(KEYS)
    for row in current.to_dict("records"):
        name = ", ".join(row[key] for key in KEYS)
        key = tuple(row[key] for key in KEYS)
        if key not in indexed.index:
            yield f"{name}: not there."
            continue
        before, after = (
            max(error, LEAST_ERROR) for error in (row["error"], indexed.loc[key, "error"])
        )
        if bool(row["status"]) != bool(indexed.loc[key, "status"]):
            yield f"{name}: '{row['status']}' became '{indexed.loc[key, 'status']}'."
        elif max(before / after, after / before) > CHANGED_RATIO:
            yield f"{name}: the error {row['error']:.3g} became {indexed.loc[key, 'error']:.3g}."


def main(arguments: list[str]) -> int:
    """Write or compare the signatures; returns the exit status."""
    formatter = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=formatter)
    parser.add_argument("file", type=Path)
    parser.add_argument("--write", action="store_true", help="write the file")
    options = parser.parse_args(arguments)
    if options.write:
        write(options.file, signatures().to_csv(index=False))
        return 0
    if not options.file.is_file():
        parser.error(f"file must be one that --write has written; there is no {options.file}.")
    reference = pd.read_csv(options.file, dtype={"status": str}).fillna({"status": ""})
    current = signatures()
    changes = list(differences(current, reference))
    print(f"{current['engines'].iloc[0]}\n{reference['engines'].iloc[0]}")
    print("\n".join(changes) or f"{len(current)} signatures are the same.")
    return int(bool(changes))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
