"""Write the pages that state results, X.md from its template X.md.in, and the pictures they show.

python docs/write_pages.py

The text is always written, a picture only if its data or its code has changed: a note in the PNG
says from which it was drawn. The code of one picture is on the page that shows it.
"""

import hashlib
import re
import sys
from contextlib import chdir
from importlib.util import find_spec
from io import BytesIO
from os.path import relpath
from pathlib import Path
from tempfile import TemporaryDirectory

from matplotlib import rc_context
from PIL import Image
from PIL.PngImagePlugin import PngInfo

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "docs/_ext")]
import picture  # noqa: E402
from findings import FILES, fill  # noqa: E402
from gallery import OF_MEANS  # noqa: E402

from dem.base.files import write_bytes  # noqa: E402
from dem.base.source_hash import codes  # noqa: E402
from dem.figures.catalogue import draw  # noqa: E402
from studies.catalogue import figures  # noqa: E402

FOLDERS = "*.md.in", "docs/**/*.md.in", "studies/**/*.md.in"
TEMPLATES = sorted(path for each in FOLDERS for path in ROOT.glob(each))
FRONT_MATTER = re.compile(r"\A---\n.*?\n---\n+", re.S)  # for tests/pages/test_pages.py
TUTORIAL = ROOT / "docs/tutorials/results.md"  # whose first Python draws the picture of its name
PLAIN = TUTORIAL, ROOT / "docs/index.md"  # pages without a template that show pictures
SHOWN = re.compile(r"!\[[^\]]*\]\(([^)\s]*images/(\w+)\.(?:png|gif))\)")
NOTE = "<!-- Written by docs/write_pages.py: edit {}. -->\n\n"
WIDTH, COLORS, LARGEST = 1100, 96, 120_000  # of a picture: pixels, colours, bytes
FILM_WIDTH, FILM_COLORS, LARGEST_FILM = 640, 8, 400_000
PACE, REST = 120, 1500  # ms: a frame of a film, and its last one


def page_of(template: Path) -> Path:
    """The page that a template becomes."""
    return template.with_suffix("")


def text_of(template: Path) -> str:
    """The page with the numbers of the released files."""
    text = FRONT_MATTER.sub("", template.read_text(encoding="utf-8"))
    return NOTE.format(template.name) + fill(text)


def pictures() -> dict[Path, str]:
    """Names of the pictures that the pages show, by path."""
    return {
        (template.parent / path).resolve(): name
        for template in (*TEMPLATES, *PLAIN)
        for path, name in SHOWN.findall(template.read_text(encoding="utf-8"))
    }


def sources_of(name: str) -> tuple[Path, ...]:
    """What a picture is drawn from: its module, then the released files."""
    released = {each.name: each.path for each in FILES}
    drawn_here = {picture.NAME: picture.FILES, picture.FILM: picture.FILMED}
    if name in drawn_here:
        return Path(picture.__file__), *(released[each] for each in drawn_here[name])
    figure = figures()[name]
    module = Path(find_spec(figure.module).origin)
    return module, released[
        "precise" if name in OF_MEANS else name if name in released else figure.file
    ]


def tutorial_code() -> str:
    """What draws the picture of the tutorial."""
    return re.search(r"```python\n(.*?)```", TUTORIAL.read_text(encoding="utf-8"), re.S)[1]


def origin_of(name: str) -> str:
    """A hash of what a picture is drawn from; comments of modules do not count."""
    if name == TUTORIAL.stem:
        code = tutorial_code()
        files = [TUTORIAL.parent / path for path in re.findall(r"\.\./data/\w+\.nc", code)]
    else:
        module, *files = sources_of(name)
        code = str(codes([module]))
    found = hashlib.sha256(code.encode())
    for path in files:
        found.update(path.read_bytes())
    return found.hexdigest()[:16]


def note_of(path: Path) -> str | None:
    """The hash of what a picture was drawn from; None without the picture."""
    if not path.is_file():
        return None
    info = Image.open(path).info
    return info.get("origin") or info["comment"].decode()


def smaller(image: Image.Image, width: int) -> Image.Image:
    """An image of another width (pixels)."""
    return image.resize((width, image.height * width // image.width), Image.Resampling.LANCZOS)


def film() -> bytes:
    """The film at the top of README, with the hash of its origin."""
    frames = [smaller(frame, FILM_WIDTH) for frame in picture.film(*sources_of(picture.FILM)[1:])]
    palette, content = frames[-1].quantize(FILM_COLORS), BytesIO()
    first, *others = (frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames)
    first.save(
        content,
        format="GIF",
        save_all=True,
        append_images=others,
        duration=[PACE] * len(others) + [REST],
        loop=0,
        comment=origin_of(picture.FILM),
    )
    return content.getvalue()


def draw_picture(name: str, path: Path) -> None:
    """Draw a picture, small enough to be kept in the repository, with the hash of its origin."""
    if name == picture.FILM:
        write_bytes(path, film())
        return
    with TemporaryDirectory() as folder:
        if name == picture.NAME:
            drawn = picture.draw(*sources_of(name)[1:], Path(folder))
        elif name == TUTORIAL.stem:
            drawn, names = [Path(folder, "results.png")], {}
            with chdir(TUTORIAL.parent), rc_context({"backend": "agg"}):
                exec(tutorial_code(), names)
            names["figure"].savefig(drawn[0], dpi=200)
        else:
            drawn = draw(name, sources_of(name)[1], Path(folder), figures())
        image = Image.open(next(each for each in drawn if each.suffix == ".png")).convert("RGB")
    note = PngInfo()
    note.add_text("origin", origin_of(name))
    width, content = WIDTH, BytesIO()
    while not 0 < content.tell() <= LARGEST:
        content = BytesIO()
        small = smaller(image, width)
        small = small.quantize(COLORS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
        small.save(content, format="PNG", optimize=True, pnginfo=note)
        width = width * 9 // 10
    path.parent.mkdir(exist_ok=True)
    write_bytes(path, content.getvalue())


if __name__ == "__main__":
    for path, name in pictures().items():
        if note_of(path) != origin_of(name):
            draw_picture(name, path)
            print(f"{relpath(path)}: {path.stat().st_size / 1e3:.0f} kB")
    for template in TEMPLATES:
        page_of(template).write_text(text_of(template), encoding="utf-8")
