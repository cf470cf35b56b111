"""`verify`: run the claims, write claims.csv with their frames and tables, print the rows."""

from __future__ import annotations

from collections.abc import Sequence

from reports.atomic import write
from reports.claims_table import claims_frame, readable_claims
from reports.convergence_table import convergence_frame
from reports.order import Order
from reports.origins import note_origin
from reports.suite import Suite
from reports.summary import Summary, summary
from reports.tables import as_csv, write_table
from reports.terminal import show
from reports.verification import Checked, check


def verify(suite: Suite, order: Order) -> list[Checked]:
    """Check the chosen claims, all when none is chosen; write, print, and return what came out."""
    chosen = [claim for claim in suite.claims if not order.claims or claim.id in order.claims]
    checked = check(chosen, suite.make_method, order.quick)
    _write(checked, suite, order)
    show(verdicts(checked))
    return checked


def verdicts(checked: Sequence[Checked]) -> Summary:
    return summary(row for one in checked for row in one.rows)


def _write(checked: Sequence[Checked], suite: Suite, order: Order) -> None:
    rows = [row for one in checked for row in one.rows]
    table = claims_frame(rows)
    write(order.out / "claims.csv", as_csv(table))
    note_origin(order.out, "claims.csv", suite.provenance(order.command), order.quick)
    write_table(order.out / "tables", "claims", table, readable_claims(rows))
    write_table(order.out / "tables", "convergence", convergence_frame(checked))
    for one in checked:
        path = order.out / "frames" / f"{one.claim.id}.csv"
        if one.frame is None:
            path.unlink(missing_ok=True)
        else:
            write(path, as_csv(one.frame))
