"""Time and memory of combining and drawing thousands of replicates, one computer, smoke beds.

python tests/ensembles.py 100 1000 10000

One replicate is simulated; the others are copies of it that say that they are other seeds, so that it
is the files that are measured. Each command runs in a process of its own.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import netCDF4
import yaml

from dem.batch import batch
from dem.config import parse, save

SMOKE = Path(__file__).parent.parent / "config/smoke.yaml"
MEASURED = """
import resource, sys, time
from dem.cli import app
started = time.time()
try:
    app(sys.argv[1:])
except SystemExit as done:
    assert not done.code, done.code
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
print(f"{time.time() - started:.1f} s, {peak:.0f} MB")
"""


def sweep_of(count):
    """The smoke sweep with one case and so many seeds."""
    data = yaml.safe_load(SMOKE.read_text())
    kept = {key: value for key, value in data.items() if key not in ("claims", "accuracy")}
    kept |= {"cases": {"c1": data["cases"]["c1"]}, "shapes": {"c1": data["shapes"]["c1"]}}
    return parse(kept | {"seeds": list(range(1, count + 1)), "batch": 100})


def copies(folder, first, sweep):
    """A file for every replicate that has none."""
    for replicate in sweep.replicates():
        target = folder / replicate.path
        if not target.exists():
            shutil.copy(first, target)
            with netCDF4.Dataset(target, "a") as file:
                file["seed"][...] = replicate.seed
                file.run_key = replicate.run_key()


def measured(*arguments):
    """Wall time and peak memory of a command."""
    command = [sys.executable, "-c", MEASURED, *map(str, arguments)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def main(counts):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        batch(sweep_of(1), "c1", 0, folder)
        first = folder / sweep_of(1).replicates()[0].path
        for count in counts:
            sweep = sweep_of(count)
            copies(folder, first, sweep)
            save(sweep, folder / "sweep.yaml")
            drag = folder / "drag.nc"
            combined = measured("combine", "--config", folder / "sweep.yaml", "-o", drag)
            drawn = measured("figure", "figure13", drag)
            print(f"{count} replicates: combined in {combined}; figure13 in {drawn}", flush=True)


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]] or [100, 1000])
