"""How Sphinx builds the site, docs and results; `reports.site.build` runs it."""

from reports.site.build import MATHJAX

project = "galvi"
author = copyright = "The galvi developers"
extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx_design",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "reports.site.build",
    "reports.site.ledger",
]
templates_path = ["_templates"]

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 4

# Whether pages with code cells are run says the caller; an exception ends the build.
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_execution_in_temp = True  # what cells write is not left beside the pages
nb_merge_streams = True

autodoc_typehints = "none"  # docstrings name types, shapes and units
autosummary_generate = False  # the pages in reference/ are written by hand
numpydoc_show_class_members = False
default_role = "py:obj"  # `galvi.integrate` in a docstring is a link
autodoc_member_order = "bysource"
add_module_names = False
toc_object_entries_show_parents = "hide"
nitpicky = True
smartquotes = False  # q' is a derivative, and "newton" is typed
python_use_unqualified_type_names = True

html_theme = "sphinx_book_theme"
html_title = "galvi"
html_static_path = ["_static"]
html_css_files = ["site.css", "results.css"]
html_js_files = [("results.js", {"defer": "defer"})]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {
    "show_toc_level": 2,
    "use_download_button": False,
    "navigation_with_keys": False,
    "navbar_persistent": [],
}
html_sidebars = {"**": ["home.html", "search-button-field.html", "sbt-sidebar-nav.html"]}
html_context = {"default_mode": "auto"}

mathjax_path = MATHJAX
