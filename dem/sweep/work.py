"""A sweep at work: which files its blocks need, which of them are there, and how all are made."""

import multiprocessing
import signal
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from functools import cached_property
from pathlib import Path

from dem.base.errors import InputError, RunError
from dem.base.files import Place, check_own
from dem.experiment.config import Replicate
from dem.io.results_folder import clear_parts, redate
from dem.sweep.config import CONFIG, Sweep, file_of, load
from dem.sweep.earlier import read_earlier, refuse_other, replaced
from dem.sweep.expand import Block
from dem.sweep.store import FOLDER, Chunk, Store, kernels_of, link_to, plan, settle

LOOK = 0.5  # s between two looks at processes that may compile


class Work:
    """A sweep and the store that holds its runs. Nothing is written before `settle`.

    file: what the sweep is known by, empty where none has it, None where nobody will ask.
    """

    def __init__(self, sweep: Sweep, store: Store | None = None, file: str | None = None):
        self.sweep, self.store, self.file = sweep, store or Store(FOLDER), file
        self._plans: dict[str, tuple[list[Chunk], dict]] = {}
        self._blocks: dict[str, Block] = {}
        self.said: list[str] = []  # sentences to show in the end

    @classmethod
    def of(cls, path: Path, store: Store | None = None) -> "Work":
        """The sweep of a file."""
        sweep = load(path)
        return cls(sweep, store, file_of(sweep, path))

    @cached_property
    def folders(self) -> dict[str, str]:
        """Block by the folder of its combined files."""
        results = self.sweep.results
        if list(self.sweep.blocks) == ["drag"]:
            return {results: "drag"}
        return {f"{results}/{name}": name for name in self.sweep.blocks}

    def folder_of(self, block: str) -> str:
        """Folder of the combined files of a block."""
        return next(folder for folder, name in self.folders.items() if name == block)

    def observables(self, block: str) -> tuple[str, ...]:
        """What the runs of a block record, each a combined file; snapshots stay in the chunks."""
        recorded = self.block(block).runs[0].replicate.configuration.recorded
        return tuple(name for name in recorded if name != "snapshots")

    def needed(self, block: str) -> list[Path]:
        """Combined files of other blocks that the values of a block are derived from."""
        return [
            Path(self.folder_of(name)) / f"{observable}.nc"
            for name in self.sweep.needed(block)
            for observable in self.observables(name)
        ]

    def block(self, name: str) -> Block:
        """All runs of a block; what is derived is as the file has it until it can be known."""
        if name in self._blocks:
            return self._blocks[name]
        needed = self.needed(name)
        if not all(path.is_file() for path in needed):
            return self.sweep.block(name)
        if not needed:
            return self._blocks.setdefault(name, self.sweep.block(name))
        from dem.sweep.derive import derived_by  # with xarray, which a plan does not need

        derived = derived_by(self.sweep, needed)
        return self._blocks.setdefault(name, self.sweep.block(name, derived))

    def chunks(self, block: str) -> list[Chunk]:
        """The chunks that hold the runs of a block."""
        if block not in self._plans:
            for path in self.needed(block):
                if not path.is_file():
                    raise InputError(f"{path}: it is missing; the block {block} needs it first.")
            found = self.block(block).unique()
            results = self.sweep.results
            self._plans[block] = plan(self.store, found, self.sweep.chunk, results, self._own())
        return self._plans[block][0]

    def _own(self) -> dict[str, Chunk]:
        """Chunks of other blocks: those planned so far, and those of the last plan all of whose runs
        are still wanted."""
        wanted = {run for name in self.sweep.blocks for run in self.block(name).places}
        last = self.store.registered(self.sweep.results).values()
        found = {chunk.id: chunk for chunk in last if wanted.issuperset(chunk.runs)}
        return found | {chunk.id: chunk for chunks, _ in self._plans.values() for chunk in chunks}

    def kernels(self, chunk: str) -> str | None:
        """What machine code a chunk needs, None where it is none of those asked for so far."""
        of = (each for chunks, _ in self._plans.values() for each in chunks if each.id == chunk)
        return next((each.kernels for each in of), None)

    def links(self, block: str) -> list[str]:
        """Where the chunks of a block are linked to, in the folder of results; links whose chunk is no
        more in the store are removed, because Snakemake would take them for files."""
        found = [f"{self.sweep.results}/chunks/{chunk.id}.nc" for chunk in self.chunks(block)]
        for place in map(Path, found):
            if place.is_symlink() and not place.exists():
                place.unlink()
        return found

    def files(self, block: str) -> list[Path]:
        """The chunks of a block in the store."""
        return [self.store.file_of(chunk.id) for chunk in self.chunks(block)]

    def combined(self) -> Iterator[tuple[str, Path]]:
        """The combined files that the sweep may write, each with its block."""
        for folder, name in self.folders.items():
            for observable in dict.fromkeys((*self.observables(name), "flow")):
                yield name, Path(folder) / f"{observable}.nc"

    def _first(self, block: str) -> Path:
        """The combined file whose runs are compared; they are known early but for what is derived."""
        return Path(self.folder_of(block)) / f"{self.observables(block)[0]}.nc"

    def check(self, more: Iterable[Path] = ()) -> list[str]:
        """Raise InputError where a file that the sweep writes, or one of `more`, is a link or of another
        kind, or where the folder holds another sweep. Returns a sentence where runs will be gone."""
        results, said = Path(self.sweep.results), []
        for path in (results / CONFIG, *(results / "flow").glob("*.nc"), *more):
            check_own(Place("the file to write", path))
        for name, path in self.combined():
            check_own(Place("the file to write", path))
            found = read_earlier(path)
            refuse_other(path, found, self.sweep, self.file)
            if path == self._first(name) and not self.sweep.needed(name):
                said += replaced(path, found, self.block(name).places)
        return said

    def settle(self) -> None:
        """Write the plans that were asked for so far, and clear the store of half-written files."""
        clear_parts(self.store.folder)
        redate(self.store.folder / "chunks")  # else what is made of them is always older
        for block, (chunks, new) in self._plans.items():
            if new is not None:
                parts = list(self.sweep.blocks)
                settle(self.store, self.sweep.results, block, chunks, new, parts)
                self._plans[block] = chunks, None

    def combine(self, block: str, observable: str, output: Path, progress=lambda s: None) -> None:
        """Write what an observable gave for all runs of a block; raises InputError for another."""
        if observable not in (there := self.observables(block)):
            raise InputError(
                f"observable is {observable!r}; runs of {block} have {', '.join(there)}."
            )
        from dem.sweep.combine import combine

        found, before, own = self.block(block), read_earlier(output), self.file
        combine(self.files(block), self.sweep, found, observable, output, progress, of=own)
        if output == self._first(block) and self.sweep.needed(block):
            self.said += replaced(output, before, found.places)

    def make(self, jobs: int, progress=lambda name, share, compiles: None) -> None:
        """Make all that is not there yet, in some processes, but flow.nc (dem.analysis.flow); raises
        RunError. progress is called as by `make_chunks`, with the name of the block first."""
        for name in self.sweep.blocks:  # a block comes after those that it needs
            files = self.chunks(name)
            self.settle()
            make_chunks(self.store, files, jobs, lambda *s, n=name: progress(n, *s))
            link(self.store, files, self.sweep.results)
            for observable in self.observables(name):
                if observable != "flow":
                    output = Path(self.folder_of(name)) / f"{observable}.nc"
                    self.combine(name, observable, output)


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


def make_chunks(store: Store, chunks: Iterable[Chunk], jobs: int, progress) -> None:
    """Make chunks in some processes; the first of each kind of kernels compiles alone.

    progress is called with the share that is done and whether processes compile beside it: when one
    begins to, and after each chunk. Raises RunError where a process is killed.
    """
    from dem.sweep import chunk as making  # not for those who only ask what there is

    chunks = [chunk for chunk in chunks if not store.file_of(chunk.id).is_file()]
    first = list({chunk.kernels: chunk for chunk in reversed(chunks)}.values())
    rest = [chunk for chunk in chunks if chunk not in first]
    done, told = 0, False
    others = set(multiprocessing.active_children())
    for some in filter(None, (first, rest)):
        context = multiprocessing.get_context("spawn")
        compiles = context.Event()
        with ProcessPoolExecutor(
            min(jobs, len(some)), context, initializer=_begin, initargs=(compiles,)
        ) as pool:
            pending = {pool.submit(making.make, store, chunk.id) for chunk in some}
            try:
                while pending:
                    ready, pending = wait(pending, LOOK, return_when=FIRST_COMPLETED)
                    for future in ready:
                        future.result()
                        done += 1
                    if ready or compiles.is_set() != told:
                        told = compiles.is_set()
                        progress(done / len(chunks), told)
            except BaseException as error:
                pool.shutdown(wait=False, cancel_futures=True)  # not all the others first
                for process in set(multiprocessing.active_children()) - others:
                    process.terminate()  # what is finished is on disk
                if isinstance(error, BrokenProcessPool):
                    raise RunError(
                        "a process of the sweep was killed, perhaps because memory was short; take "
                        "fewer jobs and run the same command again: finished runs are kept."
                    ) from None
                raise


def _begin(compiles) -> None:
    """Prepare a process that makes chunks: Ctrl-C is for the first process, which ends the others."""
    from dem.jit.compilation import when_compiling

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    when_compiling(lambda sentence: compiles.set())


def link(store: Store, chunks: Iterable[Chunk], results: str) -> None:
    """Let a folder of results show its chunks."""
    for chunk in chunks:
        link_to(store.file_of(chunk.id), Path(results) / "chunks" / f"{chunk.id}.nc")


def kinds_of(config: Path, shape: str | None, kernels: str | None) -> Iterator[Replicate]:
    """A run for each kind of machine code that a sweep needs, or the one of a planned chunk."""
    if kernels:
        store = Store(FOLDER)
        for chunk in store.planned().values():
            if chunk.kernels == kernels:
                yield store.replicates(chunk.id)[0]
                return
        raise InputError(f"kernels is {kernels!r}; no planned chunk needs them.")
    sweep, found = load(config), {}
    if shape is not None and shape not in sweep.shapes:
        raise InputError(f"shape is {shape!r}; the configuration has {', '.join(sweep.shapes)}.")
    for block in sweep.blocks:
        for replicate in sweep.block(block).unique():
            if shape in (None, replicate.label):
                found.setdefault(kernels_of(replicate), replicate)
    if not found and shape is not None:
        replicate = Replicate(sweep.changed({}, shape), shape, 1e3, 0)
        found[shape] = replicate
    yield from found.values()
