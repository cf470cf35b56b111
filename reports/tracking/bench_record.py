"""The head of a comparison as a bench of the history: one file of another project's integrators.

Times are medians of the first round's samples, and the yardstick was timed before and after it, as
`make bench` does for galvi's own; see `reports.tracking.series` for what is read.
"""

from __future__ import annotations

import datetime
import json
import math
import platform
import re
import statistics
import uuid
from pathlib import Path
from typing import Any

from benchmarks.statistics import calibration
from benchmarks.store.atomic import write
from benchmarks.store.provenance import cpu, versions
from reports.tracking.gates import Finding
from reports.tracking.outcome import Outcome
from reports.tracking.project import Checkout


def keep_bench(outcome: Outcome, head: Checkout, folder: Path) -> Path | None:
    """Write FOLDER/MACHINE/DATE_COMMIT_....json; None where nothing was timed on both sides."""
    timed = [one for one in outcome.findings if one.pair.rounds and not one.pair.why]
    if not timed or not math.isfinite(outcome.yardstick):
        return None
    moment = datetime.datetime.now(datetime.UTC)
    content = {
        "machine_info": {
            "cpu": {"brand_raw": cpu()},
            "machine": platform.machine(),
            "system": platform.system(),
            "python_version": platform.python_version(),
        },
        "commit_info": {"id": head.commit or "unknown", "dirty": head.changed},
        "benchmarks": [_bench(one, outcome.yardstick) for one in timed],
        "datetime": moment.isoformat(),
    }
    machine = f"{platform.system()}-{platform.machine()}-Python-{platform.python_version()}"
    name = f"{moment:%Y%m%d_%H%M%S}_{head.commit[:12] or 'unversioned'}"
    name += f"{'_with-changes' * head.changed}_{uuid.uuid4().hex[:8]}.json"
    path = folder / re.sub(r"[^A-Za-z0-9._-]", "-", machine) / name
    return write(path, json.dumps(content, indent=1) + "\n")


def _bench(finding: Finding, seconds: float) -> dict[str, Any]:
    case, reached = finding.pair.case, finding.pair.reached["head"]
    error = finding.errors[1]
    return {
        "name": finding.name,
        "stats": {"median": statistics.median(finding.pair.rounds[0]["head"])},
        "extra_info": {
            "kind": case.kind,
            "problem": case.problem,
            "error": error if math.isfinite(error) else None,
            "counts": reached["counts"],
            "status": reached["status"],
            "first_call": reached["first_call"],
            "error_tolerance": case.error_tolerance,
            "settings": {key: str(value) for key, value in case.setting.items()},
            "versions": versions(),
            "yardstick": {"name": calibration.NAME, "seconds": seconds},
        },
    }
