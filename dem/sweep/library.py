"""Sweeps in the library: all runs of a file, or one after another, as xarray datasets."""

from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from dem.base import plugins
from dem.base.errors import InputError
from dem.experiment.config import of_values
from dem.io.dataset import LABELS, attributes, global_attributes
from dem.io.lazily import open_results
from dem.sweep.config import load, merged, with_files
from dem.sweep.restart import prepare
from dem.sweep.state import SweepState
from dem.sweep.workers import workers_of


def load_sweep(path: str | Path) -> Iterator[dict]:
    """Read a sweep file and yield its runs one by one.

    Runs come block by block, in the order of the axes, each once. A value that is derived from the
    result of another block has the value in the file.

    Parameters
    ----------
    path : str or Path
        Configuration file of a sweep (YAML).

    Returns
    -------
    iterator of dict
        Values of one run, as `run_experiment` takes them: the nested sections of the
        configuration in SI units, with `shape` (a label), `density` (kg/m3) and `seed`.

    Raises
    ------
    InputError
        If the file cannot be used; one sentence per fault.

    Examples
    --------
    >>> import dem
    >>> values = next(dem.load_sweep("config/smoke.yaml"))
    >>> values["shape"], values["density"], values["seed"]
    ('c1', 3900.0, 1)
    >>> values["friction"]["granule"]
    0.3
    """
    sweep = load(Path(path))
    return (run.values() for name in sweep.blocks for run in sweep.block(name).unique())


def run_sweep(path: str | Path, executor=None, block: str | None = None) -> xr.Dataset:
    """Make all runs of a sweep file that are not there yet, and combine them, as `dem sweep` does.

    Stopped at any moment it loses no finished run, and goes on when it is called again.

    Parameters
    ----------
    path : str or Path
        Configuration file of a sweep (YAML).
    executor : concurrent.futures.Executor or distributed.Client, optional
        What makes the runs: `ProcessPoolExecutor(4)`, a Dask client, or an executor of mpi4py or
        loky. Its processes have one thread. It stays open. This process makes them if it is left
        out.
    block : str, optional
        The block of the sweep whose result is returned; the first if it is left out.

    Returns
    -------
    xarray.Dataset
        What the runs of the block gave, such as drag.nc, over the axes of the sweep, in SI units.
        All files are in the folder `results` of the sweep file, below the working folder.

    Raises
    ------
    InputError
        If the file cannot be used, or a worker has other code or packages.
    RunError
        If more runs fail than the file allows, or the workers are gone.

    Examples
    --------
    >>> import dem
    >>> data = dem.run_sweep("config/smoke.yaml")  # doctest: +SKIP
    >>> data["drag"].dims  # doctest: +SKIP
    ('case', 'seed', 'displacement')
    """
    state = SweepState.of(Path(path))
    state.check()
    output = state.combined(block)[0]
    workers = workers_of(executor)
    if executor is None:
        for file in {file for run in state.replicates() for file in run.files}:
            plugins.load(file)  # what cannot be is said before anything is written
    lock = prepare(state.results, state.store.folder)
    try:
        state.make(workers)
    finally:
        lock.release()
    return open_results(output)


def run_experiment(values: dict) -> xr.Dataset:
    """Make one run: pack its bed and draw the cylinder through it.

    Parameters
    ----------
    values : dict
        Values of one run in SI units, as `load_sweep` yields them. Or a dict with `extends`, a
        configuration file, `shape`, and the values that differ from the file. Then `seed` is 1
        and `density` (kg/m3) is from the file's first case of the shape, unless you give them.

    Returns
    -------
    xarray.Dataset
        What the configuration records, such as `drag` (displacement,) in N; snapshots have
        dimensions (snapshot, granule). Units are in the attributes of each variable.

    Raises
    ------
    InputError
        If a value cannot be simulated.
    RunError
        If the run fails: no bed at rest, too large an overlap or too short steps.

    Examples
    --------
    >>> import dem
    >>> values = {"extends": "config/smoke.yaml", "shape": "c1", "friction": {"granule": 0.1}}
    >>> data = dem.run_experiment(values)
    >>> data["drag"].dims, data["drag"].attrs["units"]
    (('displacement',), 'N')
    """
    plugins.refresh()
    values = with_files(values, "values", Path())
    if (file := values.pop("extends", None)) is not None:
        if "shape" not in values:
            raise InputError("values: shape is missing.")
        base = load(Path(file))
        usual = {"density": base.density_of(values["shape"]), "seed": 1}
        values = merged(base.values(), usual | values)
    replicate = of_values(values)
    configuration = replicate.configuration
    configuration.check_files()
    experiment = configuration.module
    values = experiment.run(replicate)
    layout = experiment.layout | experiment.along | LABELS
    coordinates = experiment.axes | replicate.labels()
    used = {"bound", *(dim for name in values for dim in layout[name][0])}
    variables = {
        name: (layout[name][0], value, attributes(name, layout))
        for name, value in (coordinates | values).items()
        if used.issuperset(layout[name][0])
    }
    title = f"{configuration.experiment}: {replicate.words()}"
    attrs = global_attributes(title, "dem.run_experiment", run_id=replicate.id)
    return xr.Dataset(variables, attrs=attrs).set_coords(coordinates.keys() & variables.keys())
