"""The links of the built pages: those inside must lead somewhere, those outside are listed."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from benchmarks.work_precision.run import problems
from reports.contents import CHECKS, SECTIONS
from reports.figures.drawing import slug
from reports.page.render import PARTS

OUTSIDE = "external_links.txt"


class Page(HTMLParser):
    """What a page defines and what it refers to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.targets: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Called for each tag."""
        for name, value in attrs:
            if name == "id":
                self.anchors.add(value or "")
            elif name in ("href", "src") and value:
                self.targets.add(value)


def anchors_of_report() -> dict[str, set[str]]:
    """Page of a whole report -> the places of it that the documentation may link."""
    return {
        **{f"{part.name}.html": set() for part in PARTS},
        "claims.html": {one.id for one in CHECKS},
        "comparisons.html": {slug(name) for name in problems()},
        "studies.html": {one.name.replace("_", "-") for one in SECTIONS},
    }


def broken(folder: Path, report: Mapping[str, Collection[str]]) -> Iterator[str]:
    """A sentence for each link inside that leads nowhere; those outside go to OUTSIDE.

    folder  the built pages; the report's are in the folder above, or will be
    report  as `anchors_of_report`
    """
    folder = folder.resolve()
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in folder.rglob("*.html")
             if "_static" not in path.parts}  # fmt: skip
    outside: set[str] = set()
    for path, page in pages.items():
        for target in sorted(page.targets):
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                outside |= {target} if parts.scheme.startswith("http") else set()
                continue
            file = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            anchor = unquote(parts.fragment)
            if file.parent == folder.parent:
                found = file.name in report and (not anchor or anchor in report[file.name])
            else:
                found = file.is_file() and (
                    not anchor or file not in pages or anchor in pages[file].anchors
                )
            if not found:
                yield f"{path.relative_to(folder)}: the link to {target} leads nowhere."
    lines = "".join(f"{one}\n" for one in sorted(outside))
    (folder / OUTSIDE).write_text(lines, encoding="utf-8")
