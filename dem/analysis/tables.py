"""Tables for the terminal that all summaries share."""

from collections.abc import Iterable
from copy import copy

from rich import box
from rich.table import Table

WIDE = 10_000  # characters: no table is wider


class Whole(Table):
    """A table whose last columns are below, beside the first one again, where a console is too narrow."""

    def __rich_console__(self, console, options):
        """Parts of the table, each as wide as the console allows."""
        part, free = copy(self), options.update(max_width=WIDE)
        part.columns = list(self.columns)
        while len(part.columns) > 2 and console.measure(part, options=free).maximum > options.max_width:
            part.columns.pop()
        yield from Table.__rich_console__(part, console, options)
        if rest := self.columns[len(part.columns) :]:
            part = copy(self)
            part.columns = [self.columns[0], *rest]
            yield part


def digits(values: Iterable, least: int = 5) -> str:
    """Format of numbers, with as many digits as tell them apart, and at least these."""
    known = {each for each in values if isinstance(each, float) and each == each}
    spread = (len({f"{each:.{n}g}" for each in known}) for n in range(least, 17))
    return f".{least + sum(count < len(known) for count in spread)}g"


def numbers(*columns: str, words: int = 1, rows: Iterable[Iterable[str]] = ()) -> Table:
    """A table with these headings: columns of words first, as many as `words`, then of numbers."""
    table = Whole(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for number, column in enumerate(columns):
        table.add_column(column, justify="left" if number < words else "right", overflow="fold")
    for row in rows:
        table.add_row(*row)
    return table
