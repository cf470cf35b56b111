"""Claims as documents: each claim is a section with a table of checks, which has a line per row.

A document follows a paper: "## 2.3.1 Existence and uniqueness" is a part of it, with a table of
the statements there (see `benchmarks.claims.statements`) and with sections of claims:

    ### V12: The stage equations have one solution below a step

    What the paper says, and what was measured where that differs.

    - measured by: vector_spaces.v12_stage_iteration_contracts
    - source: H thm. 2.3.1

    | quantity | bound | claimed | caught |
    | --- | --- | --- | --- |
    | measured limit / bound, n = {4; 8; 16} | at least 1 | contracts below the bound | C 1e-7 |

Lines "- name: text" are defaults of the columns of the same name (FIELDS), or OPTIONS of the claim;
before a further table they are defaults, FIELDS only, of its lines alone. Other paragraphs are
notes; any other line is refused. An empty cell has the default, and a cell with one quotation mark
(") has the content of the cell above it; a text that begins with "+ " is appended to the default.
Braces with semicolons repeat a line: lists of the same length are paired, lists of different
lengths are combined, the first outermost. `{name}`, or `{name:.0e}`, is replaced by a measured
number; its name may contain a list, as in `{law_{50; 500}}`.

"measured by" names a module or "module:object" that has one function, or two:

measure(make_method, quick, report) -> {quantity: number, why there is none, or a Number}
study(make_method, quick, report) -> tidy table, and read(table) -> {quantity: measurement}

Every measured quantity needs a line of the table, and every line a measured quantity; numbers that
occur as `{name}` need no line.

bound   see `bound_of`
caught  planted faults, separated by semicolons, that must contradict this line: arrays of the
        method's table with their relative error, "C 1e-7", or names in the module's FAULTS
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, partial
from importlib import import_module
from itertools import product, starmap
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.checks import bounds, series_bounds
from benchmarks.checks.bounds import NOT_RUN, VERDICTS, Bound
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row, checked_row
from benchmarks.checks.faults import Fault, faulty
from benchmarks.statistics.estimate import Measurement
from benchmarks.store.tables import row, table_of

FOLDER = Path(__file__).parent
DOCUMENT_NAMES = ("hall_1", "hall_2", "hall_3", "hall_4", "miglio", "own", "agreements")
FIELDS = ("source", "setup", "claimed", "expected", "reason", "reference")
OPTIONS = ("measured by", "figures", "alone")
COLUMNS = ("quantity", "bound", *FIELDS, "caught")
PART_HEADING = re.compile(r"^## (.+)$", re.MULTILINE)
SECTION_HEADING = re.compile(r"^### ([VLA]\d+): (.+)$", re.MULTILINE)
DEFAULT_LINE = re.compile(rf"^- ({'|'.join((*FIELDS, *OPTIONS))}): ((?:.|\n(?=  ))+)", re.MULTILINE)
NOT_PROSE = re.compile(r"^[-*+#| \t].*\S.*$", re.MULTILINE)
LIST_PATTERN = re.compile(r"\{([^{}]*;[^{}]*)\}")
NUMBER_PATTERN = re.compile(r"\{([a-z]\w*)(?::([^{};]+))?\}")
ARRAYS_PATTERN = re.compile(r"(?:\w+ [-+\d.e]+ ?)+")
LIMIT_BOUNDS = {
    "at most": bounds.AtMost,
    "at least": bounds.AtLeast,
    "above": bounds.Above,
    "below": bounds.Below,
    "exactly": bounds.Exactly,
    "each n at most": series_bounds.FactorPerN,
    "no growth at most": series_bounds.NoGrowth,
}
VALUE_BOUNDS = {"": bounds.Near, "order ": bounds.Order, "base ": bounds.Base}
PLAIN_BOUNDS = {"converges": bounds.Converges, "geometric": series_bounds.Geometric}
NAN = float("nan")


@dataclass(frozen=True)
class Number:
    """A measured number.

    Attributes
    ----------
    value
        NaN without a number
    reference
        the reference that it was compared with, which replaces the document's text
    absent
        the missing package without which it cannot be measured; "not run" is then expected
    why
        the reason for a missing number
    """

    value: float = NAN
    reference: str = ""
    absent: str = ""
    why: str = ""

    def texts(self) -> dict[str, str]:
        """Texts by column of its row, which replace those of the document."""
        texts = {"reference": self.reference} if self.reference else {}
        if self.absent:
            texts |= {"expected": NOT_RUN, "reason": self.why, "absent": self.absent}
        return texts


@dataclass(frozen=True)
class Section:
    """A section of a document.

    Attributes
    ----------
    statement
        the text before the defaults
    notes
        the paragraphs after the defaults
    defaults
        texts of FIELDS and OPTIONS
    lines
        for each row, its texts by column
    """

    id: str
    title: str
    statement: str
    notes: str
    defaults: Mapping[str, str]
    lines: tuple[Mapping[str, str], ...]

    @property
    def numbers_in_texts(self) -> set[str]:
        """The names in braces, of measured numbers that need no row."""
        texts = [text for line in self.lines for text in line.values()]
        return {match[1] for text in texts for match in NUMBER_PATTERN.finditer(text)}


@dataclass(frozen=True)
class Part:
    """The part of a document under one heading of a paper.

    Attributes
    ----------
    text
        the text before the tables and sections
    statements
        for each printed statement, its texts by column
    sections
        the sections of claims
    """

    title: str
    text: str
    statements: tuple[Mapping[str, str], ...]
    sections: tuple[Section, ...]


@dataclass(frozen=True)
class Document:
    """A document: its first heading, the text below that, and its parts."""

    title: str
    text: str
    parts: tuple[Part, ...]


def all_documents() -> tuple[Document, ...]:
    """All documents, in the order of DOCUMENT_NAMES."""
    return tuple(read_document(FOLDER / f"{name}.md") for name in DOCUMENT_NAMES)


@cache
def read_document(path: Path) -> Document:
    """Read the document in a file. Raises ValueError for a line that is not allowed there."""
    head, *parts = PART_HEADING.split(path.read_text(encoding="utf-8"))
    title, _, text = head.removeprefix("# ").partition("\n")
    return Document(title, _prose(path.name, text), tuple(starmap(_part, _pairs(parts))))


def _part(title: str, text: str) -> Part:
    before, *headed = SECTION_HEADING.split(text)
    prose, *tables = _tables(before)
    _prose(title, "".join(tables[1::2]))
    sections = zip(headed[::3], headed[1::3], headed[2::3], strict=True)
    statements = tuple(cells for table in tables[::2] for cells in table_in(title, table))
    return Part(title, _prose(title, prose), statements, tuple(starmap(_section, sections)))


def _prose(location: str, text: str) -> str:
    """The text on one line. Raises ValueError for a line that is not prose."""
    if line := NOT_PROSE.search(text):
        raise ValueError(
            f"{location}: a line is prose, a heading '### V1: title', a default '- name: text', of "
            f"which a name is of {(*FIELDS, *OPTIONS)}, or of a table; received {line[0]!r}."
        )
    return " ".join(text.split())


def _pairs(texts: Sequence[str]) -> Iterator[tuple[str, str]]:
    return zip(texts[::2], texts[1::2], strict=True)


def _tables(text: str) -> list[str]:
    """The text before the first table, and each table with the text after it."""
    return re.split(r"((?:^\|.*\n)+)", f"{text}\n", flags=re.MULTILINE)


def _section(id: str, title: str, text: str) -> Section:
    before, *tables = _tables(text)
    statement = re.split(r"^- ", before, maxsplit=1, flags=re.MULTILINE)[0]
    defaults = _defaults(id, before)
    table_defaults: Mapping[str, str] = {}
    lines: list[dict[str, str]] = []
    for table, after in _pairs(tables):
        for cells in table_in(id, table):
            lines += _expand_lists(_override(_override(defaults, table_defaults), cells))
        table_defaults = _defaults(id, after)
        if unused := table_defaults.keys() - {*FIELDS} or (
            table_defaults.keys() if after is tables[-1] else ()
        ):
            raise ValueError(f"{id}: no table after it has the default {sorted(unused)}.")
    _require_complete(id, defaults, lines)
    paragraphs = [before.removeprefix(statement), *tables[1::2]]
    notes = " ".join(" ".join(DEFAULT_LINE.sub("", text).split()) for text in paragraphs).strip()
    return Section(id, title, " ".join(statement.split()), notes, defaults, tuple(lines))


def _require_complete(
    id: str, defaults: Mapping[str, str], lines: Sequence[Mapping[str, str]]
) -> None:
    """Raise ValueError for a section without "measured by", for an unknown column, for a line
    without a quantity or with an invalid verdict or bound, and for a repeated quantity."""
    if "measured by" not in defaults:
        raise ValueError(f"{id}: '- measured by: module' is missing.")
    for line in lines:
        if unknown := line.keys() - {*COLUMNS}:
            raise ValueError(f"{id}: a table has columns of {COLUMNS}; received {sorted(unknown)}.")
        if not {"quantity", "bound"} <= line.keys():
            raise ValueError(f"{id}: a line needs a quantity and a bound; received {dict(line)}.")
        if line.get("expected", NOT_RUN) not in VERDICTS:
            raise ValueError(f"{id}: expected is of {VERDICTS}; received {line['expected']!r}.")
        try:
            bound_of(_with_numbers(line["bound"], {}, "r"))
        except ValueError as error:
            raise ValueError(f"{id}, {line['quantity']}: {error}") from None
    quantities = Counter(line["quantity"] for line in lines)
    if repeated := [quantity for quantity, count in quantities.items() if count > 1]:
        raise ValueError(
            f"{id}: each quantity needs a line of its own; repeated: {repeated}. Lists of "
            "different lengths are combined."
        )


def _override(texts: Mapping[str, str], overrides: Mapping[str, str]) -> dict[str, str]:
    """Texts by column, without OPTIONS; a text in `overrides` replaces that in `texts` or, after a
    plus, is appended to it."""
    joined = {name: text for name, text in texts.items() if name not in OPTIONS}
    for name, text in overrides.items():
        if text.startswith("+ "):
            joined[name] = "; ".join(filter(None, (joined.get(name, ""), text[2:])))
        elif text:
            joined[name] = text
    return joined


def _defaults(id: str, text: str) -> dict[str, str]:
    _prose(id, DEFAULT_LINE.sub("", text))
    defaults = [(match[1], " ".join(match[2].split())) for match in DEFAULT_LINE.finditer(text)]
    if len(defaults) > len(dict(defaults)):
        names = [name for name, _ in defaults]
        raise ValueError(f"{id}: a default is said once; received {names}.")
    return dict(defaults)


def table_in(location: str, text: str) -> Iterator[dict[str, str]]:
    """The lines of a Markdown table, each as texts by column, where a quotation mark is replaced by
    the cell above. Raises ValueError, with the location, for a malformed table."""
    head, *below = [
        [cell.strip().replace(r"\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        for line in text.splitlines()
    ]
    has_rule = below and all(re.fullmatch(":?-+:?", cell) for cell in below[0])
    if not has_rule or len({*head}) < len(head):
        raise ValueError(
            f"{location}: a table has a head of different names and below it '| --- |' for each; "
            f"received {text.splitlines()[:2]}."
        )
    above: dict[str, str] = {}
    for cells in below[1:]:
        if len(cells) != len(head) or ('"' in cells and not above):
            raise ValueError(
                f"{location}: a line has a cell for each of {head}; a cell of a quotation mark "
                f"repeats the one above, and a bar in a text is '\\|'; received {cells}."
            )
        above = {
            name: above[name] if cell == '"' else cell
            for name, cell in zip(head, cells, strict=True)
        }
        yield dict(above)


def _expand_lists(cells: Mapping[str, str]) -> Iterator[dict[str, str]]:
    """A line for each combination of the entries of the lists in its cells."""
    lists = [
        match[1].split(";") for cell in cells.values() for match in LIST_PATTERN.finditer(cell)
    ]
    lengths = list(dict.fromkeys(map(len, lists)))
    for choice in product(*map(range, lengths)):
        index = dict(zip(lengths, choice, strict=True))

        def chosen(match: re.Match[str], index: Mapping[int, int] = index) -> str:
            items = match[1].split(";")
            return items[index[len(items)]].strip()

        yield {name: LIST_PATTERN.sub(chosen, cell) for name, cell in cells.items()}


def bound_of(text: str) -> Bound:
    """The bound that a cell describes:

        at most 1 | at least 1 | above 0 | below 1 | exactly 3 | 0.5 to 2 | 1 within 0.1
        order 4 | order 4 within 0.1 | base 0.56 within 0.01 | converges | geometric
        each n at most 0.5 | no growth at most 1e-3

    with terms after semicolons:

        rounding 1e-12   tolerance for rounding
        errors           two standard errors are tolerated; with `errors 0.1` also those of the
                         bound itself, 0.1
        errors up to 1   at most that much is tolerated
        either side      a better order or base is a contradiction, too
        even if short    a run that is too short to show growth has a verdict nevertheless
        in words: about  a text before the number

    `A or B` is A, which the source measured, or else B, our own value; `finding` alone, or
    `finding: A`, is for a quantity on which the source says nothing. Raises ValueError for any
    other text.
    """
    if match := re.fullmatch(r"finding(?:: (.+))?", text):
        return bounds.Finding(bound_of(match[1]) if match[1] else None)
    if " or " in text:
        return bounds.Reported(*map(bound_of, text.split(" or ", maxsplit=1)))
    head, *terms = text.split("; ")
    try:
        return _bound_without_terms(head)(
            **{key: value for term in terms for key, value in _term(term).items()}
        )
    except (TypeError, ValueError, ZeroDivisionError):  # also: a term that is not of this bound
        raise ValueError(
            f"a bound, and each of its terms, is one of those of bound_of; received {text!r}."
        ) from None


def _bound_without_terms(text: str) -> Callable[..., Bound]:
    """The constructor of the bound that a text without terms describes. Raises ValueError."""
    if text in PLAIN_BOUNDS:
        return PLAIN_BOUNDS[text]
    if match := re.fullmatch(rf"({'|'.join(LIMIT_BOUNDS)}) (\S+)", text):
        return partial(LIMIT_BOUNDS[match[1]], _number(match[2]))
    if match := re.fullmatch(r"(order |base |)(\S+)(?: within (\S+))?", text):
        resolution = [_number(match[3])] if match[3] else []
        return partial(VALUE_BOUNDS[match[1]], _number(match[2]), *resolution)
    if match := re.fullmatch(r"(\S+) to (\S+)", text):
        return partial(bounds.Within, _number(match[1]), _number(match[2]))
    raise ValueError(text)


def _term(text: str) -> dict[str, Any]:
    if match := re.fullmatch(r"in words: (.+)", text):
        return {"noun": match[1]}
    match text.split():
        case ["rounding", size]:
            return {"round_off": _number(size)}
        case ["errors"]:
            return {"uncertainty": 0.0}
        case ["errors", "up", "to", largest]:
            return {"uncertainty": 0.0, "largest_tolerance": _number(largest)}
        case ["errors", size]:
            return {"uncertainty": _number(size)}
        case ["either", "side"]:
            return {"better": 0}
        case ["even", "if", "short"]:
            return {"conclusive": False}
    raise ValueError(text)


def _number(text: str) -> float:
    """The number of a text such as '0.5', '1e-3', '1/3' or 'nan'."""
    return NAN if text == "nan" else float(Fraction(text))


def claim_of(section: Section) -> Claim:
    """The claim of a section, with the functions of the module that measures it."""
    module = measuring_object(section)
    has_measure = hasattr(module, "measure")
    return Claim(
        section.id,
        section.title,
        partial(_table_of_numbers, module, section.id) if has_measure else module.study,
        partial(_rows_of_table, section, numbers_of if has_measure else module.read),
        figures=tuple(filter(None, section.defaults.get("figures", "").split("; "))),
        timed="alone" in section.defaults,
        statement=section.statement,
        notes=section.notes,
        caught=tuple(_faults(section, module)),
    )


def measuring_object(section: Section) -> Any:
    """The module, or the object in a module, that "measured by" names.

    Raises ValueError for a name without functions that measure."""
    name, _, attribute = section.defaults["measured by"].partition(":")
    module_name, module = f"{__package__}.{name}", None
    try:
        module = import_module(module_name)
    except ModuleNotFoundError as error:
        if not module_name.startswith(
            error.name or module_name
        ):  # the module exists, but an import in it failed
            raise
    measuring = getattr(module, attribute, None) if attribute else module
    if not (hasattr(measuring, "measure") or hasattr(measuring, "study")):
        raise ValueError(
            f"{section.id}: 'measured by' names a module in {__package__}, or module:object, with "
            f"measure, or study and read; received {section.defaults['measured by']!r}."
        )
    return measuring


def _table_of_numbers(
    module: Any, id: str, make_method: MakeMethod, quick: bool, report: Report
) -> pd.DataFrame:
    """The tidy table of the numbers that a module's `measure` returns."""
    rows = []
    for quantity, number in module.measure(make_method, quick, report).items():
        if isinstance(number, str):
            number = Number(why=number)
        elif not isinstance(number, Number):
            number = Number(_float(f"{id}, {quantity}", number))
        rows.append(
            row(
                study=id,
                quantity=quantity,
                value=number.value,
                label=number.reference,
                status=number.why,
                absent=number.absent,
            )
        )
    return table_of(rows)


def _float(location: str, number: Any) -> float:
    try:
        return float(number)
    except TypeError:
        raise TypeError(
            f"{location}: measure gives numbers, sentences or Numbers; received {number!r}."
        ) from None


def numbers_of(table: pd.DataFrame) -> dict[str, Number]:
    """The numbers of a table by quantity."""
    return {
        line.quantity: Number(line.value, line.label, line.absent, line.status)
        for line in table.itertuples()
    }


def _rows_of_table(
    section: Section,
    read: Callable[[pd.DataFrame], Mapping[str, Measurement | Number]],
    table: pd.DataFrame,
) -> list[Row]:
    """The rows of a section; for an empty table, those of numbers that were not measured.

    Raises ValueError for a measured number without a line, and for a line without its number.
    """
    quantities = [line["quantity"] for line in section.lines]
    numbers = dict.fromkeys(quantities, NAN) if table.empty else read(table)
    names_in_texts = section.numbers_in_texts
    without_line = numbers.keys() - {*quantities} - names_in_texts
    needed = [*quantities, *(() if table.empty else sorted(names_in_texts))]
    if (without_number := [name for name in needed if name not in numbers]) or without_line:
        raise ValueError(
            f"{section.id}: every number that is measured needs a line of the table, and every "
            f"line, and each name in braces, its number; without a line: {sorted(without_line)}; "
            f"without a number: {without_number}."
        )
    return [_row(section, line, numbers) for line in section.lines]


def _row(section: Section, line: Mapping[str, str], numbers: Mapping[str, Any]) -> Row:
    measured = numbers[line["quantity"]]
    texts = {name: _with_numbers(line[name], numbers, "g") for name in FIELDS if name in line}
    if isinstance(measured, Number):
        texts |= measured.texts()
        measured = measured.value
    bound = bound_of(_with_numbers(line["bound"], numbers, "r"))
    return checked_row(section.id, line["quantity"], bound, measured, **texts)


def _with_numbers(text: str, numbers: Mapping[str, Any], plain: str) -> str:
    """The text with numbers in place of names in braces; `plain` is the default format, where "r"
    stands for `repr` in any case."""

    def number(match: re.Match[str]) -> str:
        measured = numbers.get(match[1], NAN)
        value = measured.value if isinstance(measured, Number) else float(measured)
        return repr(value) if plain == "r" else format(value, match[2] or plain)

    return NUMBER_PATTERN.sub(number, text)


def _faults(section: Section, module: Any) -> Iterator[Fault]:
    """The planted faults of a section, each with the quantities of the lines that name it.

    Raises ValueError for an unknown fault.
    """
    quantities_of: dict[str, set[str]] = {}
    for line in section.lines:
        for name in filter(None, line.get("caught", "").split("; ")):
            quantities_of.setdefault(name, set()).add(line["quantity"])
    for name, quantities in quantities_of.items():
        if ARRAYS_PATTERN.fullmatch(name):
            fields = name.split()
            scale = {array: 1.0 + float(by) for array, by in zip(*[iter(fields)] * 2, strict=True)}
            yield Fault(faulty(**scale), name=name, contradicted=quantities)
        elif name in (by_name := getattr(module, "FAULTS", {})):
            yield replace(by_name[name], name=name, contradicted=quantities)
        else:
            raise ValueError(
                f"{section.id}: what is caught is an array and by how much it is wrong, as "
                f"'C 1e-7', or one of FAULTS, {[*by_name]}; received {name!r}."
            )


def claims_in(document: Document) -> tuple[Claim, ...]:
    """The claims of a document, in its order."""
    return tuple(claim_of(section) for part in document.parts for section in part.sections)
