"""The store that all sweeps share: which runs each file holds, finished runs, beds.

plans/{chunk}.json      the runs of a chunk: identities and values; written once
chunks/{chunk}.nc       what they gave
runs/{xx}/{run}.npz     finished runs of chunks under way, and checkpoints of those that run
beds/{xx}/{bed}.npz     beds, for all runs that share them
sweeps/{sweep}.json     which chunks the last plan of every sweep needs
"""

import hashlib
import json
import os
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
from filelock import FileLock, Timeout

from dem.base.errors import InputError, RunError
from dem.base.files import atomic, check_file
from dem.base.sources import code_hash
from dem.experiment.config import Replicate, of_values
from dem.io.checksums import is_sealed, seal
from dem.io.results_folder import lock_of

FOLDER = Path("results/store")
NOTHING = "So nothing was removed."
KERNELS = "dem.dynamics.simulation", "dem.packing.pressed"  # modules that call all kernels of runs
NAMES = {  # of the files in each folder; others are not the store's
    "plans": r"[0-9a-f]{16}\.json",
    "chunks": r"[0-9a-f]{16}\.nc",
    "runs": r"[0-9a-f]{32}(\.checkpoint)?\.npz",
    "beds": r"[0-9a-f]{32}\.npz",
}


class Chunk(NamedTuple):
    """Some runs that are made by one process into one file: its identity, their identities."""

    id: str
    runs: tuple[str, ...]
    kernels: str  # what machine code they need


class Store:
    """A folder of runs."""

    def __init__(self, folder: Path = FOLDER):
        self.folder = Path(folder)

    def plan_of(self, chunk: str) -> Path:
        """The file of a plan."""
        return self.folder / "plans" / f"{chunk}.json"

    def file_of(self, chunk: str) -> Path:
        """The file of a chunk."""
        return self.folder / "chunks" / f"{chunk}.nc"

    def run_of(self, run: str, end: str = ".npz") -> Path:
        """The file of a run that is in no chunk yet."""
        return self.folder / "runs" / run[:2] / f"{run}{end}"

    def is_there(self) -> bool:
        """Whether there is a store; raises InputError where its folders are something else, such as
        links to a disk that is away, because all runs would be made again."""
        for folder in (self.folder, *(self.folder / name for name in (*NAMES, "sweeps"))):
            if os.path.lexists(folder) and not folder.is_dir():
                raise InputError(
                    f"{folder}: it is no folder; if it is a link, connect the disk that it leads to, else "
                    "remove it."
                )
        return self.folder.is_dir()

    def locked(self) -> FileLock:
        """Holds the plans, for a moment."""
        self.is_there()
        self.folder.mkdir(parents=True, exist_ok=True)
        return lock_of(self.folder / ".lock")

    # Plans

    def planned(self) -> dict[str, Chunk]:
        """All plans, by chunk."""
        found = {}
        for path in sorted((self.folder / "plans").glob("*.json")):
            with suppress(InputError):  # it is planned again
                found[path.stem] = self.read_plan(path.stem)
        return found

    def read_plan(self, chunk: str) -> Chunk:
        """A plan without the values of its runs; raises InputError where there is none."""
        return self._read_plan(chunk)[0]

    def _read_plan(self, chunk: str) -> tuple[Chunk, dict]:
        """A plan, and all that its file holds."""
        path = self.plan_of(chunk)
        if not path.exists():
            raise InputError(f"{path}: there is no such plan; start the sweep again.")
        check_file(path)
        try:
            data = _read(path)
            runs, kernels = _texts(data["runs"]), data["kernels"]
            if not isinstance(kernels, str):
                raise ValueError("it names no kernels")
            return Chunk(chunk, tuple(runs), kernels), data
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise _no_plan(path, error) from None

    def replicates(self, chunk: str) -> list[Replicate]:
        """The runs of a chunk; raises InputError where there is no such plan, or where the code is
        no longer that which the plan was made for."""
        found = self.as_planned(chunk)
        if tuple(replicate.id for replicate in found) != self.read_plan(chunk).runs:
            raise InputError(
                f"{self.plan_of(chunk)}: its runs were planned for other code; start the sweep again."
            )
        return found

    def as_planned(self, chunk: str) -> list[Replicate]:
        """The runs of a chunk, planned for any code."""
        _, data = self._read_plan(chunk)
        try:
            return [of_values(data["values"][at] | own) for at, own in data["of"]]
        except (ValueError, KeyError, TypeError, IndexError) as error:
            raise _no_plan(self.plan_of(chunk), error) from None

    def write_plan(self, chunk: Chunk, replicates: list[Replicate]) -> None:
        """Keep which runs a chunk holds, with their values."""
        values, places, of = [], {}, []
        for replicate in replicates:
            place = places.setdefault(id(replicate.configuration), len(values))
            if place == len(values):
                values.append(replicate.values())
            own = {"shape": replicate.label, "density": replicate.density, "seed": replicate.seed}
            of.append([place, own])
        data = {"runs": chunk.runs, "kernels": chunk.kernels, "of": of, "values": values}
        _write(self.plan_of(chunk.id), data)

    # Sweeps

    def _sweep(self, results: str) -> Path:
        name = hashlib.sha256(str(Path(results).resolve()).encode()).hexdigest()[:16]
        return self.folder / "sweeps" / f"{name}.json"

    def register(
        self, results: str, part: str, chunks: Iterable[str], parts: Iterable[str]
    ) -> None:
        """Record which chunks a part of a sweep needs; forget parts that no longer exist."""
        path, before = self._sweep(results), {}
        with suppress(InputError):  # of none, or one that is damaged
            _, before = _read_record(path)
        kept = {name: before[name] for name in before if name in set(parts)}
        kept[part] = sorted(chunks)
        _write(path, {"results": str(results), "parts": kept})

    def _records(self) -> list[Path]:
        return sorted((self.folder / "sweeps").glob("*.json"))

    def needed(self) -> dict[str, set[str]]:
        """Folder of results and chunks of every sweep whose record and results are there."""
        found = {}
        for path in self._records():
            with suppress(InputError):
                results, parts = _read_record(path)
                if _is_there(results):
                    found[results] = set().union(*parts.values())
        return found

    def _surely_needed(self) -> dict[str, Chunk]:
        """The chunks that sweeps need; raises InputError unless it is known of all sweeps."""
        found, faults = {}, []
        for path in self._records():
            try:
                results, parts = _read_record(path)
                if not _is_there(results):
                    faults.append(
                        f"{results}: this folder of a sweep is not there; connect its disk, or, if you "
                        f"deleted the folder for good, delete {path} too."
                    )
                    continue
            except InputError as error:
                faults.append(str(error))
                continue
            for chunk in sorted(set().union(*parts.values())):
                try:
                    found[chunk] = self.read_plan(chunk)
                except InputError as error:
                    faults.append(str(error))
        if not self._records() and next(self._files(), None):
            faults.append(
                f"{self.folder / 'sweeps'}: no sweep is recorded here; start the sweeps again whose runs "
                f"you want to keep, or delete the folder {self.folder} if you want none of them."
            )
        if faults:
            raise InputError("\n".join([*dict.fromkeys(faults), NOTHING]))
        return found

    def registered(self, results: str) -> dict[str, Chunk]:
        """The chunks of a sweep's last plan."""
        found = {}
        with suppress(InputError):
            _, parts = _read_record(self._sweep(results))
            for chunk in set().union(*parts.values()):
                with suppress(InputError):
                    found[chunk] = self.read_plan(chunk)
        return found

    def under_way(self, results: str) -> set[str]:
        """Chunks that other sweeps need which run at this moment."""
        found = set()
        for folder, chunks in self.needed().items():
            if Path(folder) != Path(results) and _held(folder):
                found |= chunks
        return found

    # Beds and finished runs

    def file_of_bed(self, replicate: Replicate) -> Path:
        name = replicate.bed_id
        return self.folder / "beds" / name[:2] / f"{name}.npz"

    def forget_beds(self, replicates: Iterable[Replicate]) -> None:
        """Remove the beds of some runs."""
        for replicate in replicates:
            self.file_of_bed(replicate).unlink(missing_ok=True)

    def bed(self, replicate: Replicate, make) -> dict:
        """The bed of a run by the names of Bed, but for its periods: the stored one, or as
        `make(replicate)` packs it, once for all processes."""
        path = self.file_of_bed(replicate)
        if (found := _load(path)) is None:
            path.parent.mkdir(parents=True, exist_ok=True)
            with lock_of(path.parent / ".lock"):
                if (found := _load(path)) is None:
                    found = make(replicate)._asdict()
                    del found["periodic"]  # the configuration says it
                    _save(path, found)
        return found

    def keep(self, run: str, values: dict) -> None:
        """Keep what a run gave until its chunk is whole."""
        _save(self.run_of(run), values)

    def kept(self, run: str) -> dict | None:
        """What a run gave, None if it is not there or damaged."""
        return _load(self.run_of(run))

    def forget(self, runs: Iterable[str]) -> None:
        """Remove runs that a chunk holds now."""
        for run in runs:
            for end in (".npz", ".checkpoint.npz"):
                self.run_of(run, end).unlink(missing_ok=True)

    # What there is too much

    def prune(self) -> tuple[list[Path], int]:
        """Remove what no sweep needs; returns the files and their bytes.

        Raises InputError, and removes nothing, where it cannot be known what a sweep needs.
        """
        with self.locked():
            chunks = self._surely_needed()
            runs = {run for chunk in chunks.values() for run in chunk.runs}
            beds = set()
            for chunk in chunks:
                with suppress(InputError):  # of another schema, which needs other beds
                    beds |= {replicate.bed_id for replicate in self.as_planned(chunk)}
            gone, size = [], 0
            for path in self._files():
                kept = {"plans": chunks, "chunks": chunks, "runs": runs, "beds": beds}[
                    path.relative_to(self.folder).parts[0]
                ]
                if path.name.partition(".")[0] not in kept:
                    size += path.stat().st_size
                    path.unlink()
                    gone.append(path)
            return gone, size

    def _files(self) -> Iterator[Path]:
        for folder, name in NAMES.items():
            for path in sorted((self.folder / folder).rglob("*")):
                if path.is_file() and re.fullmatch(name, path.name):
                    yield path


def _no_plan(path: Path, error: Exception) -> InputError:
    return InputError(
        f"{path}: it is no plan of a chunk ({_why(error)}); delete it and start the sweep again."
    )


def _why(error: Exception) -> str:
    if isinstance(error, KeyError):
        return f"it has no {error.args[0]}"
    return getattr(error, "strerror", None) or str(error)


def _texts(value) -> list[str]:
    """A list of some texts; raises ValueError for anything else."""
    if not isinstance(value, list) or not value or not all(isinstance(v, str) for v in value):
        raise ValueError("it lacks a list of names")
    return value


def _read_record(path: Path) -> tuple[str, dict[str, list[str]]]:
    """The folder of results of a sweep, and the chunks that each part of it needs; raises InputError."""
    check_file(path)
    try:
        data = _read(path)
        results, parts = data["results"], data["parts"]
        if not isinstance(results, str) or not results.isprintable() or not results:
            raise ValueError("it names no folder of results")
        if not isinstance(parts, dict) or not parts:
            raise ValueError("it has no parts")
        return results, {name: _texts(parts[name]) for name in parts}
    except (OSError, ValueError, KeyError) as error:
        raise InputError(
            f"{path}: it is no record of a sweep ({_why(error)}); start your sweeps again, which mends it, or "
            "delete it if its sweep is none of them."
        ) from None


def _sum(data: dict) -> str:
    return hashlib.sha256(json.dumps(data).encode()).hexdigest()


def _write(path: Path, data: dict) -> None:
    """Write values by name with their checksum, so that a change is noticed."""
    with atomic(path) as part:
        part.write_text(json.dumps(data | {"sha256": _sum(data)}), encoding="utf-8")


def _read(path: Path) -> dict:
    """What `_write` wrote, or an earlier version without a checksum; raises ValueError, OSError."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(data, dict):
            raise ValueError("it holds no values by name")
        if data.pop("sha256", None) not in (None, _sum(data)):
            raise ValueError("it was changed")
        return data
    except RecursionError:
        raise ValueError("its values are nested too deep") from None


def _is_there(results: str) -> bool:
    with suppress(OSError):  # a record may hold any text
        return Path(results).is_dir()
    return False


def _held(results: str) -> bool:
    """Whether a workflow works in a folder of results at this moment."""
    try:
        FileLock(Path(results) / ".lock", timeout=0).acquire().lock.release()
    except Timeout:
        return True
    except OSError:
        return False
    return False


def _save(path: Path, values: dict) -> None:
    with atomic(path) as part, part.open("wb") as file:
        np.savez(file, **values)
        file.close()
        seal(part)


def _load(path: Path) -> dict | None:
    check_file(path)
    try:
        if path.is_file() and is_sealed(path):
            with np.load(path) as file:
                return {name: file[name] for name in file.files}
    except Exception:  # damage makes numpy raise many errors; the bed is packed again
        path.unlink(missing_ok=True)
    return None


def check_place(place: Path, folder: Path = FOLDER) -> None:
    """Raise InputError for a place in a store: what is put there would replace its runs."""
    above = Path(place).parent.resolve()
    if folder.is_dir() and any(
        each.is_dir() and each.samefile(folder) for each in (above, *above.parents)
    ):
        raise InputError(f"output is {str(place)!r}; the store is there, name another file.")


def link_to(target: Path, place: Path) -> None:
    """A link to a file of the store, relative, so that both can be moved together."""
    check_place(place, target.parents[1])
    place.parent.mkdir(parents=True, exist_ok=True)
    try:
        place.unlink(missing_ok=True)
        place.symlink_to(os.path.relpath(target.resolve(), place.parent.resolve()))
    except OSError as error:
        raise RunError(f"{place}: it cannot be made a link to {target} ({error}).") from None


# How runs are put together


def alike(replicate: Replicate) -> tuple:
    """What runs of one chunk share: the size of their arrays and their machine code."""
    own = replicate.configuration
    sizes = own.module.sizes(replicate)
    stroke = own.cylinder.stroke if own.cylinder else None
    return own.experiment, own.observables, stroke, *sizes.values()


def kernels_of(replicate: Replicate) -> str:
    """What the machine code of a run is known by; nothing that is not in the run's own identity.

    Not by all code of the run: most of it is compiled nowhere, and kinds of runs share the rest.
    """
    text = f"{code_hash(*KERNELS, replicate.kind.module, bits=True)} {replicate.variant}"
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def plan(
    store: Store,
    replicates: Iterable[Replicate],
    size: int,
    results: str,
    own: dict[str, Chunk] | None = None,
) -> tuple[list[Chunk], dict[str, list[Replicate]]]:
    """The chunks that hold some runs: those that there are, and new ones for the rest, with their
    runs. Nothing is written.

    A chunk that is planned stays as it is if it is there, if another sweep is making it, if it is one
    of this sweep's (`own`), or if all its runs are wanted here. Runs of one bed are put together.
    """
    wanted = {replicate.id: replicate for replicate in replicates}
    found, left, own, moved = [], dict(wanted), own or {}, {}
    plans, busy = store.planned() | own, store.under_way(results)

    def rank(chunk):
        there = store.file_of(chunk.id).exists()
        fixed = chunk.id in busy or chunk.id in own
        return (not there, not fixed, -len(chunk.runs), chunk.id)

    for chunk in sorted(plans.values(), key=rank):
        mine = [run for run in chunk.runs if run in left]
        lasting = rank(chunk)[:2] != (True, True) or all(run in wanted for run in chunk.runs)
        if mine and lasting:
            found.append(chunk)
            if all(run in wanted and wanted[run].configuration.beside for run in chunk.runs):
                moved[chunk.id] = [wanted[run] for run in chunk.runs]
            for run in mine:
                del left[run]
    groups = {}
    for replicate in left.values():
        beds = groups.setdefault((alike(replicate), kernels_of(replicate)), {})
        beds.setdefault(replicate.bed_key(), []).append(replicate)
    new = moved  # whose plans are written: the folder of their shapes may be another since
    for (_, kernels), beds in groups.items():
        for some in _cut(list(beds.values()), size):
            runs = tuple(replicate.id for replicate in some)
            chunk = Chunk(hashlib.sha256(" ".join(runs).encode()).hexdigest()[:16], runs, kernels)
            found.append(chunk)
            new[chunk.id] = some
    return found, new


def _cut(beds: list[list[Replicate]], size: int) -> Iterator[list[Replicate]]:
    """Runs in chunks of at most a size, those of one bed together where they fit."""
    some = []
    for bed in beds:
        if some and len(some) + len(bed) > size:
            yield some
            some = []
        some = some + bed
        while len(some) > size:
            yield some[:size]
            some = some[size:]
    if some:
        yield some


def settle(
    store: Store, results: str, part: str, chunks: list[Chunk], new: dict, parts: Iterable[str]
) -> None:
    """Write a plan; raises RunError where another sweep has planned the same runs since."""
    with store.locked():
        mine = {run for chunk in chunks if chunk.id in new for run in chunk.runs}
        for chunk in store.under_way(results) - {chunk.id for chunk in chunks}:
            with suppress(InputError):
                if mine & set(store.read_plan(chunk).runs):
                    raise RunError(
                        f"{results}: another sweep has just planned some of these runs; run the same "
                        "command again."
                    )
        for chunk in chunks:
            if chunk.id in new:
                store.write_plan(chunk, new[chunk.id])
        store.register(results, part, [chunk.id for chunk in chunks], parts)
