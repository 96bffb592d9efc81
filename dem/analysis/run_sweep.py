"""A whole sweep in the library: runs, combined files, and how the beds move."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dem.analysis.flow.collect import make_flow
from dem.base.errors import InputError
from dem.base.plugins import load
from dem.io.lazily import open_results
from dem.io.results_folder import prepare
from dem.sweep.campaign import Campaign
from dem.sweep.workers import workers_of

if TYPE_CHECKING:
    import xarray as xr


def run_sweep(path: str | Path, executor=None, block: str | None = None) -> xr.Dataset:
    """Make all runs of a sweep file that are not there yet, and combine them, as `dem sweep` does.

    Stopped at any moment it loses no finished run, and goes on when it is called again.

    Parameters
    ----------
    path : str or Path
        Configuration file of a sweep (YAML).
    executor : concurrent.futures.Executor or distributed.Client, optional
        What makes the runs: `ProcessPoolExecutor(4)`, a Dask client, those of mpi4py and loky. Its
        processes have one thread. It stays open. This process makes them if it is left out.
    block : str, optional
        The block of the sweep whose result is returned; the first if it is left out.

    Returns
    -------
    xarray.Dataset
        What the runs of the block gave, such as drag.nc, over the axes of the sweep, in SI units. All
        files are in the folder `results` of the sweep file, below the working folder.

    Raises
    ------
    InputError
        If the file cannot be used, or a worker has other code or packages.
    RunError
        If more runs fail than the file allows, or the workers are gone.

    Examples
    --------
    >>> import dem
    >>> found = dem.run_sweep("config/smoke.yaml")  # doctest: +SKIP
    >>> found["drag"].dims  # doctest: +SKIP
    ('case', 'seed', 'displacement')
    """
    campaign = Campaign.of(Path(path))
    campaign.check()
    if block is not None and block not in campaign.sweep.blocks:
        raise InputError(f"block is {block!r}; {path} has {', '.join(campaign.sweep.blocks)}.")
    workers = workers_of(executor, campaign.store)
    if executor is None:
        for name in campaign.sweep.blocks:
            for file in {each for run in campaign.block(name).unique() for each in run.files}:
                load(file)  # what cannot be is said before anything is written
    held, _ = prepare(campaign.results, campaign.store.folder)
    try:
        with workers:
            campaign.make(workers)
        for each in campaign.sweep.blocks:
            make_flow(campaign, each)
    finally:
        held.release()
    return open_results(campaign.first(block or next(iter(campaign.sweep.blocks))))
