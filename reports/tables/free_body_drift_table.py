"""What turning for long leaves of energy, angular momentum and attitude, as text for the page."""

from __future__ import annotations

import numpy as np
import pandas as pd

from reports.tables.number_format import capital, readable

KEYS = ["problem", "contender", "engine", "step", "turns", "commit"]
WORDS = ("body", "contender", "engine", "status", "commit", "date")
FEWEST = 4  # marks that a growth is fitted over
ROUND_OFF = 1e-13  # energy errors up to it may be a single random walk, which has no exponent


def free_spin_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each run, and how to set the columns.

    Errors are those of the last mark, or of the last that a failed run came to, which its turns
    tell. The energy grows as turns^x, fitted over the later half of the marks, where it is not
    round-off.
    """
    lines = []
    for (problem, contender, engine, step, turns, commit), rows in frame.groupby(
        KEYS, sort=False, dropna=False
    ):
        run = rows.sort_values("turn")
        known = run[run["energy_error"].notna()]
        last = (known if len(known) else run).iloc[-1]
        reached = last["turn"] if len(known) else turns
        lines.append(
            {
                "body": capital(problem),
                "contender": contender,
                "engine": engine,
                "step": readable(step),
                "turns": readable(reached),
                "energy, relative": readable(last["energy_error"], 2),
                "grows as turns^": _growth(known),
                "angular momentum": readable(last["momentum_error"], 2),
                "attitude": readable(last["attitude_error"], 2),
                "status": run["status"].iloc[-1],
                "commit": commit,
                "date": run["date"].iloc[-1],
            }
        )
    table = pd.DataFrame(lines)
    empty = [name for name in table if not (table[name] != "").any()]
    return table.drop(columns=empty), {
        name: "number" for name in table if name not in (*WORDS, *empty)
    }


def _growth(run: pd.DataFrame) -> str:
    """Slope of the logarithms over the later half of the marks."""
    later = run.iloc[len(run) // 2 :]
    size = np.abs(later["energy_error"].to_numpy(float))
    if len(later) < FEWEST:
        return ""
    if not np.max(size) > ROUND_OFF:
        return "round-off"
    return readable(float(np.polyfit(np.log(later["turn"]), np.log(size), 1)[0]), 2)
