"""The combined files of a sweep: whose an existing one is, which runs it holds, and making it.

dem.sweep.combine writes the file.
"""

import hashlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from dem.base.errors import InputError
from dem.base.sources import ROOT, code_hash, codes, files_of
from dem.sweep.config import Sweep
from dem.sweep.expand import Block
from dem.sweep.precision import short_of
from dem.sweep.store import Batch, Store

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
    if renamed and combined.title == sweep.title:
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


def combine_block(
    state,
    name: str,
    observable: str,
    output: Path,
    progress=lambda done: None,
    partial: bool = False,
) -> None:
    """Write what an observable gave for all runs of a block of a SweepState, unless the file is up
    to date.

    partial: for those runs that exist. Raises InputError for an observable that the runs lack,
    RunError where a precision means nothing.
    """
    from dem.sweep.combine import BEDS, combine  # with netCDF4, which a plan does not need

    known = state.observables(name)
    if observable not in known:
        raise InputError(f"observable is {observable!r}; runs of {name} have {', '.join(known)}.")
    if partial:
        whole = [path.resolve() for each in state.sweep.blocks for path in state.combined(each)]
        if output.resolve() in whole:
            raise InputError(
                f"output is {str(output)!r}, where the whole of the sweep will be; name another "
                "file for a part."
            )
    block = state.block(name)
    if block.until and not partial and observable == known[0]:
        state.notes += short_of(block, state.values(block))
    if observable == BEDS:
        block = block.first_seeds()
    sources = files_of(("dem/sweep/combine.py", "dem/io/dataset.py"), ROOT)
    text = f"{code_hash(codes(sources))} {state.text(name)} {observable}"
    attrs = {RECIPE: hashlib.sha256(text.encode()).hexdigest()}
    attrs |= {} if state.file is None else {OWNER: state.file}
    batches = [
        each for each in state.batches(name) if not block.points.keys().isdisjoint(each.runs)
    ]
    files = [state.store.file_of(batch.id) for batch in batches]
    before = read_combined(output)
    if before and not partial and before.recipe == attrs[RECIPE]:
        written = output.stat().st_mtime_ns
        if {*before.runs} == {*block.points} and all(
            f.stat().st_mtime_ns <= written for f in files
        ):
            return  # so that what is drawn from it is not drawn again
    with TemporaryDirectory() as folder:
        if partial:
            files = list(_existing(state.store, block, batches, Path(folder)))
            if not files:
                raise InputError(
                    f"no run of {name} is finished yet; dem status shows how far the sweep is."
                )
        combine(files, state.sweep, block, observable, output, progress, attrs, partial)
    if output == state.combined(name)[0] and state.sweep.needed(name):
        state.notes += lost_runs(output, before, block.points)


def _existing(store: Store, block: Block, batches: list[Batch], folder: Path) -> Iterator[Path]:
    """Files of the runs of a block that exist: finished batches, and in a folder the runs of
    others."""
    from dem.sweep.batch import write_batch  # with the kernels

    runs = {run.id: run for run in block.unique()}
    for batch in batches:
        path = store.file_of(batch.id)
        if path.is_file():
            yield path
        elif rows := {run: row for run in batch.runs if run in runs and (row := store.kept(run))}:
            path = folder / path.name
            write_batch(path, [runs[run] for run in rows], list(rows.values()))
            yield path
