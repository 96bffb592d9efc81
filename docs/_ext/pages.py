"""What Sphinx does with the pages of this project, beside what it does for everyone.

* The page of a study, studies/NAME/README.md, is read from _generated/studies, and links to it lead
  there. docs/write_pages.py has put the numbers into all pages.
* Links to the changelog lead to its page, and links to other files to pages that show them.
* In tables an interval may go on below its value, so that a table is no wider than its column.
* The gallery (gallery.py) is written before the build.
* Mathematics becomes MathML, which browsers draw themselves: a page loads nothing from a network.
"""

import re
from os.path import normpath, relpath
from pathlib import Path

import gallery
from docutils.nodes import SkipNode
from latex2mathml.converter import convert

from dem.base.source_hash import ROOT

STUDIES = ROOT / "docs/_generated/studies"
SOURCES = ROOT / "docs/_generated/sources"
LANGUAGES = {".py": "python", ".yaml": "yaml", ".cff": "yaml"}  # of files that are shown
PAGE_OF = {
    ROOT / "CHANGELOG.md": ROOT / "docs/changes.md",
    ROOT / "CONTRIBUTING.md": ROOT / "docs/contributing.md",
}
LINK = re.compile(r"\]\(([^)\s#:]+)(#[^)\s]*)?\)")
# What is beside a page: on the page itself a code host would show it as code. Other indexes list
# their pages, by the words of the links.
BESIDE = {
    "index": """\
Start <start>
Tutorials <tutorials/index>
How-to <howto/index>
Explanation <explanation/index>
Results <results/index>
Gallery <_generated/gallery>
API <reference/api>
Reference <reference/index>
Contribute <contributing>
Changes <changes>
""",
    "results/index": """\
Drag <drag>
Claims <../_generated/studies/claims>
Elongated granules <elongated>
Preparation <../_generated/studies/preparation>
Velocity <../_generated/studies/velocity>
Pressure <../_generated/studies/pressure>
Jamming of ellipses <../_generated/studies/onset>
Simple shear <../_generated/studies/shear>
Intruders <../_generated/studies/intruders>
Drag on a plate <../_generated/studies/base>
Columns that collapse <../_generated/studies/column>
Hoppers that empty <../_generated/studies/hopper>
Forces on outlines <../_generated/studies/rft>
Contact laws <../_generated/studies/law>
Rolling resistance <../_generated/studies/rolling>
Verification <../_generated/studies/verification>
Accuracy <../_generated/studies/accuracy>
Stability <../_generated/studies/stability>
Speed <../_generated/studies/benchmark>
""",
}
ROW = re.compile(r"^\|.*", re.M)
LISTED = re.compile(r"^\* \[([^\]]+)\]\(([^)]+)\.md\)", re.M)
TOCTREE = "\n```{{toctree}}\n:hidden:\n\n{}```\n"


def _linked(text: str, folder: Path, to: Path) -> str:
    """The text of a page in one folder for another: its links lead where they led, but to pages of
    studies where the build has them."""

    def link(found):
        path = Path(normpath(folder / found[1]))
        if path.name == "README.md" and path.parent.parent == ROOT / "studies":
            path = STUDIES / f"{path.parent.name}.md"
        elif path.suffix in LANGUAGES and path.is_file():
            path = _source_page(path)
        path = PAGE_OF.get(path, path)
        return f"]({Path(relpath(path, to)).as_posix()}{found[2] or ''})"

    return LINK.sub(link, text)


def _source_page(path: Path) -> Path:
    """A page that shows a file."""
    name = path.relative_to(ROOT).as_posix()
    page = SOURCES / f"{name}.md"
    page.parent.mkdir(parents=True, exist_ok=True)
    language = f":language: {LANGUAGES[path.suffix]}"
    shown = f"```{{literalinclude}} /../{name}\n{language}\n```\n"
    page.write_text(f"---\norphan: true\n---\n# {name}\n\n{shown}", encoding="utf-8")
    return page


def _read_page(app, docname, source):
    path = Path(app.env.doc2path(docname))
    if path.suffix == ".md":
        text = _linked(source[0], path.parent, path.parent)
        source[0] = ROW.sub(lambda row: row[0].replace("\u00a0(", " ("), text)
    listed = "".join(f"{words} <{page}>\n" for words, page in LISTED.findall(source[0]))
    if docname == "index" or docname.endswith("/index"):
        source[0] += TOCTREE.format(BESIDE.get(docname, listed))


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
    STUDIES.mkdir(parents=True, exist_ok=True)
    for path in ROOT.glob("studies/*/README.md"):
        text = _linked(path.read_text(encoding="utf-8"), path.parent, STUDIES)
        (STUDIES / f"{path.parent.name}.md").write_text(text, encoding="utf-8")
    for folder in (ROOT / "docs", *ROOT.glob("docs/[a-z]*")):  # before Sphinx lists all pages
        for path in folder.glob("*.md"):
            _linked(path.read_text(encoding="utf-8"), folder, folder)
    gallery.write(Path(app.srcdir))


def setup(app):
    app.add_html_math_renderer("mathml", (_inline_math, None), (_display_math, None))
    app.config.html_math_renderer = "mathml"
    app.connect("builder-inited", _write_pages)
    app.connect("source-read", _read_page)
    app.connect("autodoc-skip-member", _skip_fields)
    return {"parallel_read_safe": True}
