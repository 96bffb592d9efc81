"""Copy into docs/data what the pages show of a folder of results: the variables they need, compressed.

    python docs/data/release.py results
"""

import sys
from pathlib import Path

import xarray as xr

from dem.base.files import atomic
from dem.io.checksums import seal

HERE = Path(__file__).parent
# file: (the command that makes it, variables left out because no page or figure shows them)
RELEASED = {
    "drag": ("snakemake -j2", ("wall_force", "transverse_force", "kinetic_energy")),
    "flow": ("snakemake -j2", ()),
    "claims": ("snakemake -j2 claims", ()),
    "accuracy": ("snakemake -j2 accuracy", ()),
    "stability": ("snakemake -j2 stability", ()),
    "benchmark": ("snakemake -j1 benchmark", ()),
}
PICTURED = ("bed_x", "bed_y", "bed_angle")


def release(results: Path) -> None:
    """Write docs/data/*.nc from the files that a folder of results holds."""
    for name, (command, left_out) in RELEASED.items():
        source = results / f"{name}.nc"
        if not source.is_file():
            print(f"{source}: not there, so docs/data/{name}.nc stays as it is")
            continue
        with xr.open_dataset(source) as dataset:
            kept = dataset.drop_vars(left_out, errors="ignore").load()
        kept.attrs["made_with"] = command
        for each in PICTURED:  # a picture shows no more digits
            if each in kept:
                kept[each] = kept[each].astype("float32")
        packed = {
            each: {"zlib": True, "complevel": 9, "shuffle": True}
            for each, values in kept.variables.items()
            if values.dtype.kind in "fiu" and values.dims
        }
        target = HERE / f"{name}.nc"
        with atomic(target) as part:
            kept.to_netcdf(part, encoding=packed)
            seal(part)
        print(f"{target}: {target.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    release(Path(sys.argv[1]))
