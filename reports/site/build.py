"""The documentation: what is generated, and its links."""

from __future__ import annotations

import os
import shutil
from collections.abc import Collection, Iterator, Mapping
from html.parser import HTMLParser
from importlib.util import find_spec
from itertools import chain
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from benchmarks.work_precision.run import problems
from reports.contents import CHECKS, SECTIONS
from reports.figures.drawing import slug
from reports.page.render import PARTS
from reports.site import commands, defects, peers

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


FOLDER = "generated"
MATHJAX = "mathjax/tex-svg.js"  # under _static


def write_pages(source: Path) -> None:
    """Write every generated page whose text has changed, and remove those that no longer are."""
    folder = source / FOLDER
    pages = dict(chain(commands.pages(), peers.pages(), defects.pages()))
    for path in folder.rglob("*.md"):
        if str(path.relative_to(folder)) not in pages:
            path.unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")


def copy_mathjax(static: Path) -> None:
    """One file of MathJax, so that formulas are read without a network."""
    found = find_spec("mathjax")
    assert found is not None and found.submodule_search_locations is not None
    (folder,) = found.submodule_search_locations
    (static / MATHJAX).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(Path(folder) / "static" / "mathjax" / "es5" / Path(MATHJAX).name, static / MATHJAX)


def quiet_kernel(folder: Path) -> None:
    """IPython's settings for the code of tutorials: its notices are none of the documentation's."""
    settings = folder / "profile_default" / "ipython_kernel_config.py"
    settings.parent.mkdir(parents=True, exist_ok=True)
    settings.write_text("get_config().IPKernelApp.log_level = 'ERROR'\n", encoding="utf-8")


def begin(app: Any) -> None:
    """Sphinx's `builder-inited`."""
    write_pages(Path(app.srcdir))
    quiet_kernel(Path(os.environ["IPYTHONDIR"]))
    copy_mathjax(Path(app.outdir) / "_static")


def finish(app: Any, error: Exception | None) -> None:
    """Sphinx's `build-finished`."""
    from sphinx.util import logging

    if error is None and app.builder.name == "html":
        for sentence in broken(Path(app.outdir), anchors_of_report()):
            logging.getLogger(__name__).warning(sentence)


GALLERY = "tutorials/index"


def picture_cards(app: Any, tree: Any, page: str) -> None:
    """Sphinx's `doctree-resolved`: each card of the gallery has its tutorial's first picture."""
    from docutils import nodes
    from sphinx.util import logging

    if page != GALLERY:
        return
    cards = [one for one in tree.findall(nodes.container) if "sd-card" in one["classes"]]
    for card in cards:
        (link,) = card.findall(nodes.reference)
        name = f"tutorials/{Path(link['refuri']).stem}"
        picture = next(app.env.get_doctree(name).findall(nodes.image), None)
        if picture is None:
            logging.getLogger(__name__).warning(f"{name} has no picture for its card.")
            continue
        picture = picture.deepcopy()
        picture["classes"] = ["sd-card-img-top"]
        picture["alt"] = f"A figure of the tutorial: {link.astext()}"
        card.insert(0, picture)


def label_toggles(app: Any, page: str, template: str, context: dict[str, Any], tree: Any) -> None:
    """Sphinx's `html-page-context`: names what opens the pages below one in the navigation."""
    made = context.get("generate_toctree_html")
    if made is not None:
        context["generate_toctree_html"] = lambda *arguments, **options: str(
            made(*arguments, **options)
        ).replace("<summary>", '<summary aria-label="Pages below">')


def setup(app: Any) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("builder-inited", begin)
    app.connect("env-updated", lambda app, env: [GALLERY])
    app.connect("doctree-resolved", picture_cards)
    app.connect("html-page-context", label_toggles, priority=900)  # after the theme's own
    app.connect("build-finished", finish)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
