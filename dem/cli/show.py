"""What verbs of the library and of studies share: drawing a figure, showing a table."""

import sys
import time
from pathlib import Path

from rich.console import Console
from rich.live import Live

from dem.analysis.tables import WIDE
from dem.base.files import atomic, check_output
from dem.base.messages import printable
from dem.io.progress import bar


class PlainConsole(Console):
    """A console on which texts of files are neither markup nor control characters."""

    def __init__(self, **options):
        super().__init__(markup=False, emoji=False, **options)

    def render(self, *arguments):
        for segment in super().render(*arguments):
            yield segment if segment.control else segment._replace(text=printable(segment.text))


def draw_figure(
    name: str, data: Path, output: Path | None, figures: dict, of: str | None = None
) -> None:
    """Draw one of some figures into a folder, figures/ beside the data if none is given."""
    from dem.figures.catalogue import draw

    folder = output or data.parent / "figures"
    check_output("output", folder / f"{name}.svg")
    with bar(f"drawing {name}"):
        draw(name, data, folder, figures, of)


def watched(look) -> None:
    """Show a table every few s, in place on a terminal, until nothing is left.

    look: gives the table, and whether anything is left.
    """
    with Live(console=PlainConsole(), auto_refresh=False) as live:
        while True:
            table, left = look()
            live.update(table, refresh=True)
            if not left:
                return
            time.sleep(3.0)


def print_or_write(table, output: Path | None) -> None:
    """Show a table, or write it to a text file; only a terminal limits its width."""
    if output is None:
        PlainConsole(width=None if sys.stdout.isatty() else WIDE).print(table)
        return
    with atomic(output) as part, part.open("w", encoding="utf-8") as file:
        PlainConsole(file=file, width=WIDE).print(table)
