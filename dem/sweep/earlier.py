"""What a combined file that is there holds: whose it is, and which runs."""

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from dem.base.errors import InputError
from dem.sweep.config import Sweep

OWNER = "sweep_file"  # attribute: the file of the sweep, empty where it has none
RECIPE = "combined_by"  # attribute: hash of the code and the values by which runs were combined


class Earlier(NamedTuple):
    """A combined file. file: None where it does not say its sweep; recipe: hash of the code and the
    values by which its runs were combined, empty where it has none."""

    file: str | None
    recipe: str
    title: str
    runs: tuple[str, ...]


def read_earlier(path: Path) -> Earlier | None:
    """What a combined file says of itself, None where there is none that can be read."""
    if not Path(path).is_file():
        return None
    import netCDF4  # not for those who only plan

    try:
        with netCDF4.Dataset(path) as file:
            told = {name: str(file.getncattr(name)) for name in file.ncattrs()}
            runs = (
                file.variables["run_id"][...].ravel().tolist() if "run_id" in file.variables else ()
            )
    except Exception:  # damage makes the library raise many errors; nothing good is lost
        return None
    ids = tuple(filter(None, map(str, runs)))
    return Earlier(told.get(OWNER), told.get(RECIPE, ""), told.get("title", ""), ids)


def refuse_other(path: Path, earlier: Earlier | None, sweep: Sweep, file: str | None) -> None:
    """Raise InputError where a combined file is another sweep's.

    A sweep is known by its file; one without, by its title. A file that was renamed is known by its
    title too.
    """
    if earlier is None or earlier.file is None or file is None or earlier.file == file:
        return
    renamed = not (earlier.file and file and Path(earlier.file).exists())
    if renamed and earlier.title == sweep.title:
        return
    whose = earlier.file or f"the sweep {earlier.title!r}"
    raise InputError(
        f"results is {sweep.results!r}, which has the results of {whose} ({path}): name another folder "
        f"in {file or 'the configuration'}, or move what is there away."
    )


def replaced(path: Path, earlier: Earlier | None, runs: Iterable[str]) -> list[str]:
    """A sentence where a combined file has runs that a sweep has no longer."""
    held = set(earlier.runs if earlier else ())
    if not (gone := held - set(runs)):
        return []
    return [
        f"{path}: {len(gone)} of the {len(held)} runs that it held are no longer in this sweep, because "
        "its values or the code changed; the store keeps them until dem store --prune."
    ]
