"""What all findings share: the released file, and how numbers and tables become Markdown."""

import inspect
import re
import sys
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr
from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dem.base.errors import InputError

ROOT = Path(__file__).parent.parent.parent


def holds(sentence: str, condition: bool) -> str:
    """The sentence; an error that ends the build where the data contradicts it."""
    if not condition:
        raise ValueError(f"The data contradict the sentence {sentence!r}; rewrite it.")
    return sentence


def numbers(*columns: str, words: int = 1, rows: Iterable[Iterable[str]] = ()) -> Table:
    """A table of a page with these headings: columns of words first, as many as `words`, then of
    numbers."""
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for number, column in enumerate(columns):
        table.add_column(column, justify="left" if number < words else "right", overflow="fold")
    for row in rows:
        table.add_row(*row)
    return table


def table(rich: Table) -> str:
    """A table for the terminal as Markdown; the first column is words, the others are numbers."""
    heads = [str(column.header).replace("\n", " ") for column in rich.columns]
    rows = zip(*(column.cells for column in rich.columns), strict=True)
    align = [":--" if column.justify == "left" else "--:" for column in rich.columns]
    lines = [heads, align, *rows]
    return "\n".join("| " + " | ".join(map(_cell, line)) + " |" for line in lines)


def _cell(text) -> str:
    words = str(text).replace("|", r"\|").replace("+-", "±").replace(" ± nan", "")
    words = words.replace("\n", "<br>")
    return re.sub(r"(?<!\w)-(?=\d)|(?<=\de)-(?=\d)", "\N{MINUS SIGN}", words)  # of -0.7 and 1.2e-05


def interval(value: float, half: float, unit: str = "", digits: int = 0) -> str:
    """A mean and half its confidence interval: 1257 ± 181 N, on one line."""
    words = f"{value:.{digits}f} ± {half:.{digits}f} {unit}".rstrip()
    return words.replace("-", "\N{MINUS SIGN}").replace(" ", "\N{NO-BREAK SPACE}")


def estimate(values, unit: str = "", digits: int = 2) -> str:
    """A value and the ends of its interval: 1180 (1090 to 1270) N, on one line."""
    value, low, high = (f"{number:.{digits}f}" for number in values)
    text = f"{value} ({low} to {high}) {unit}".rstrip()
    return text.replace("-", "\N{MINUS SIGN}").replace(" ", "\N{NO-BREAK SPACE}")


def percent(share, digits: int = 0) -> str:
    """A share in per cent, 12 %, or a share and half its interval: 65 ± 4 %."""
    if np.ndim(share):
        return interval(*(100.0 * np.asarray(share)), "%", digits)
    return f"{100.0 * share:.{digits}f} %"


def span(low: float, high: float, unit: str = "", digits: int = 2) -> str:
    """A range: 0.9 to 2.4 mm."""
    return f"{low:.{digits}f} to {high:.{digits}f} {unit}".rstrip()


SHOWN = (Table, str, int, float)  # kinds of findings that a summary shows


class Findings:
    """What one released file says: numbers as attributes, tables and what takes an argument as
    methods.

    The docstring of a finding says what it is; the sentence around it is on the page.
    """

    name: str  # of the file beside the findings, without .nc
    command: str  # that makes it
    folder: Path | None = None  # where the file is not beside the findings
    needs: tuple[str, ...] = ()  # variables that a file must have to be shown
    attributes: tuple[str, ...] = ()  # and attributes

    def of(self, dataset: xr.Dataset) -> "Findings":
        """The same of another file."""
        other = object.__new__(type(self))
        other.__dict__ |= {"name": self.name, "dataset": dataset}
        return other

    def summary(self) -> Group:
        """All findings that take no argument, for the terminal: what can be said in words, then
        tables."""
        lines, tables = [self.dataset.attrs.get("versions", "")], []
        for name, member in vars(type(self)).items():
            function = getattr(member, "fget", None) or getattr(member, "func", member)
            if name.startswith("_") or not inspect.isfunction(function):
                continue
            kind = function.__annotations__.get("return")
            if kind not in SHOWN or len(inspect.signature(function).parameters) > 1:
                continue
            about, value = inspect.getdoc(function), getattr(self, name)
            value = value() if callable(value) else value
            if kind is Table:
                tables += [Text(f"\n{about}", style="dim"), value]
            else:
                words = f"{value:.4g}" if kind is float else str(value)
                between = ":\n" if "\n" in words else ": "
                lines.append(about.rstrip(".") + between + words)
        title = Text(self.dataset.attrs["title"], style="bold")
        return Group(title, Text("\n".join(lines)), *tables)

    @property
    def path(self) -> Path:
        beside = Path(sys.modules[type(self).__module__].__file__).parent
        return (self.folder or beside) / f"{self.name}.nc"

    @property
    def place(self) -> str:
        """The file as a path of the checkout."""
        return self.path.relative_to(ROOT).as_posix()

    @property
    def source(self) -> str:
        """Where the command writes it, in the folder results."""
        return f"{self.name}.nc"

    @cached_property
    def dataset(self) -> xr.Dataset:
        if not self.path.is_file():
            raise InputError(
                f"{self.place} is missing; make it by `{self.command}`, "
                "then `python docs/data/release.py results`."
            )
        with xr.open_dataset(self.path) as dataset:
            return dataset.load()

    def time(self) -> str:
        """Processor time of all runs, without their beds."""
        return f"{float(self.dataset['run_time'].sum()) / 60.0:.0f} min"

    @cached_property
    def revision(self) -> str:
        """Of the code that made the results: the last of several, which contains the others."""
        return self.dataset.attrs["git_revision"].split(";")[-1].strip()[:7]

    @cached_property
    def origin(self) -> str:
        """Where the numbers come from, as a line under a table."""
        attrs = self.dataset.attrs
        day = attrs["history"].split("T")[0]
        return (
            f"*Computed by `{attrs['made_with']}` at revision `{self.revision}` on {day}; "
            f"file `{self.place}`.*"
        )


def clock(seconds: float) -> str:
    """A duration as one reads it: 12 s, 5 min 27 s, 1 h 5 min."""
    if seconds < 60:
        return f"{seconds:.0f} s" if seconds >= 10 else f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s" if rest else f"{minutes} min"
    return f"{minutes // 60} h {minutes % 60} min"
