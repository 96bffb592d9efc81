"""Sphinx configuration: `make docs` builds docs/_build/html, without a network, warnings as errors.

Sphinx with myst-nb and numpydoc is what NumPy, SciPy and xarray use: the reference comes from the
docstrings, tutorials are notebooks that run in the build, and pages are Markdown, with the numbers
that docs/write_pages.py has written. The builder `linkcheck` of Sphinx looks at links to other
sites; it needs a network.
"""

import sys
from pathlib import Path

import dem

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE / "_ext")]  # studies, and what fills in pages
# autodoc wants modules where they are public
sys.modules |= {"dem.plot": dem.plot, "dem.rft": dem.rft}

project = "granular-drag"
author = "The granular-drag developers"
copyright = "2026, the granular-drag developers"
version = release = dem.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinxcontrib.video",
    "pages",  # docs/_ext: pages of studies, gallery, mathematics
]
exclude_patterns = ["_build", "_ext", "data"]
templates_path = ["_templates"]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3
nb_output_stderr = "remove"  # a build that compiles says so there
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 900
nb_execution_excludepatterns = []
nb_merge_streams = True

copybutton_exclude = ".linenos, .gp"  # a prompt is not copied
autosummary_generate = True
autodoc_typehints = "none"  # numpydoc's sections give types, shapes and units
numpydoc_show_class_members = False
numpydoc_validation_checks = set()
add_module_names = False

html_theme = "pydata_sphinx_theme"
html_title = "granular-drag"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
ALONE = "index", "start", "contributing", "changes", "_generated/gallery"  # nothing is beside them
html_sidebars = {page: [] for page in ALONE}
html_theme_options = {
    "navigation_with_keys": False,
    "show_prev_next": True,
    "secondary_sidebar_items": ["page-toc"],
    "navbar_align": "left",
    "header_links_before_dropdown": 8,
    "show_nav_level": 1,
    "footer_start": ["copyright"],
    "footer_end": ["sphinx-version"],
}
html_context = {"default_mode": "light"}
