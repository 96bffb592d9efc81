"""After the build: every link leads somewhere, and no page loads anything from a network.

Sphinx checks the links that it makes itself. This looks at the finished pages, so that it sees the
links of the theme, of raw HTML and to files too. Faults are warnings, which `make docs` does not accept.
"""

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from sphinx.util import logging

LOADED = {"img", "script", "link", "source", "video", "iframe"}  # the browser fetches these itself
log = logging.getLogger(__name__)


class Page(HTMLParser):
    """Names that can be linked to, and links (tag, target)."""

    def __init__(self, path: Path):
        super().__init__()
        self.names, self.links = {""}, []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.names.update(found[key] for key in ("id", "name") if found.get(key))
        self.links += [(tag, found[key]) for key in ("href", "src") if found.get(key)]


def check(app, exception):
    """Warn of each link that leads nowhere and of each thing that is loaded from a network."""
    if exception or app.builder.format != "html":
        return
    folder = Path(app.outdir)
    found = [path for path in folder.rglob("*.html") if folder / "_static" not in path.parents]
    pages = {path: Page(path) for path in found}
    for path, page in pages.items():
        for tag, link in page.links:
            fault = _fault(path, tag, link, pages)
            if fault:
                log.warning("%s: %s %s", path.relative_to(folder), link, fault)


def _fault(path, tag, link, pages):
    """What is wrong with a link, or None."""
    parts = urlsplit(link)
    if parts.scheme or parts.netloc:
        return "is loaded from a network" if tag in LOADED and parts.scheme != "data" else None
    target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
    if not target.exists():
        return "leads nowhere"
    named = pages.get(target)
    return (
        "names no place on its page"
        if named and unquote(parts.fragment) not in named.names
        else None
    )


def setup(app):
    app.connect("build-finished", check)
    return {"parallel_read_safe": True}
