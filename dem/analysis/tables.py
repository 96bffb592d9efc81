"""Tables for the terminal: no number is cut, however narrow the terminal is."""

from rich.text import Text

WIDE = 10_000  # characters: no table is wider
ROWS = 60  # of a table on a terminal, at most


def number(value: float) -> str:
    """A number that a file gives, whole, and one that was measured, to five digits."""
    given = f"{value:.10g}"
    return given if float(given) == value else f"{value:.5g}"


class TextTable:
    """The first rows of a table of pandas, on a console: columns for which it is too narrow are below, beside
    the first column again."""

    def __init__(self, frame):
        self.frame = frame.dropna(axis="columns", how="all")

    def __rich_console__(self, console, options):
        first, width = self.frame.columns[0], options.max_width
        rows = self.frame.head(ROWS).set_index(first).rename_axis(index=None, columns=first)
        rows.index = [number(at) if isinstance(at, float) else at for at in rows.index]
        yield Text(rows.to_string(line_width=width, na_rep="-", float_format=number))
        if (more := len(self.frame) - ROWS) > 0:
            yield Text(f"... and {more} rows more")
