"""A sweep on its way: which files its blocks need, which of them are there, and how all are made."""

import json
import os
from collections.abc import Iterator
from contextlib import suppress
from functools import cached_property
from hashlib import sha256
from itertools import takewhile
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from dem.base.errors import InputError
from dem.base.files import Place, check_own
from dem.base.sources import ROOT, code_hash, codes, files_of
from dem.base.yaml_file import read
from dem.experiment.config import Replicate
from dem.sweep.config import CONFIG, Sweep, file_of, load, parse, save
from dem.sweep.expand import Block
from dem.sweep.jobs import plan_batches
from dem.sweep.ownership import (
    OWNER,
    RECIPE,
    Combined,
    lost_runs,
    read_combined,
    refuse_foreign,
)
from dem.sweep.precision import Lead, Numbers, short_of
from dem.sweep.store import FOLDER, Batch, Store
from dem.sweep.workers import Workers, make_batches

UNREAD = "batch", "figures", "results", "studies", "beside"  # nothing that is computed reads them


class Campaign:
    """A sweep and the store that holds its runs. Nothing is written before `begin`.

    file: what the sweep is known by, empty where it has none, None where nobody will ask. root: folder
    that all paths of the sweep are in, the working folder where it is left out.
    """

    def __init__(
        self, sweep: Sweep, store: Store | None = None, file: str | None = None, root: Path = Path()
    ):
        self.sweep, self.file, self.root = sweep, file, Path(root)
        self.store = store or Store(self.root / FOLDER)
        self._plans: dict[tuple[str, int], list[Batch]] = {}  # by block and round
        self._new: dict[str, list[Replicate]] = {}  # runs of batches whose plans are not written
        self._blocks: dict[str, list[Block]] = {}  # by round
        self._numbers: dict[str, Numbers] = {}
        self._ended: set[str] | None = None  # batches that `failed` has looked at
        self._failed: set[str] = set()
        self.said: list[str] = []  # sentences to show in the end

    @classmethod
    def of(cls, path: Path, root: Path = Path()) -> "Campaign":
        """The sweep of a file; of a resolved configuration with the root that it was written in."""
        sweep = load(path)
        own = f"{sweep.results}/{CONFIG}"
        if str(path).endswith(f"/{own}"):
            root = Path(str(path).removesuffix(own))
        return cls(sweep, None, file_of(sweep, path), root)

    @classmethod
    def of_values(cls, values: dict, files: list, root: str = "") -> "Campaign":
        """The sweep of the values that Snakemake has read of some files, and perhaps changed."""
        names = [os.path.relpath(file) for file in files]
        written = [read(Path(name)) for name in names]  # which refuses what Snakemake reads otherwise
        sweep = parse(values, ", ".join(names) or "the configuration")
        alone = written == [values]
        return cls(sweep, None, file_of(sweep, names[0]) if alone else "", root)

    @property
    def results(self) -> Path:
        """Folder of results."""
        return self.root / self.sweep.results

    @cached_property
    def folders(self) -> dict[str, str]:
        """Block by the folder of its combined files, below the root."""
        return {self.folder_of(name): name for name in self.sweep.blocks}

    def folder_of(self, block: str) -> str:
        """Folder of the combined files of a block, below the root."""
        alone = list(self.sweep.blocks) == ["drag"]
        return self.sweep.results if alone else f"{self.sweep.results}/{block}"

    def path_of(self, block: str, observable: str) -> Path:
        """The combined file of an observable of a block."""
        return self.root / self.folder_of(block) / f"{observable}.nc"

    def observables(self, block: str) -> tuple[str, ...]:
        """What the runs of a block record, each a combined file; snapshots stay in the batches."""
        recorded = self.block(block).runs[0].replicate.configuration.recorded
        return tuple(name for name in recorded if name != "snapshots")

    def needed(self, block: str) -> list[Path]:
        """Combined files of other blocks that the values of a block are derived from."""
        names = self.sweep.needed(block)
        return [self.path_of(name, each) for name in names for each in self.observables(name)]

    def is_known(self, block: str) -> bool:
        """Whether all values of a block are known, because what they are derived from is there."""
        return all(path.is_file() for path in self.needed(block))

    def block(self, name: str, rounds: int | None = None) -> Block:
        """All runs of a block; what is derived is as the file has it until it can be known.

        rounds: of replicates, after the first; all that the runs that there were suffice for if absent.
        """
        if name not in self._blocks:
            if not self.is_known(name):
                return self.sweep.block(name)
            derived = None
            if needed := self.needed(name):
                from dem.sweep.derive import derived_by  # with xarray, which a plan does not need

                derived = derived_by(self.sweep, needed)
            self._blocks[name] = [self.sweep.block(name, derived)]
            while self.grow(name):
                pass
        found = self._blocks[name]
        return found[-1 if rounds is None else min(rounds, len(found) - 1)]

    def grow(self, name: str) -> bool:
        """Add a round to a block, where all its runs are there and it takes one."""
        found = self._blocks[name]
        if found[-1].until is None:
            return False
        values = self.values(found[-1])
        if any(len(values[place]) < n for place, n in found[-1].counts.items()):
            return False
        every = np.concatenate(list(values.values()))
        if np.isnan(every).sum() > self.sweep.failures * every.size:
            return False  # more runs failed than may; combining says so
        if (grown := found[-1].grown(values, len(found))) is None:
            return False
        found.append(self.sweep.block(name, counts=grown))
        return True

    def values(self, block: Block) -> dict[Lead, np.ndarray]:
        """What is wanted of the runs of a block that there are, by place: one value a run, in the order of
        the seeds, up to the first that is not there."""
        there = self.numbers(block.until.variable).of(block)
        return {
            place: np.array([there[run.id] for run in takewhile(lambda run: run.id in there, runs)])
            for place, runs in block.replicates.items()
        }  # fmt: skip

    def numbers(self, variable: str) -> Numbers:
        """What the runs of the store gave, by the name of a variable."""
        return self._numbers.setdefault(variable, Numbers(self.store, variable))

    def rounds(self, name: str) -> Iterator[int]:
        """The rounds of a block, one after another; each must be made before the next."""
        if self.block(name).until:
            for number, found in enumerate(self._blocks[name]):  # which grow meanwhile
                yield number
                if found is self._blocks[name][-1]:
                    self.grow(name)

    def runs(self) -> set[str]:
        """Identities of all runs, as far as they are known."""
        return {run for name in self.sweep.blocks for run in self.block(name).places}

    def text(self, block: str | None = None, *without: str) -> str:
        """What is computed of the runs of a block, or of none, reads in the configuration, as text."""
        own = self.sweep.dump()
        others = {*UNREAD, *without, *(() if block is None else ("sweep",))}
        kept = {key: value for key, value in own.items() if key not in others}
        return json.dumps(kept) + ("" if block is None else json.dumps(self.sweep.blocks[block]))

    # What is there, and what is to be made

    def batches(self, block: str, rounds: int | None = None) -> list[Batch]:
        """The batches that hold the runs of a block; in one process always the same. rounds: after the
        first; all if absent."""
        for path in self.needed(block):
            if not path.is_file():
                raise InputError(f"{path}: it is missing; the block {block} needs it first.")
        for name in self.sweep.blocks:  # in one order, because blocks share runs
            if name == block or self.is_known(name):
                self.block(name)
                for number, found in enumerate(self._blocks[name]):
                    if (name, number) not in self._plans:
                        own = {each.id: each for batches in self._plans.values() for each in batches}
                        there = (self.store.complete() | own).values()
                        self._plans[name, number], new = plan_batches(
                            there, found.unique(), self.sweep.batch, self.sweep.results
                        )
                        self._new |= new
        last = len(self._blocks[block]) - 1
        return self._plans[block, last if rounds is None else min(rounds, last)]

    def files(self, block: str) -> list[Path]:
        """The files of the batches of a block."""
        return [self.store.file_of(batch.id) for batch in self.batches(block)]

    def begin(self, *blocks: str) -> str:
        """Write what jobs read: the resolved configuration, whose path is returned, and what the batches
        of some blocks are to make."""
        path = self.results / CONFIG
        save(self.sweep, path, self.file or "")  # first, so that pruning knows what is needed
        for name in blocks:
            self.batches(name)
            for number in range(len(self._blocks[name])):
                for batch in self._plans[name, number]:  # some may be planned for another block
                    if batch.id in self._new:
                        self.store.write_plan(batch, self.sweep.results, self._new.pop(batch.id))
        return str(path)

    def counts(self) -> tuple[int, int]:
        """How many runs are there, also of batches that have not ended, and how many the sweep has."""
        wanted = self.runs()
        there = {run for batch in self.store.complete().values() for run in batch.runs}
        kept = [run for run in wanted - there if self.store.run_of(run).is_file()]
        return len(wanted & there) + len(kept), len(wanted)

    def failed(self) -> int:
        """How many runs failed in batches that ended since this was first asked. Each file is read once,
        and none that was there before: reading takes a hundredth of a second."""
        there = self.store.complete().keys()
        if self._ended is None:
            self._ended = set(there)
        for batch in there - self._ended:
            self._ended.add(batch)
            with suppress(InputError, OSError):  # a damaged file is said by who needs it
                self._failed |= self.store.failed(batch)
        return len(self._failed & self.runs())

    # Combined files

    def combined(self) -> Iterator[tuple[str, Path]]:
        """The combined files that the sweep may write, each with its block."""
        for name in self.sweep.blocks:
            for observable in dict.fromkeys((*self.observables(name), "flow")):
                yield name, self.path_of(name, observable)

    def first(self, block: str) -> Path:
        """The combined file whose runs are compared; they are known early but for what is derived."""
        return self.path_of(block, self.observables(block)[0])

    def check(self) -> list[str]:
        """Raise InputError where a file that the sweep writes is a link or of another kind, or where the
        folder holds another sweep. Returns a sentence where runs will be gone."""
        said = []
        for path in (self.results / CONFIG, *(self.results / "flow").glob("*.nc")):
            check_own(Place("the file to write", path))
        for name, path in self.combined():
            check_own(Place("the file to write", path))
            found = read_combined(path)
            refuse_foreign(path, found, self.sweep, self.file)
            if path == self.first(name) and not self.sweep.needed(name):
                said += lost_runs(path, found, self.block(name).places)
        return said

    def combine(
        self, block: str, observable: str, output: Path, progress=lambda s: None, partial: bool = False
    ) -> None:
        """Write what an observable gave for all runs of a block, or for those that are there; raises
        InputError for another, RunError where a precision means nothing."""
        if observable not in (there := self.observables(block)):
            raise InputError(
                f"observable is {observable!r}; runs of {block} have {', '.join(there)}."
            )
        from dem.sweep.combine import combine

        found, before = self.block(block), read_combined(output)
        if partial and output.resolve() in (path.resolve() for _, path in self.combined()):
            raise InputError(
                f"output is {str(output)!r}, where the whole of the sweep will be; name another file for a part."
            )

        if found.until and not partial and observable == self.observables(block)[0]:
            self.said += short_of(found, self.values(found))
        files = files_of(("dem/sweep/combine.py", "dem/io/dataset.py"), ROOT)
        text = f"{code_hash(codes(files))} {self.text(block)} {observable}"
        recipe = sha256(text.encode()).hexdigest()
        if not partial and self._is_current(block, output, before, recipe):
            return

        def sign(file):
            self.sign(file)
            file.setncattr(RECIPE, recipe)

        with TemporaryDirectory() as folder:
            files = self._parts(block, Path(folder)) if partial else self.files(block)
            combine(files, self.sweep, found, observable, output, progress, sign, partial)
        if output == self.first(block) and self.sweep.needed(block):
            self.said += lost_runs(output, before, found.places)

    def _is_current(self, block: str, path: Path, combined: Combined | None, recipe: str) -> bool:
        """Whether a combined file need not be written again; what is drawn from it then stays too."""
        runs = set(self.block(block).places)
        if combined is None or (combined.recipe, set(combined.runs)) != (recipe, runs):
            return False
        written = path.stat().st_mtime_ns
        return all(file.stat().st_mtime_ns <= written for file in self.files(block))

    def _parts(self, block: str, folder: Path) -> list[Path]:
        """Files of the runs of a block that are there: finished batches, and in a folder those of others."""
        from dem.sweep.batch import write_batch

        files, runs = [], {run.id: run for run in self.block(block).unique()}
        for batch in self.batches(block):
            path = self.store.file_of(batch.id)
            if not path.is_file():
                path, kept = folder / path.name, {run: self.store.kept(run) for run in batch.runs if run in runs}
                if kept := {run: row for run, row in kept.items() if row}:
                    write_batch(path, [runs[run] for run in kept], list(kept.values()))
            files += [path] if path.is_file() else []
        if not files:
            raise InputError(f"no run of {block} is finished yet; dem status shows what is there.")
        return files

    def sign(self, file) -> None:
        """Write into a combined file, a netCDF4.Dataset, which sweep it is of."""
        if self.file is not None:
            file.setncattr(OWNER, self.file)

    def make(self, workers: Workers, progress=lambda done, failed, compiles: None) -> None:
        """Make all that is not there yet, on some workers, but flow.nc (dem.analysis.flow); raises
        RunError. progress is called with how many runs are there, how many of the new ones failed, and
        whether any compiles."""
        for name in self.sweep.blocks:  # a block comes after those that it needs
            while True:
                self._make(name, workers, progress)
                if not self.grow(name):
                    break
            for observable in self.observables(name):
                if observable != "flow":
                    self.combine(name, observable, self.path_of(name, observable))

    def _make(self, name: str, workers: Workers, progress) -> None:
        """Make the runs of a block that are known and not there."""
        self.begin(name)
        new = [each for each in self.batches(name) if not self.store.file_of(each.id).is_file()]
        kept = sum(self.store.run_of(run).is_file() for each in new for run in each.runs)
        before = self.counts()[0] - kept
        make_batches(self.store, new, workers, lambda n, *more: progress(before + n, *more))
        self._plans.clear()  # some runs may have been put into batches of their own
        self._new.clear()


def of_new_store(store: Store, file: Path) -> str | None:
    """A sentence where a sweep begins a store, with the store that is near its file; else None.

    The store is below the folder where a sweep is started, so that another folder has none of its runs.
    """
    if store.is_there():
        return None
    said = f"{store.folder.absolute()}: this store of runs is new, and has none yet"
    for near in Path(file).resolve().parents:
        if (near / FOLDER).is_dir():
            return f"{said}; to use the runs of {near / FOLDER}, start in {near}."
    return f"{said}; sweeps that are started in this folder share it."
