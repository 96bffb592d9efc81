"""What verbs of the library and of studies share: drawing a figure, showing a table."""

import sys
import time
from contextlib import nullcontext
from pathlib import Path

from rich.console import Console
from rich.live import Live
from rich.segment import Segment

from dem.analysis.tables import WIDE
from dem.base.files import atomic, check_output
from dem.base.messages import printable
from dem.io.progress import bar


class PlainConsole(Console):
    """A console that takes no text for markup and shows no control characters of it.

    Colours stay: rich keeps them apart from the text.
    """

    def __init__(self, **options):
        super().__init__(markup=False, emoji=False, **options)

    def on_broken_pipe(self):
        """Whoever reads the pipe has seen enough: no failure, of which rich makes one."""
        raise BrokenPipeError

    def render(self, renderable, options=None):
        """Segments of what is shown, their text printable."""
        for text, style, control in super().render(renderable, options):
            yield Segment(text if control else printable(text), style, control)


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
    terminal = sys.stdout.isatty()
    console = PlainConsole(width=None if terminal else 160)
    with Live(console=console, auto_refresh=False) if terminal else nullcontext() as live:
        while True:
            table, left = look()
            if live:
                live.update(table, refresh=True)
            else:
                console.print(table)
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
