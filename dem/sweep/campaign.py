"""A sweep on its way: which files its blocks need, which of them are there, and how all are made."""

import json
import os
from collections.abc import Iterator
from contextlib import suppress
from functools import cached_property
from pathlib import Path

from dem.base.errors import InputError
from dem.base.files import Place, check_own
from dem.base.yaml_file import read
from dem.sweep.config import CONFIG, Sweep, file_of, load, parse, save
from dem.sweep.earlier import read_earlier, refuse_other, replaced
from dem.sweep.expand import Block
from dem.sweep.store import FOLDER, Batch, Store, plan
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
        self._plans: dict[str, tuple[list[Batch], dict]] = {}
        self._blocks: dict[str, Block] = {}
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
        sweep = parse(values, ", ".join(names) or "the configuration")
        alone = len(names) == 1 and read(Path(names[0])) == values
        return cls(sweep, None, file_of(sweep, names[0]) if alone else "", root)

    @property
    def results(self) -> Path:
        """Folder of results."""
        return self.root / self.sweep.results

    @cached_property
    def folders(self) -> dict[str, str]:
        """Block by the folder of its combined files, below the root."""
        results = self.sweep.results
        if list(self.sweep.blocks) == ["drag"]:
            return {results: "drag"}
        return {f"{results}/{name}": name for name in self.sweep.blocks}

    def folder_of(self, block: str) -> str:
        """Folder of the combined files of a block, below the root."""
        return next(folder for folder, name in self.folders.items() if name == block)

    def observables(self, block: str) -> tuple[str, ...]:
        """What the runs of a block record, each a combined file; snapshots stay in the batches."""
        recorded = self.block(block).runs[0].replicate.configuration.recorded
        return tuple(name for name in recorded if name != "snapshots")

    def needed(self, block: str) -> list[Path]:
        """Combined files of other blocks that the values of a block are derived from."""
        return [
            self.root / self.folder_of(name) / f"{observable}.nc"
            for name in self.sweep.needed(block)
            for observable in self.observables(name)
        ]

    def is_known(self, block: str) -> bool:
        """Whether all values of a block are known, because what they are derived from is there."""
        return all(path.is_file() for path in self.needed(block))

    def block(self, name: str) -> Block:
        """All runs of a block; what is derived is as the file has it until it can be known."""
        if name in self._blocks:
            return self._blocks[name]
        if not self.is_known(name):
            return self.sweep.block(name)
        if not (needed := self.needed(name)):
            return self._blocks.setdefault(name, self.sweep.block(name))
        from dem.sweep.derive import derived_by  # with xarray, which a plan does not need

        derived = derived_by(self.sweep, needed)
        return self._blocks.setdefault(name, self.sweep.block(name, derived))

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

    def batches(self, block: str) -> list[Batch]:
        """The batches that hold the runs of a block; in one process always the same."""
        for path in self.needed(block):
            if not path.is_file():
                raise InputError(f"{path}: it is missing; the block {block} needs it first.")
        for name in self.sweep.blocks:  # in one order, because blocks share runs
            if name not in self._plans and (name == block or self.is_known(name)):
                own = {each.id: each for batches, _ in self._plans.values() for each in batches}
                there = (self.store.sealed() | own).values()
                found = self.block(name).unique()
                self._plans[name] = plan(there, found, self.sweep.batch, self.sweep.results)
        return self._plans[block][0]

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
            batches, new = self._plans[name]
            for batch in batches:
                if batch.id in new:
                    self.store.write_plan(batch, self.sweep.results, new[batch.id])
            self._plans[name] = batches, {}
        return str(path)

    def counts(self) -> tuple[int, int]:
        """How many runs are there, also of batches that have not ended, and how many the sweep has."""
        wanted = self.runs()
        there = {run for batch in self.store.sealed().values() for run in batch.runs}
        kept = [run for run in wanted - there if self.store.run_of(run).is_file()]
        return len(wanted & there) + len(kept), len(wanted)

    def failed(self) -> int:
        """How many runs failed in batches that ended since this was first asked. Each file is read once,
        and none that was there before: reading takes a hundredth of a second."""
        there = self.store.sealed().keys()
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
        for folder, name in self.folders.items():
            for observable in dict.fromkeys((*self.observables(name), "flow")):
                yield name, self.root / folder / f"{observable}.nc"

    def first(self, block: str) -> Path:
        """The combined file whose runs are compared; they are known early but for what is derived."""
        return self.root / self.folder_of(block) / f"{self.observables(block)[0]}.nc"

    def check(self) -> list[str]:
        """Raise InputError where a file that the sweep writes is a link or of another kind, or where the
        folder holds another sweep. Returns a sentence where runs will be gone."""
        said = []
        for path in (self.results / CONFIG, *(self.results / "flow").glob("*.nc")):
            check_own(Place("the file to write", path))
        for name, path in self.combined():
            check_own(Place("the file to write", path))
            found = read_earlier(path)
            refuse_other(path, found, self.sweep, self.file)
            if path == self.first(name) and not self.sweep.needed(name):
                said += replaced(path, found, self.block(name).places)
        return said

    def combine(self, block: str, observable: str, output: Path, progress=lambda s: None) -> None:
        """Write what an observable gave for all runs of a block; raises InputError for another."""
        if observable not in (there := self.observables(block)):
            raise InputError(
                f"observable is {observable!r}; runs of {block} have {', '.join(there)}."
            )
        from dem.sweep.combine import combine

        found, before, own = self.block(block), read_earlier(output), self.file
        combine(self.files(block), self.sweep, found, observable, output, progress, of=own)
        if output == self.first(block) and self.sweep.needed(block):
            self.said += replaced(output, before, found.places)

    def make(self, workers: Workers, progress=lambda done, failed, compiles: None) -> None:
        """Make all that is not there yet, on some workers, but flow.nc (dem.analysis.flow); raises
        RunError. progress is called with how many runs are there, how many of the new ones failed, and
        whether any compiles."""
        for name in self.sweep.blocks:  # a block comes after those that it needs
            self.begin(name)
            there = self.counts()[0]
            new = [each for each in self.batches(name) if not self.store.file_of(each.id).is_file()]
            kept = sum(self.store.run_of(run).is_file() for each in new for run in each.runs)
            before = there - kept
            make_batches(
                self.store, new, workers, lambda n, *more, b=before: progress(b + n, *more)
            )
            del self._plans[name]  # some runs may have been put into batches of their own
            for observable in self.observables(name):
                if observable != "flow":
                    self.combine(name, observable, Path(self.first(name).with_stem(observable)))


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
