"""What the suite finds in peers, version by version: docs/engine_versions.csv and docs/defects.csv.

    python -m benchmarks.experiments.engine_defects STUDIES

with the folder of a report's long studies (`galvi studies --only engine-versions` has been run).
The first file keeps, of each version of MuJoCo, how each integrator turns a free body; the second
what follows from it, and what was seen of REBOUND's installed version.
"""

from __future__ import annotations

import datetime
import sys
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.statistics.convergence_fits import algebraic
from benchmarks.store.atomic import write
from benchmarks.store.provenance import ROOT
from benchmarks.studies.engine_versions import NESTED, NESTED_ON, engine_versions, stored
from references.rebound import defects as of_rebound
from references.rebound.simulation import version as rebound_version

VERSIONS, DEFECTS = ROOT / "docs" / "engine_versions.csv", ROOT / "docs" / "defects.csv"
ROUND_OFF, SHOWN = 1e-12, 0.0125  # of attitudes, not fitted; and the step of the errors
OTHERWISE = 1.05  # ratio of errors from which two bodies, or versions, move otherwise
ORDERS = {"RK4": 4}  # of convergence, by the engine's documentation; else 1
DEFECT, CHANGE = "defect", "change"
OF_VERSIONS = "galvi studies --only engine-versions"
HERE = "python -m benchmarks.experiments.engine_defects STUDIES"


def signatures(frame: pd.DataFrame) -> pd.DataFrame:
    """Of the rows of `benchmarks.studies.engine_versions`, one for each engine, integrator and
    joint: the fitted order of the attitude's error, and both errors at the step SHOWN."""
    rows = []
    known = frame[frame["status"] == ""]
    for keys, runs in known.groupby(["engine", "integrator", "joint"], sort=False):
        runs = runs.sort_values("step", ascending=False)
        fit = algebraic(list(runs["step"]), list(runs["attitude_error"]), floor=ROUND_OFF)
        (at,) = runs[np.isclose(runs["step"], SHOWN)].to_dict("records")
        errors = {name: float(f"{at[name]:.2e}") for name in ("attitude_error", "energy_error")}
        rows.append([*keys, round(fit.rate, 2), *errors.values(), at["date"]])
    columns = ["engine", "integrator", "joint", "order", "attitude_error", "energy_error", "date"]
    return pd.DataFrame(rows, columns=columns)


def of_versions(table: pd.DataFrame) -> Iterator[tuple[str, str, str]]:
    """(what, versions, seen) of the defects that `signatures` show, versions from old to new."""
    engines = list(table["engine"].drop_duplicates())
    for integrator, rows in table.groupby("integrator", sort=False):
        promised = ORDERS.get(str(integrator), 1)
        low = rows[rows["order"] < promised - 0.5]
        if len(low):
            yield (
                f"{integrator} turns a body with order {low['order'].iloc[-1]:.2g} instead of "
                f"{promised} ({'; '.join(low['joint'].drop_duplicates())})",
                span(list(low["engine"]), engines),
                f"attitude error {low['attitude_error'].iloc[-1]:.1e} at a step of {SHOWN:g}",
            )
    for integrator, rows in table.groupby("integrator", sort=False):
        errors = rows.pivot(index="engine", columns="joint", values="attitude_error")
        if {NESTED, NESTED_ON} <= set(errors):
            pairs = errors[[NESTED, NESTED_ON]].dropna()
            apart = _ratio(pairs[NESTED], pairs[NESTED_ON]) > OTHERWISE
            names = [one for one in engines if one in set(pairs.index[apart])]
            if names:
                worst = _ratio(pairs[NESTED], pairs[NESTED_ON]).idxmax()
                told = pairs.loc[worst]
                yield (
                    f"{integrator} moves a free body otherwise when half of its inertia is in a "
                    "body that is fixed in it",
                    span(names, engines),
                    f"in {str(worst).split()[-1]} attitude error {told[NESTED]:.3g} nested, "
                    f"{told[NESTED_ON]:.3g} in one body, at a step of {SHOWN:g}",
                )


def changes(table: pd.DataFrame) -> Iterator[tuple[str, str, str]]:
    """(what, versions, seen) of the integrators that turn a body otherwise from one version to the
    next: no defect in itself, but results are not those of before."""
    engines = list(table["engine"].drop_duplicates())
    for before, after in pairwise(engines):
        old, new = (
            table[table["engine"] == one].set_index(["integrator", "joint"])["attitude_error"]
            for one in (before, after)
        )
        both = old.index.intersection(new.index)
        moved = both[(_ratio(old[both], new[both]) > OTHERWISE).to_numpy()]
        for integrator in dict.fromkeys(moved.get_level_values(0)):
            said = [
                f"{joint} {old[integrator, joint]:.3g} to {new[integrator, joint]:.3g}"
                for name, joint in moved
                if name == integrator
            ]
            yield (
                f"{integrator} turns a free body otherwise",
                f"{before} to {after.split()[-1]}",
                f"attitude error at a step of {SHOWN:g}: {'; '.join(said)}",
            )


def span(names: Sequence[str], engines: Sequence[str]) -> str:
    """E.g. "mujoco 3.6.0 to 3.10.0; ran: 3.6.0, 3.10.0, 4.0.1"; those between are named where not
    all of them are meant."""
    ran = [one.split()[-1] for one in engines]
    has = [one.split()[-1] for one in dict.fromkeys(names)]
    whole = ran[ran.index(has[0]) : ran.index(has[-1]) + 1] == has
    said = " to ".join(dict.fromkeys((has[0], has[-1]))) if whole else ", ".join(has)
    return f"{names[0].split()[0]} {said}; ran: {', '.join(ran)}"


def _ratio(a: pd.Series, b: pd.Series) -> pd.Series:
    return np.maximum(a / b, b / a)


def defects(table: pd.DataFrame) -> pd.DataFrame:
    """kind, what, versions, seen, command: defects that the versions show and that are seen now,
    then changes from version to version."""
    now = ((name, rebound_version(), seen) for name, seen in of_rebound.seen().items() if seen)
    rows = [(DEFECT, *one, OF_VERSIONS) for one in of_versions(table)]
    rows += [(DEFECT, *one, HERE) for one in now]
    rows += [(CHANGE, *one, OF_VERSIONS) for one in changes(table)]
    return pd.DataFrame(rows, columns=["kind", "what", "versions", "seen", "command"])


def main(folder: Path) -> None:
    """Write both files from the rows that are kept there, and print the second."""
    today = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")
    installed = engine_versions().assign(date=today)
    older = stored(folder, print)
    older = older[~older["engine"].isin(installed["engine"])]
    table = signatures(pd.concat([older, installed], ignore_index=True))
    write(VERSIONS, table.to_csv(index=False))
    found = defects(table).assign(date=today)
    write(DEFECTS, found.to_csv(index=False))
    print(found.to_string())


if __name__ == "__main__":
    main(Path(sys.argv[1]))
