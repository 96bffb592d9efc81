"""Owner and run ids of a combined file that exists, such as drag.nc."""

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from dem.base.errors import InputError
from dem.sweep.config import Sweep

OWNER = "sweep_file"  # attribute: the file of the sweep, empty where it has none
RECIPE = "combined_by"  # attribute: hash of the code and the values by which runs were combined


class Combined(NamedTuple):
    """A combined file.

    owner: the file of its sweep, empty where the sweep has none, None where the combined file does
        not say.
    recipe: hash of the code and the values by which its runs were combined, empty where it has
        none.
    title: of the sweep.
    runs: identities of its runs.
    """

    owner: str | None
    recipe: str
    title: str
    runs: tuple[str, ...]


def read_combined(path: Path) -> Combined | None:
    """Owner and runs of a combined file, None where there is none that can be read."""
    if not Path(path).is_file():
        return None
    import netCDF4  # not for those who only plan

    try:
        with netCDF4.Dataset(path) as file:
            attrs = {name: str(file.getncattr(name)) for name in file.ncattrs()}
            variable = file.variables.get("run_id")
            runs = () if variable is None else variable[...].ravel().tolist()
    except Exception:  # damage makes the library raise many errors; nothing good is lost
        return None
    ids = tuple(filter(None, map(str, runs)))
    return Combined(attrs.get(OWNER), attrs.get(RECIPE, ""), attrs.get("title", ""), ids)


def refuse_foreign(path: Path, combined: Combined | None, sweep: Sweep, file: str | None) -> None:
    """Raise InputError where a combined file is another sweep's.

    A sweep is known by its file; one without, by its title. A file that was renamed is known by its
    title too.
    """
    if combined is None or None in (combined.owner, file) or combined.owner == file:
        return
    renamed = not (combined.owner and file and Path(combined.owner).exists())
    if renamed and combined.title.startswith(sweep.title):  # that of flow.nc says more
        return
    owner = combined.owner or f"the sweep {combined.title!r}"
    raise InputError(
        f"results is {sweep.results!r}, which has the results of {owner} ({path}): name another "
        f"folder in {file or 'the configuration'}, or move what is there away."
    )


def lost_runs(path: Path, combined: Combined | None, runs: Iterable[str]) -> list[str]:
    """A sentence where a combined file has runs that its sweep has no longer."""
    held = set(combined.runs if combined else ())
    if not (lost := held - set(runs)):
        return []
    return [
        f"{path}: {len(lost)} of the {len(held)} runs that it held are no longer in this sweep, "
        "because its values or the code changed; the store keeps them until dem store --prune."
    ]
