"""Build the site of docs and results by Sphinx.

Sphinx reads a copy of the folder docs in a temporary folder: the sources may be read-only, and the
environment that Sphinx stores is pickled, so that it must not be loaded from a folder that others
may have written.
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
from reports.site.pages import DOCS, RESULTS, render, single_file
from reports.site.report import Report

SINGLE_FILE = "report.html"
EXTERNAL_LINKS_FILE = "external_links.txt"
GENERATED = "generated"
INCLUDED_PACKAGES = ("galvi", "references")  # packages whose source lines pages include
CODE_CELL = re.compile(r"^```\{code-cell\}.*\n(?::.*\n)*", re.MULTILINE)
TITLE = re.compile(r"^# .*\n", re.MULTILINE)
NOT_RUN_NOTE = (
    "\n:::{note}\nThe code was not run for these pages; `make docs` shows what it prints.\n:::\n"
)
COLOUR_CODE = re.compile("\x1b\\[[0-9;]*m")
MATHJAX = "mathjax/tex-svg.js"  # under _static
FILLED_PAGES = ("index", "peers")  # pages outside RESULTS that have expressions

CURRENT_REPORT: ContextVar[Report] = ContextVar("CURRENT_REPORT")


def write_single(report: Report) -> Path:
    """Write all results as one self-contained file; returns its path."""
    return write(report.out / SINGLE_FILE, single_file(report))


class SiteBuilder:
    """Builds the site at each call; Sphinx's files between calls are removed with the context.

    Parameters
    ----------
    tutorials
        whether to run the tutorials' code that has not been run before; if not, it is shown without
        output
    """

    def __init__(self, tutorials: bool = False) -> None:
        self.tutorials = tutorials

    def __enter__(self) -> SiteBuilder:
        self.folder = tempfile.TemporaryDirectory(prefix="galvi-site-")
        self.source = Path(self.folder.name) / "docs"
        shutil.copytree(DOCS, self.source, ignore=shutil.ignore_patterns(GENERATED))
        for name in INCLUDED_PACKAGES:
            package = Path(str(import_module(name).__file__)).parent
            shutil.copytree(package, self.source.parent / name, ignore=shutil.ignore_patterns("_*"))
        return self

    def __exit__(self, *error: object) -> None:
        self.folder.cleanup()

    def __call__(self, report: Report) -> list[str]:
        """Write the site to the folder of the report; returns Sphinx's warnings, and a sentence for
        each broken link."""
        from sphinx.application import Sphinx
        from sphinx.util.docutils import docutils_namespace, patch_docutils

        log, token, pages = (
            io.StringIO(),
            CURRENT_REPORT.set(report),
            self.source.parent / "site" / "html",
        )
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
            CURRENT_REPORT.reset(token)
        shutil.copytree(pages, report.out, dirs_exist_ok=True)
        text = COLOUR_CODE.sub("", log.getvalue()).replace(f"{self.source}{os.sep}", "")
        files = [report.out / f"{name}.html" for name in site.env.found_docs]
        links = broken_links(report.out, files, anchors_of_results(report.suite))
        return [*text.splitlines(), *links]

    def settings(self) -> dict[str, Any]:
        """Sphinx's settings, in place of those of docs/conf.py."""
        if not self.tutorials:
            return {"nb_execution_mode": "off"}
        cache = DOCS / GENERATED / ".cache"
        os.environ["IPYTHONDIR"] = str(cache / "ipython")  # ignore the user's own settings
        quiet_kernel(cache / "ipython")
        return {"nb_execution_mode": "cache", "nb_execution_cache_path": str(cache / "jupyter")}


class Page(HTMLParser):
    """The anchors that an HTML page defines, and the targets of its links."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.targets: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect the anchors and targets of a tag; called by HTMLParser."""
        for name, value in attrs:
            if name == "id":
                self.anchors.add(value or "")
            elif name in ("href", "src") and value:
                self.targets.add(value)


def anchors_of_results(suite: Suite) -> dict[str, set[str]]:
    """Page of results -> the anchors that other pages may link to, even if a report lacks them."""
    return {
        f"{RESULTS}/claims.html": {claim.id for claim in suite.claims},
        f"{RESULTS}/comparisons.html": {slug(name) for name in problems()},
        f"{RESULTS}/studies.html": {section.anchor for section in suite.sections},
    }


def broken_links(
    folder: Path, files: Collection[Path], anchors_by_file: Mapping[str, Collection[str]]
) -> list[str]:
    """A sentence for each broken link between pages; http links are written to EXTERNAL_LINKS_FILE,
    unchecked.

    Parameters
    ----------
    folder
        the folder of the site
    files
        the built pages
    anchors_by_file
        file, relative to `folder` -> further anchors, as of `anchors_of_results`
    """
    folder = folder.resolve()
    pages = {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in files}
    external_links: set[str] = set()
    sentences = []
    for path, page in sorted(pages.items()):
        for target in sorted(page.targets):
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                external_links |= {target} if parts.scheme.startswith("http") else set()
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
    write(folder / EXTERNAL_LINKS_FILE, "".join(f"{target}\n" for target in sorted(external_links)))
    return sentences


def copy_mathjax(static: Path) -> None:
    """Copy MathJax into a folder, so that formulas are shown without a network."""
    package = find_spec("mathjax")
    assert package is not None and package.submodule_search_locations is not None
    (folder,) = package.submodule_search_locations
    (static / MATHJAX).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(Path(folder) / "static" / "mathjax" / "es5" / Path(MATHJAX).name, static / MATHJAX)


def quiet_kernel(folder: Path) -> None:
    """Write settings of IPython that suppress its log messages, which would appear in tutorials."""
    write(
        folder / "profile_default" / "ipython_kernel_config.py",
        "get_config().IPKernelApp.log_level = 'ERROR'\n",
    )


def shows_results(name: str) -> bool:
    """Whether a page has expressions that show a report."""
    return name in FILLED_PAGES or name.startswith(f"{RESULTS}/")


def fill_in(app: Any, name: str, source: list[str]) -> None:
    """Handler of Sphinx's `source-read`: evaluates the expressions of a page on the report, and
    turns code cells into plain code blocks if no code is run."""
    if shows_results(name):
        source[0] = render(source[0], name, CURRENT_REPORT.get())
    elif app.config.nb_execution_mode == "off":
        text, cells = CODE_CELL.subn("```python\n", source[0])
        source[0] = TITLE.sub(rf"\g<0>{NOT_RUN_NOTE}", text, count=1) if cells else text


def outdated_pages(app: Any, env: Any, *changes: Any) -> list[str]:
    """Handler of Sphinx's `env-get-outdated`: the pages that show a report, whose rows may have
    changed."""
    return [name for name in env.found_docs if shows_results(name)]


GALLERY = "tutorials/index"


def picture_cards(app: Any, tree: Any, page: str) -> None:
    """Handler of Sphinx's `doctree-resolved`: adds to each card of the gallery the first picture of
    its tutorial, if the tutorials were run."""
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
    """Handler of Sphinx's `html-page-context`: labels the buttons that expand the navigation."""
    generate = context.get("generate_toctree_html")
    if generate is not None:
        context["generate_toctree_html"] = lambda *arguments, **options: str(
            generate(*arguments, **options)
        ).replace("<summary>", '<summary aria-label="Pages below">')


def setup(app: Any) -> dict[str, bool]:
    """Connect the handlers; called by Sphinx."""
    app.connect("builder-inited", lambda app: copy_mathjax(Path(app.outdir) / "_static"))
    app.connect("env-get-outdated", outdated_pages)
    app.connect("source-read", fill_in)
    app.connect("env-updated", lambda app, env: [GALLERY] if GALLERY in env.found_docs else [])
    app.connect("doctree-resolved", picture_cards)
    app.connect("html-page-context", label_toggles, priority=900)  # after the theme's own
    return {"parallel_read_safe": False, "parallel_write_safe": True}
