"""What a script has measured: printed, and written to a netCDF file for the documentation."""

import argparse
import os
import resource
import sys
from pathlib import Path

import numpy as np

from dem.base import provenance
from dem.io.dataset import global_attributes, write

sys.path.append(str(Path(__file__).parents[2] / "tests"))
from kernels import digest

LOAD = os.getloadavg()[0]  # before the script adds its own


def processor_time() -> float:
    """Of all processes that this one started and that have ended, in s.

    A computer with other work to do changes it little; wall times, a lot.
    """
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def arguments(about: str, **numbers) -> argparse.Namespace:
    """Whole numbers by name, as argparse takes them, and -o PATH."""
    parser = argparse.ArgumentParser(
        description=about, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    for name, options in numbers.items():
        parser.add_argument(name, type=int, **options)
    parser.add_argument("-o", "--output", type=Path, help="netCDF file")
    return parser.parse_args()


def report(values: dict, layout: dict, title: str, output: Path | None) -> None:
    """Print values with their units and words, and write them where there is an output.

    layout: name: (dimensions, units, long name), as in dem.io.dataset.
    """
    for name, value in values.items():
        _, units, words = layout[name]
        print(f"{words} ({units}): {np.array2string(np.asarray(value), precision=3)}")
    if output is None:
        return
    words = [word for word in sys.argv[1:] if word not in ("-o", "--output", str(output))]
    command = " ".join(["python", f"docs/data/{Path(sys.argv[0]).name}", *words])
    attrs = global_attributes(
        title,
        command,
        made_with=command,
        versions=provenance.versions(),
        git_revision=provenance.git_revision(),
        kernels=digest(),
        comment=f"The {os.cpu_count()} cores were shared; their load average was {LOAD:.1f} before.",
    )
    write(output, values, attrs, layout)
