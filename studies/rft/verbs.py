"""`python -m studies rft proof`: forces on outlines beside theory, as one file."""

from pathlib import Path

from dem.cli.options import OutputOption, argument
from dem.io.progress import bar


def proof(
    data: argument(Path, "scene.nc of lengths.yaml."),
    sweeps: argument(list[str], "Sweeps of this folder, by their names."),
    output: OutputOption,
):
    """Write forces on the outlines of sweeps, measured and by theory.

    Example: python -m studies rft proof results/rft/lengths/scene.nc outlines half corner -o results/rft/proof.nc
    """
    from dem.base.files import atomic
    from dem.io.dataset import FORMAT
    from dem.io.lazily import open_lazily
    from studies.rft.proof import dataset_of

    with bar("outlines"), open_lazily(data) as dataset:
        result = dataset_of(dataset, sweeps)
    with atomic(output) as part:
        result.to_netcdf(part, format=FORMAT)


VERBS = (proof,)
