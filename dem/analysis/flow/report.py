"""What flow.nc says, for the terminal."""

import xarray as xr
from rich.console import Group
from rich.text import Text

from dem.analysis.flow.verdict import sentences, verdict


def summary(dataset: xr.Dataset) -> Group:
    """Renderable summary of flow.nc."""
    return Group(*map(Text, [dataset.attrs["title"], verdict(dataset), *sentences(dataset)]))
