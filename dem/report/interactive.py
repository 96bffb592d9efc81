"""What moves on the page: the drag by plotly, and the beds as numbers that its script draws."""

import base64
import json

import numpy as np
import plotly.graph_objects as go
import xarray as xr
from matplotlib.colors import to_hex
from plotly.io import to_html

from dem.analysis.statistics import running_mean
from dem.experiment.observables.flow import LAYERS
from dem.figures import style
from dem.figures.snapshots import bed_of
from dem.shapes import outlines

DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot", "solid")
COLORS = {  # of the page, one place with those of the figures
    "layers": style.LAYERS, "outline": to_hex(style.OUTLINE), "steel": to_hex(style.STEEL), "link": style.CURVE,
}  # fmt: skip
SHOWN = ("c1", "d1", "e3")  # cases that the page begins with
EVERY = 2  # bins between two points of a curve
CURVES = 20  # at most, of a case: a page with thousands would open in no browser
LENGTH = 0.1e-3  # m, of the running mean
STEPS = 32767  # of coordinates
FRAMES = 31  # at most, of a bed


def chart(dataset: xr.Dataset) -> str:
    """Drag against displacement as HTML: one curve per run, the first of each case."""
    figure, x = go.Figure(), 1e3 * dataset["displacement"].values
    smooth = running_mean(dataset.isel(seed=slice(2 * CURVES)), LENGTH)  # some may have failed
    for number, case in enumerate(dataset["case"].values):
        look = {
            "color": style.CASES[number % 7],
            "dash": DASHES[(number + number // 7) % 7],
            "width": 1.6,
        }
        made = smooth.sel(case=case).dropna("seed")[:CURVES]
        for seed in made["seed"].values:
            y = made.sel(seed=seed).values
            figure.add_scatter(
                x=np.round(x[::EVERY], 4).tolist(), y=np.round(y[::EVERY], 1).tolist(), mode="lines",
                name=f"{case}, seed {seed}", legendgroup=str(case), line=look,
                meta=[str(case), int(seed)],
                visible=bool(case in SHOWN and seed == made["seed"].values[0]),
                hovertemplate="%{x:.2f} mm: %{y:.0f} N<extra>%{fullData.name}</extra>",
            )  # fmt: skip
    start, stop = (1e3 * dataset.attrs[f"window_{end}"] for end in ("start", "stop"))
    shade = to_hex(style.WINDOW["color"])
    figure.add_vrect(start, stop, fillcolor=shade, line_width=0, layer="below")
    figure.update_layout(
        xaxis_title="Displacement of the cylinder (mm)", yaxis_title="Drag (N)", template="simple_white",
        showlegend=False, hovermode="closest", margin={"l": 70, "r": 10, "t": 10, "b": 55}, height=430,
    )  # fmt: skip
    options = {"displaylogo": False, "responsive": True}
    return to_html(figure, include_plotlyjs=True, full_html=False, div_id="drag", config=options)


def _packed(values, largest: float) -> str:
    """Numbers from 0 to `largest` as 16-bit integers in base64; those that are absent as -1."""
    steps = np.where(np.isfinite(values), np.round(values / largest * STEPS), -1)
    return base64.b64encode(steps.astype("<i2").tobytes()).decode()


def _rings(kind: str, ratio: float) -> list:
    """Outline of a granule of diameter 1, as rings of x, y, x, y, ... without the closing point."""
    rings = outlines(kind, np.ones(1), ratio)[0, :, :-1]
    return rings.reshape(len(rings), -1).round(4).tolist()


def beds(snapshots: xr.Dataset) -> dict:
    """Snapshots of the first seed of each case, as integers that the script of the page reads."""
    count = snapshots.sizes["snapshot"]
    shown = np.linspace(0, count - 1, min(count, FRAMES)).round().astype(int)
    snapshots, cases = snapshots.isel(snapshot=shown), {}
    for case in snapshots["case"].values:
        if (bed := bed_of(snapshots, case)) is None:
            continue
        one, scale = snapshots.sel(case=case), 1.2 * max(bed.width, bed.height.max())
        x, y = np.moveaxis(bed.position, -1, 0)
        cases[str(case)] = {
            "rings": _rings(str(one["kind"].values), float(one["aspect_ratio"])),
            "height": bed.height.tolist(),
            "scale": scale,
            "granules": len(bed.diameters),
            "diameter": bed.diameters.round(9).tolist(),
            "x": _packed(x, scale),
            "y": _packed(y, scale),
            "angle": _packed(np.mod(bed.angle, 2.0 * np.pi), 2.0 * np.pi),
            "axis": bed.axis[:, 1].tolist(),
            "drawn": style.drawn(one),
        }
    own = json.loads(snapshots.attrs["configuration"])
    return {
        "width": own["box_width"],
        "cylinder": own["cylinder"]["diameter"],
        "displacement": (1e3 * snapshots["snapshot_displacement"].values).tolist(),
        "layers": LAYERS,
        "steps": STEPS,
        "cases": cases,
        "colors": COLORS,
    }
