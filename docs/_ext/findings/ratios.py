"""Drag of other shapes over that of discs, in all released files: one number for each question."""

from rich.table import Table

from studies.common.findings import estimate, numbers

from .drag import drag

PAPER, OPEN = "the paper's", "the paper's width, periodic sides"
SHAPES = "d1", "e1", "e3"


def ratios(precise, claims, preparation, pressure) -> Table:
    """One row per answer: the page and its file, which beds are compared, how many, and the drag
    of each shape over that of c1.

    precise: of as many beds as the ratio takes; claims, preparation, pressure: the findings of
    these studies.
    """
    made = numbers(
        "page", "file", "box", "preparation", "compared at", "beds per shape", *SHAPES, words=5
    )
    made.add_row(
        _link("drag"),
        _name(precise),
        PAPER,
        "relaxed",
        "0.84",
        precise.beds_of("c1", *SHAPES),
        *map(precise.over, SHAPES),
    )
    for page, file, beds, judged in (
        ("drag", drag, "relaxed", claims.on(drag.dataset)),
        ("claims", claims, "relaxed", claims.judged),
        *(
            ("preparation", preparation, way, claims.on(preparation.at(way)))
            for way in ("relaxed", "grown")
        ),
    ):
        found = judged["shape_matters"].comparisons  # of SHAPES
        over = (estimate(each.known()) for each in found)
        made.add_row(_link(page), _name(file), PAPER, beds, "0.84", str(found[0].runs), *over)
    seeds = str(pressure.dataset.sizes["seed"])
    for way, beds, at in (
        ("fraction", "relaxed", "0.84"),
        ("pressure", "under pressure", f"{1e-6 * pressure.top_pressure:.0f} MPa"),
    ):
        widths = pressure.widths[way]
        over = (estimate(widths.ratio(shape, widths.boxes[0])) for shape in SHAPES)
        made.add_row(_link("pressure"), _name(pressure), OPEN, beds, at, seeds, *over)
    return made


def _link(page: str) -> str:
    place = f"{page}.md" if page == "drag" else f"../../studies/{page}/README.md"
    return f"[{page}]({place})"


def _name(file) -> str:
    return f"`{file.name}.nc`"
