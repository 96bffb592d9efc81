"""A run of a file of results, chosen by words such as `case=c1 seed=1`."""

import json

import numpy as np
import pandas as pd
import xarray as xr

from dem.base.errors import InputError
from dem.base.messages import did_you_mean
from dem.io.dataset import LABELS
from dem.sweep.axis import is_written

SHOWN = 8  # values of an axis that a sentence lists


def values_of_runs(dataset: xr.Dataset) -> pd.DataFrame:
    """What tells the runs apart, axes and labels first: one row a run, by its identity."""
    if "run" not in dataset.dims:
        frame = dataset["run_id"].to_dataframe().reset_index().set_index("run_id")
        return frame[frame.index != ""]  # no run where a point has fewer replicates
    labels = dataset[list(LABELS)].to_dataframe()
    # a label is no other value of the configuration, and lists tell no runs of a file apart
    paths = pd.json_normalize(json.loads(dataset.attrs["values"]))
    lists = [name for name in paths if paths[name].map(lambda v: isinstance(v, list)).any()]
    frame = labels.join(paths.drop(columns=[*lists, *labels], errors="ignore"))
    return frame.set_index(dataset["run_id"].values)


def run_of(dataset: xr.Dataset, select: list[str]) -> xr.Dataset:
    """What a file has of the run with the values of some words."""
    runs = values_of_runs(dataset)
    columns, rest = {name.replace(".", "_"): name for name in runs}, runs
    for word in select:
        key, equal, text = word.partition("=")
        if not equal:
            raise InputError(f"{word!r} selects no run; write NAME=VALUE, such as seed=1.")
        if (name := columns.get(key.replace(".", "_"))) is None:
            varied = ", ".join(name for name in runs if runs[name].nunique() > 1)
            hint = did_you_mean(
                key.replace(".", "_"), columns, f"; they differ in {varied or 'nothing'}"
            )
            raise InputError(f"its runs have no value named {key}{hint}.")
        listed = ", ".join(rest[name].map(_word).unique()[:SHOWN])
        rest = rest[[is_written(value, text) for value in rest[name]]]
        if rest.empty:
            raise InputError(f"there is no run with {word}; {name} is {listed}.")
    if (count := rest.index.nunique()) == 1:
        ids = dataset["run_id"]
        place = np.argwhere(ids.values == rest.index[0])[0]
        return dataset.isel(dict(zip(ids.dims, place.tolist(), strict=True)))
    example, words = [], rest.map(_word)
    for name in words:
        if words[name].nunique() > 1:
            example.append(f"{name}={words[name].iloc[0]}")
            words = words[words[name] == words[name].iloc[0]]
    having = f" with {' '.join(select)}" if select else ""
    hint = f"choose one, such as {' '.join(example)}" if example else "no word tells them apart"
    raise InputError(f"it has {count} runs{having}; {hint}.")


def _word(value) -> str:
    """A value as one writes it."""
    return f"{value:.10g}" if isinstance(value, float) else str(value)
