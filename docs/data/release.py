"""Copy into docs/data what the pages show of a folder of results: the variables they need, compressed.

    python docs/data/release.py results

Those of a study go into its folder. Each file names the command and the revision that made it, and holds a hash of the code that
decides how granules move (`kernels`). tests/pages/test_pages.py compares it with today's.
"""

import subprocess
import sys
import tarfile
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import xarray as xr

from dem.base.files import atomic
from dem.base.source_hash import ROOT
from dem.io.dataset import FORMAT

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent.parent), str(HERE.parent / "_ext")]
from findings import FILES  # noqa: E402

from docs.data.kernels import digest  # noqa: E402

FORCES = "wall_force", "transverse_force", "kinetic_energy"
GRANULES = "granule_x", "granule_y", "granule_angle", "granule_diameter"
STATE = "kinetic_energy", "coordination_number", "max_overlap", "solid_torque"
BINS = "drag_normal", "coordination_number", "time_step"
PLACES = "granule_x", "granule_y", "granule_angle", "granule_diameter", "surface_height"
LEFT_OUT = {  # on no page, in no figure
    "drag": FORCES,
    "precise": (*FORCES, *BINS, "drag_tangential", "max_overlap"),
    "velocity": (*FORCES, *BINS),
    "pressure": (*FORCES[1:], *BINS, "drag_tangential", "max_overlap"),
    "preparation": (*FORCES, *BINS, "drag_tangential", "max_overlap"),
    "law": (*FORCES, *BINS, "drag_tangential", "max_overlap"),
    "moduli": (*FORCES, *BINS, "drag_tangential", "max_overlap"),
    "rolling": (*FORCES, *BINS, "drag_tangential"),
    "distance": (*FORCES, *BINS, "drag_tangential", "max_overlap"),
    "shear": ("shear_height", "steps"),
    **dict.fromkeys(("hopper", "hopper_changes"), PLACES),
    **dict.fromkeys(
        ("rft", "kinds", "lengths", "half_speed", "usual_speed", "twice_speed"), (*GRANULES, *STATE)
    ),
}
# No page shows more digits of these than float32 has.
ROUNDED = ("granule_x", "granule_y", "granule_angle", "run_curve", "wall_force")


def release(results: Path) -> None:
    """Write the released files, of docs/data and of studies, from those that a folder of results holds."""
    for each in FILES:
        source = results / each.source
        if not source.is_file():
            print(f"{source} is missing; {each.path} stays as it is")
            continue
        with xr.open_dataset(source) as dataset:
            kept = dataset.drop_vars(LEFT_OUT.get(each.name, ()), errors="ignore").load()
        kept.attrs["made_with"] = each.command
        kept.attrs["kernels"] = digest_at(kept.attrs["git_revision"])
        for name in ROUNDED:
            if name in kept:
                kept[name] = kept[name].astype("float32")
        packed = {
            name: {"zlib": True, "complevel": 9, "shuffle": True}
            for name, values in kept.variables.items()
            if values.dtype.kind in "fiu" and values.dims
        }
        with atomic(each.path) as part:
            kept.to_netcdf(part, format=FORMAT, encoding=packed)
        print(f"{each.path}: {each.path.stat().st_size / 1e6:.2f} MB")


def digest_at(revision: str) -> str:
    """The hash of a revision; if it is several ("a; b"), they must agree."""
    found = [_digest_at(each.strip()) for each in revision.split(";")]
    if len(set(found)) > 1:
        raise ValueError(
            f"The kernels differ between the revisions {revision}; run all of it again."
        )
    return found[0]


def _digest_at(revision: str) -> str:
    if not revision.isalnum():
        raise ValueError(f"git_revision is {revision}: edited files made it; commit and run again.")
    command = ["git", "archive", revision, "dem"]
    archive = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout
    with TemporaryDirectory() as folder:
        with tarfile.open(fileobj=BytesIO(archive)) as tar:
            tar.extractall(folder, filter="data")
        return digest(Path(folder) / "dem")


if __name__ == "__main__":
    release(Path(sys.argv[1]))
