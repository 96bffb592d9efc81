"""What Sphinx does with the pages of this project, beside what it does for everyone.

* A page is a Jinja template: `{{ drag.mean("c1") }}` is filled in from docs/data (findings.py).
  An unknown name is an error.
* The pages that are generated (gallery.py, reference.py) are written before the build.
* Mathematics becomes MathML, which browsers draw themselves: a page loads nothing from a network.
"""

from pathlib import Path

import findings
import gallery
import reference
from docutils.nodes import SkipNode
from latex2mathml.converter import convert


def _fill_page(app, docname, source):
    if Path(app.env.doc2path(docname)).suffix == ".md":
        source[0] = findings.fill(source[0])


def _inline_math(self, node):
    self.body.append(convert(node.astext()))
    raise SkipNode


def _display_math(self, node):
    self.body.append(f'<div class="math">{convert(node.astext(), display="block")}</div>')
    raise SkipNode


def _skip_fields(app, what, name, member, skip, options):
    """Fields of a NamedTuple, which its docstring explains."""
    return skip or type(member).__name__ == "_tuplegetter"


def _write_pages(app):
    reference.write(Path(app.srcdir))
    gallery.write(Path(app.srcdir))


def setup(app):
    app.add_html_math_renderer("mathml", (_inline_math, None), (_display_math, None))
    app.config.html_math_renderer = "mathml"
    app.connect("builder-inited", _write_pages)
    app.connect("source-read", _fill_page)
    app.connect("autodoc-skip-member", _skip_fields)
    return {"parallel_read_safe": True}
