"""One page for a judgement, and its numbers as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from benchmarks.applications.judging.judgement import Judgement
from benchmarks.applications.judging.truth import time_text
from benchmarks.store.atomic import write
from benchmarks.store.cells import as_csv
from galvi import NBody
from reports.judge.pictures import pictures
from reports.judge.sentences import sentences
from reports.tables.html import html_table
from reports.tables.number_format import readable, seconds

HERE = Path(__file__).parent
MOST_PARTS, MOST_MEETINGS = 30, 50
NUMBERS = ("error", "at the end", "time", "quartiles", "energy", "distance", "Hill radii")


def write_judgement(found: Judgement, name: str, facts: Mapping[str, Any], folder: Path) -> Path:
    """Write judge.html, judge.json and the tables; returns the page."""
    write(folder / "judge.json", json.dumps(as_json(found), indent=1) + "\n")
    write(folder / "integrators.csv", as_csv(found.table))
    write(folder / "parts.csv", as_csv(found.parts))
    return write(folder / "judge.html", rendered(found, name, facts))


def as_json(found: Judgement) -> dict[str, Any]:
    """The findings as plain values; null for what is not a finite number."""

    def plain(value: Any) -> Any:
        if isinstance(value, pd.DataFrame):
            return [plain(row) for row in value.to_dict("records")]
        if isinstance(value, Mapping):
            return {str(key): plain(one) for key, one in value.items()}
        if isinstance(value, bool) or (hasattr(value, "dtype") and value.dtype == bool):
            return bool(value)
        if isinstance(value, int | float) or hasattr(value, "dtype"):
            return float(value) if math.isfinite(value) else None
        return str(value)

    return {
        "model": found.problem.name,
        "duration": found.duration,
        "error": found.error,
        "passed": found.passed,
        "truth_agreement": plain(found.truth_agreement),
        "truth": found.source.label,
        "trusted_until": plain(found.trusted_until),
        "engines": list(found.engines),
        "sources": [{"source": one.source.label, "largest": plain(one.largest),
                     "until": plain(one.t[-1]), "stopped": one.stopped}
                    for one in found.agreements],
        "notes": list(found.notes),
        "own": plain(found.own),
        "own_errors": plain(found.own_errors),
        "parts": plain(found.parts),
        "table": plain(found.table),
        "recommended": None if found.recommended is None else plain(found.recommended),
        "encounters": plain(found.encounters),
        "horizons": plain(found.horizons),
        "summary": sentences(found),
    }  # fmt: skip


def rendered(found: Judgement, name: str, facts: Mapping[str, Any]) -> str:
    """The page."""
    best = found.table.drop_duplicates("integrator")  # the first is the best of each
    told = best["error"].notna()
    ends = zip(best["seconds_low"], best["seconds_high"], strict=True)
    spread = [f"{seconds(low)} to {seconds(high)}" if low == low else "" for low, high in ends]
    tried = best.assign(
        error=best["error"].map(readable),
        last_error=best["last_error"].map(readable),
        seconds=best["seconds"].map(seconds),
        seconds_low=spread,
        energy=best["energy"].map(readable),
        reached=best["reached"].map({True: "yes", False: "no"}).where(told, ""),
    ).drop(columns="seconds_high").rename(columns={
        "last_error": "at the end", "seconds": "time", "seconds_low": "quartiles",
    })  # fmt: skip
    tried = tried[[name for name in tried if (tried[name] != "").any()]]
    parts = found.parts.sort_values("largest_error", ascending=False).head(MOST_PARTS)
    parts = parts.assign(**{
        column: parts[column].map(readable) for column in parts.columns[1:]
    }).rename(columns=lambda text: text.replace("_", " "))  # fmt: skip
    meetings = found.encounters.head(MOST_MEETINGS)
    if len(meetings):
        meetings = meetings.assign(
            time=meetings["time"].map(lambda t: time_text(found.truth, t)),
            distance=meetings["distance"].map(readable),
            hill_radii=meetings["hill_radii"].map(readable),
        ).rename(columns={"hill_radii": "Hill radii"})
    ends = found.horizons.assign(
        start_known_to=found.horizons["start_known_to"].map("{:g}".format),
        until=found.horizons["until"].map(
            lambda t: time_text(found.truth, t) if t == t else "beyond the end"
        ),
    ).rename(columns={"start_known_to": "start known to", "until": "predicts until t ="})
    environment = Environment(
        loader=FileSystemLoader(HERE), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    return environment.get_template("judge.html.j2").render(
        css=Markup((HERE / "judge.css").read_text(encoding="utf-8")), name=name,
        sentences=sentences(found), notes=found.notes,
        picture=Markup(pictures(found).decode().partition("<svg")[2].join(["<svg", ""])),
        html_table=html_table, numbers=NUMBERS,
        tried=tried, parts=parts, meetings=meetings, ends=ends,
        part=found.kind.PART, can_meet=len(found.encounters.columns) > 0,
        left_out=max(0, len(found.parts) - MOST_PARTS), meetings_in_all=len(found.encounters),
        facts=facts, samples=found.samples, compared=len(found.own_errors) - 1,
        **{one: found.kind.unit(found.problem, one).strip() for one in ("length", "time")},
        rebuilt=isinstance(found.problem.system, NBody),
    )  # fmt: skip
