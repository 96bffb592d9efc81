"""Errors over their tolerances, a row a case."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.verification.findings import verification

FILE = "verification"
CAPTION = "Known cases of the field: error of every number over its tolerance"
VARIABLES = ("row_case", "row_value")
MOST = 2.5  # errors over tolerances beyond this are drawn at it
ROW = 0.32  # inches


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One row per case, one mark per number; cases with failed numbers come first."""
    findings = verification.of(dataset)
    cases = sorted(findings.by_case, key=lambda case: case[2].passed.all())
    figure = Figure(figsize=(style.WIDTH, 1.4 + ROW * len(cases)))
    axes = figure.subplots()
    look = {"linestyle": "none", "markeredgecolor": "black", "markersize": 5.0, "alpha": 0.7}
    for place, (_, _, rows) in enumerate(cases):
        errors = (rows.value - rows.expected) / rows.tolerance
        spread = 0.3 * np.sin(np.arange(len(rows)))  # so that equal errors show side by side
        for passed, marker in ((1, "o"), (0, "X")):
            mask = (rows.passed == passed).values
            size = {"markersize": 5.0 if passed else 9.0}
            face = {"markerfacecolor": "#a9c8ea" if passed else "#b34700"}
            x = np.clip(errors[mask], -MOST, MOST)
            axes.plot(x, place + spread[mask], marker, **look | size | face)
    axes.axvspan(-1.0, 1.0, **style.WINDOW)
    axes.axvline(0.0, **style.REFERENCE)
    axes.set_yticks(range(len(cases)), [f"{title} ({len(rows)})" for _, title, rows in cases])
    axes.set(xlim=(-MOST - 0.1, MOST + 0.1), ylim=(len(cases) - 0.4, -0.6))
    axes.set_xlabel("Error over its tolerance (grey: passed; crosses: failed)")
    right = findings.total() - findings.failed()
    figure.suptitle(f"{right} of {findings.total()} numbers are within their tolerances")
    return figure
