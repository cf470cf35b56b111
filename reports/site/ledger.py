"""A directive for the site that shows lines of the papers' ledger, and a role that links claims.

    ```{ledger} H thm. 2.3.1; H (2.8); H 2.3.4 [V4 V14]
    ```

shows the statements whose `where` begins with one of the places, up to the end of a word: "H 2.3"
matches "H 2.3.4", but "H thm. 2.3.1" does not match "H thm. 2.3.10". Brackets narrow a place to
lines of these claims, or, for "-", to lines of no claim. Lines that an earlier table of the page
shows are left out.

    {claim}`V4`

links to a claim's section of the results.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from markupsafe import escape

from benchmarks.claims.statements import Statement, statements
from reports.site.typeset import MINUS, typeset

PLACE = re.compile(r"([^\[\]]+?)(?: \[([^\]]+)\])?")
SUBSCRIPT = re.compile(r"(?<=[^\W\d]|[|)])_(?:\(((?:[^()]|\([^()]*\))+)\)|([^\W_]{1,4})(?!\w))")
NAMES = "alpha beta gamma eta theta lambda mu nu xi pi rho sigma phi psi omega"
GREEK = dict(zip(NAMES.split(), "αβγηθλμνξπρσφψω", strict=True))
LETTER = re.compile(rf"(?<![^\W_])(d?)({'|'.join(GREEK)})(?![^\W\d_])", re.IGNORECASE)
NO_CLAIM = "-"  # in brackets: lines of no claim
CLAIMS = "results/claims.html"
STYLE = Path(__file__).with_name("ledger.css")
HEADINGS = ("where", "what it says", "what became of it")


class Place(NamedTuple):
    """The beginning of a `where`, and the claims, one of which a line must have; () for any."""

    where: str
    claims: tuple[str, ...]

    def matches(self, statement: Statement) -> bool:
        """Whether the statement is at this place and has one of its claims."""
        remainder = statement.where[len(self.where) :]
        return (
            statement.where.startswith(self.where)
            and not remainder[:1].isalnum()
            and (
                not self.claims or not set(self.claims).isdisjoint(statement.claims or (NO_CLAIM,))
            )
        )


def parse_places(argument: str) -> list[Place]:
    """The places of a directive's argument. Raises ValueError for a part that is not a place."""
    locations = []
    for part in argument.split(";"):
        match = PLACE.fullmatch(part.strip())
        if match is None:
            raise ValueError(
                f"a place of the ledger looks like 'H 2.3.4 [V4 V14]'; received {part!r}"
            )
        locations.append(Place(match[1], tuple((match[2] or "").split())))
    return locations


def select_statements(argument: str, shown: Iterable[Statement] = ()) -> list[Statement]:
    """The statements of a directive, in the ledger's order, without those of `shown`.

    Raises ValueError for a malformed place, and for one without a statement."""
    candidates, locations = (
        [statement for statement in statements() if statement not in set(shown)],
        parse_places(argument),
    )
    for location in locations:
        if not any(location.matches(statement) for statement in candidates):
            raise ValueError(
                f"the ledger has no line at {location.where!r} that is not shown above"
            )
    return [
        statement
        for statement in candidates
        if any(location.matches(statement) for location in locations)
    ]


def table(selected: Iterable[Statement], up: str) -> str:
    """The statements as an HTML table; ``up`` is the relative path to the site's folder, '' or
    ending in '/'."""
    head = "".join(f'<th scope="col">{heading}</th>' for heading in HEADINGS)
    body = "\n".join(_line(statement, up) for statement in selected)
    return (
        f'<div class="ledger"><table>\n<thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{body}\n</tbody></table></div>"
    )


def claim_address(claim: str, up: str) -> str:
    """The address of a claim's section; ``up`` as for `table`."""
    return f"{up}{CLAIMS}#{claim}"


def _line(statement: Statement, up: str) -> str:
    links = " ".join(f'<a href="{claim_address(name, up)}">{name}</a>' for name in statement.claims)
    kind = statement.status.replace(" ", "-")
    status = f"{statement.status}, {statement.effect}" if statement.effect else statement.status
    cell = [f'<strong class="{kind}">{escape(status)}</strong>', links, _typeset(statement.why)]
    return (
        f'<tr><th scope="row">{typeset(statement.where)}</th>'
        f"<td>{_typeset(statement.statement)}</td>"
        f"<td>{' '.join(part for part in cell if part)}</td></tr>"
    )


def _typeset(text: str) -> str:
    """As `typeset`, with Greek letters and subscripts, too: names in the ledger are symbols."""
    html = LETTER.sub(_greek, typeset(text))
    return SUBSCRIPT.sub(
        lambda match: f"<sub>{(match[1] or match[2]).replace('-', MINUS)}</sub>", html
    )


def _greek(match: re.Match[str]) -> str:
    letter = GREEK[match[2].lower()]
    return match[1] + (letter.upper() if match[2][0].isupper() else letter)


def setup(app: Any) -> dict[str, Any]:
    """Register the directive and the role with Sphinx."""
    from docutils import nodes
    from sphinx.util.docutils import SphinxDirective, SphinxRole

    def up(docname: str) -> str:
        return "../" * docname.count("/")

    class Ledger(SphinxDirective):
        """Lines of the ledger as a table."""

        required_arguments, final_argument_whitespace = 1, True

        def run(self) -> list[Any]:
            shown = self.env.temp_data.setdefault("ledger", [])
            try:
                selected = select_statements(self.arguments[0], shown)
            except ValueError as wrong:
                raise self.error(str(wrong)) from wrong
            shown += selected
            return [nodes.raw("", table(selected, up(self.env.docname)), format="html")]

    class Claim(SphinxRole):
        """A claim's name, leading to its section."""

        def run(self) -> Any:
            address = claim_address(self.text, up(self.env.docname))
            return [nodes.reference("", self.text, refuri=address)], []

    app.add_directive("ledger", Ledger)
    app.add_role("claim", Claim())
    app.connect("config-inited", lambda _app, config: config.html_static_path.append(str(STYLE)))
    app.add_css_file(STYLE.name)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
