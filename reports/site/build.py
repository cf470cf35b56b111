"""The site: docs and results, by Sphinx.

Sphinx reads a copy of the folder docs with the generated pages beside it, in a temporary folder:
the sources may be read-only, and what Sphinx keeps are pickles, which must not be loaded from a
folder that travels.
"""

from __future__ import annotations

import io
import os
import re
import shutil
import tempfile
import warnings
from collections.abc import Collection, Mapping
from contextvars import ContextVar
from html.parser import HTMLParser
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from benchmarks.store.atomic import write
from benchmarks.work_precision.run import problems
from reports.figures.picture import slug
from reports.results.suite import Suite
from reports.site.pages import DOCS, RESULTS, rendered, single_file
from reports.site.report import Report

SINGLE = "report.html"
OUTSIDE = "external_links.txt"
GENERATED = "generated"
PACKAGES = ("galvi", "references")  # of which pages include lines
CELL = re.compile(r"^```\{code-cell\}.*\n(?::.*\n)*", re.MULTILINE)
TITLE = re.compile(r"^# .*\n", re.MULTILINE)
NOT_RUN = (
    "\n:::{note}\nThe code was not run for these pages; `make docs` shows what it prints.\n:::\n"
)
COLOUR = re.compile("\x1b\\[[0-9;]*m")
MATHJAX = "mathjax/tex-svg.js"  # under _static
FILLED = ("index", "peers")  # pages beside those of RESULTS with expressions

SHOWN: ContextVar[Report] = ContextVar("SHOWN")


def write_single(report: Report) -> Path:
    """Write all results as one self-contained file; returns its path."""
    return write(report.out / SINGLE, single_file(report))


class SiteBuilder:
    """Builds the site as often as it is called; what Sphinx keeps from one time to the next is
    removed when the context ends.

    Parameters
    ----------
    tutorials
        run their code, unless it ran before; else it is shown without what it prints
    """

    def __init__(self, tutorials: bool = False) -> None:
        self.tutorials = tutorials

    def __enter__(self) -> SiteBuilder:
        self.folder = tempfile.TemporaryDirectory(prefix="galvi-site-")
        self.source = Path(self.folder.name) / "docs"
        shutil.copytree(DOCS, self.source, ignore=shutil.ignore_patterns(GENERATED))
        for name in PACKAGES:
            package = Path(str(import_module(name).__file__)).parent
            shutil.copytree(package, self.source.parent / name, ignore=shutil.ignore_patterns("_*"))
        return self

    def __exit__(self, *error: object) -> None:
        self.folder.cleanup()

    def __call__(self, report: Report) -> list[str]:
        """Write the site to the folder of the report; returns Sphinx's warnings, and a sentence for
        each link that leads nowhere."""
        from sphinx.application import Sphinx
        from sphinx.util.docutils import docutils_namespace, patch_docutils

        log, token, pages = io.StringIO(), SHOWN.set(report), self.source.parent / "site" / "html"
        try:
            with patch_docutils(str(self.source)), docutils_namespace(), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                site = Sphinx(
                    self.source,
                    self.source,
                    pages,
                    self.source.parent / "doctrees",
                    "html",
                    self.settings(),
                    status=None,
                    warning=log,
                    keep_going=True,
                )
                site.build()
        finally:
            SHOWN.reset(token)
        shutil.copytree(pages, report.out, dirs_exist_ok=True)
        text = COLOUR.sub("", log.getvalue()).replace(f"{self.source}{os.sep}", "")
        files = [report.out / f"{name}.html" for name in site.env.found_docs]
        links = broken(report.out, files, anchors_of_results(report.suite))
        return [*text.splitlines(), *links]

    def settings(self) -> dict[str, Any]:
        """Sphinx's settings, in place of those of docs/conf.py."""
        if not self.tutorials:
            return {"nb_execution_mode": "off"}
        cache = DOCS / GENERATED / ".cache"
        os.environ["IPYTHONDIR"] = str(cache / "ipython")  # no settings of whoever builds
        quiet_kernel(cache / "ipython")
        return {"nb_execution_mode": "cache", "nb_execution_cache_path": str(cache / "jupyter")}


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


def anchors_of_results(suite: Suite) -> dict[str, set[str]]:
    """Page of results -> its places that other pages may link, shown or not in a report."""
    return {
        f"{RESULTS}/claims.html": {claim.id for claim in suite.claims},
        f"{RESULTS}/comparisons.html": {slug(name) for name in problems()},
        f"{RESULTS}/studies.html": {section.anchor for section in suite.sections},
    }


def broken(
    folder: Path, files: Collection[Path], anchors_by_file: Mapping[str, Collection[str]]
) -> list[str]:
    """A sentence for each link inside that leads nowhere; those outside go to OUTSIDE.

    Parameters
    ----------
    files
        the built pages
    anchors_by_file
        as `anchors_of_results`
    """
    folder = folder.resolve()
    pages = {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in files}
    outside: set[str] = set()
    sentences = []
    for path, page in sorted(pages.items()):
        for target in sorted(page.targets):
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                outside |= {target} if parts.scheme.startswith("http") else set()
                continue
            file = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            anchor = unquote(parts.fragment)
            anchors = pages[file].anchors if file in pages else set()
            if folder in file.parents:
                anchors = anchors.union(
                    anchors_by_file.get(file.relative_to(folder).as_posix(), ())
                )
            if not file.is_file() or (anchor and file in pages and anchor not in anchors):
                sentences.append(f"{path.relative_to(folder)}: the link to {target} leads nowhere.")
    write(folder / OUTSIDE, "".join(f"{target}\n" for target in sorted(outside)))
    return sentences


def copy_mathjax(static: Path) -> None:
    """One file of MathJax, so that formulas are read without a network."""
    package = find_spec("mathjax")
    assert package is not None and package.submodule_search_locations is not None
    (folder,) = package.submodule_search_locations
    (static / MATHJAX).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(Path(folder) / "static" / "mathjax" / "es5" / Path(MATHJAX).name, static / MATHJAX)


def quiet_kernel(folder: Path) -> None:
    """IPython's settings for the code of tutorials: its notices are none of the documentation's."""
    write(
        folder / "profile_default" / "ipython_kernel_config.py",
        "get_config().IPKernelApp.log_level = 'ERROR'\n",
    )


def shows_results(name: str) -> bool:
    """Whether a page has expressions that show a report."""
    return name in FILLED or name.startswith(f"{RESULTS}/")


def fill_in(app: Any, name: str, source: list[str]) -> None:
    """Sphinx's `source-read`: the expressions of a page are replaced by what the report has, and
    code that is not run is text."""
    if shows_results(name):
        source[0] = rendered(source[0], name, SHOWN.get())
    elif app.config.nb_execution_mode == "off":
        text, cells = CELL.subn("```python\n", source[0])
        source[0] = TITLE.sub(rf"\g<0>{NOT_RUN}", text, count=1) if cells else text


def outdated(app: Any, env: Any, *changes: Any) -> list[str]:
    """Sphinx's `env-get-outdated`: rows may have changed where the page's text has not."""
    return [name for name in env.found_docs if shows_results(name)]


GALLERY = "tutorials/index"


def picture_cards(app: Any, tree: Any, page: str) -> None:
    """Sphinx's `doctree-resolved`: each card of the gallery has its tutorial's first picture, where
    the tutorials were run."""
    from docutils import nodes

    if page != GALLERY:
        return
    cards = [node for node in tree.findall(nodes.container) if "sd-card" in node["classes"]]
    for card in cards:
        (link,) = card.findall(nodes.reference)
        name = f"tutorials/{Path(link['refuri']).stem}"
        picture = next(app.env.get_doctree(name).findall(nodes.image), None)
        if picture is not None:
            picture = picture.deepcopy()
            picture["classes"] = ["sd-card-img-top"]
            picture["alt"] = f"A figure of the tutorial: {link.astext()}"
            card.insert(0, picture)


def label_toggles(app: Any, page: str, template: str, context: dict[str, Any], tree: Any) -> None:
    """Sphinx's `html-page-context`: names what opens the pages below one in the navigation."""
    generate = context.get("generate_toctree_html")
    if generate is not None:
        context["generate_toctree_html"] = lambda *arguments, **options: str(
            generate(*arguments, **options)
        ).replace("<summary>", '<summary aria-label="Pages below">')


def setup(app: Any) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("builder-inited", lambda app: copy_mathjax(Path(app.outdir) / "_static"))
    app.connect("env-get-outdated", outdated)
    app.connect("source-read", fill_in)
    app.connect("env-updated", lambda app, env: [GALLERY] if GALLERY in env.found_docs else [])
    app.connect("doctree-resolved", picture_cards)
    app.connect("html-page-context", label_toggles, priority=900)  # after the theme's own
    return {"parallel_read_safe": False, "parallel_write_safe": True}
