"""Tables for the terminal that all summaries share."""

from collections.abc import Iterable

from rich import box
from rich.table import Table


def digits(values: Iterable, least: int = 5) -> str:
    """Format of numbers, with as many digits as tell them apart, and at least these."""
    known = {each for each in values if isinstance(each, float) and each == each}
    spread = (len({f"{each:.{n}g}" for each in known}) for n in range(least, 17))
    return f".{least + sum(count < len(known) for count in spread)}g"


def numbers(*columns: str, words: int = 1, rows: Iterable[Iterable[str]] = ()) -> Table:
    """A table with these headings: columns of words first, as many as `words`, then of numbers."""
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for number, column in enumerate(columns):
        table.add_column(column, justify="left" if number < words else "right", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    return table
